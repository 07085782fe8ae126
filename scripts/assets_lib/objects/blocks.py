"""Coloured cubes, floating balls and a floating ring, and flat squares."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, box, icosphere, lathe, merge, rod
from assets_lib.urdf import Joint, Link, Model, Paint, Visual, box_shape, mesh_shape, pane, plastic, shining

RED = (0.9, 0.1, 0.1)
CUBES = (("cube", 0.05, 0.1), ("cube_small", 0.04, 0.05), ("cube_45", 0.045, 0.06), ("block_60", 0.06, 0.12))
"""Name, side [m], mass [kg]."""
BALL = 0.05
"""Diameter of the ball [m]."""
RING, TUBE = 0.041, 0.007
"""Radius of the circle in the middle of the ring, and half its thickness [m]; a cube of 0.045 passes through at every yaw."""


STEM, HANGS = 0.46, 0.2
"""How far the stem goes down from the middle of a ball, and how high the ring is over the table [m]."""
STEM_GRAY, HALO = (0.45, 0.47, 0.50), (0.15, 0.95, 0.25)
HALO_NOTE = f"link `halo` is not seen; coloured {HALO} it shines"


def cube(name: str, side: float, mass: float) -> Model:
    """Return a plain cube."""
    shape = box_shape((side, side, side))
    link = Link(name, mass, (Visual(shape, RED),), (shape,), friction=0.8)
    return Model(name, f"objects/{name}", "centre", (link,), notes=(f"rests with its origin at {side / 2} m",))


def ball_marker() -> Model:
    """Return a ball that is only seen."""
    shape = mesh_shape("ball", icosphere(BALL / 2.0, 2))
    link = Link("ball_marker", 0.01, (Visual(shape, plastic(RED), crease=3.0),))
    return Model("ball_marker", "objects/ball_marker", "centre", (link,), notes=("visual only: use it with fixed = true",))


def ball_stem() -> Model:
    """Return a thin stem that shows where a ball is over the table, with a halo that a task lights."""
    stem = Visual(mesh_shape("stem", rod((0.0, 0.0, -STEM), (0.0, 0.0, -BALL / 2.0), 0.0018, 5)), STEM_GRAY)
    links = (Link("ball_stem", 0.001, (stem,)), _halo(BALL / 2.0 + 0.011))
    holder = Joint("halo_holder", "fixed", "ball_stem", "halo", (0.0, 0.0, 0.0))
    notes = ("visual only: use it with fixed = true", f"goes down by {STEM}, into the table", HALO_NOTE)
    return Model("ball_stem", "objects/ball_stem", "middle of the ball", links, (holder,), notes)


def _section(radius: float, tube: float, sides: int = 8) -> FloatArray:
    """Return the closed outline (n, 2) of a ring: distance from its axis, and z."""
    angles = 2.0 * np.pi / sides * np.arange(sides + 1)
    return np.column_stack([radius + tube * np.cos(angles), tube * np.sin(angles)])


def _halo(radius: float) -> Link:
    """Return a thin level ring that shines once a task colours it."""
    ring = lathe([(float(r), float(z)) for r, z in _section(radius, 0.0032, 4)], 20)
    return Link("halo", 0.001, (Visual(mesh_shape("halo", ring), Paint(HALO, opacity=0.0, emission=HALO), crease=3.0),))


def _arcs(first: int) -> Mesh:
    """Return every other of twelve pieces of the ring, from the piece `first` on."""
    section = _section(RING, TUBE, 6)
    rows, columns = 2, len(section)
    pieces = []
    for piece in range(first, 12, 2):
        angles = np.pi / 6.0 * (piece + np.arange(rows + 1) / rows)
        vertices = np.array([(r * np.cos(a), r * np.sin(a), z) for a in angles for r, z in section])
        faces = []
        for i in range(rows):
            for k in range(columns - 1):
                here, there = i * columns + k, (i + 1) * columns + k
                faces += [(here, there, there + 1), (here, there + 1, here + 1)]
        pieces.append(Mesh(vertices, np.array(faces)))
    return merge(pieces)


def ring_marker() -> Model:
    """Return a level ring that is only seen, the place that something is lifted to."""
    visuals = (
        Visual(mesh_shape("red_pieces", _arcs(0)), plastic((0.80, 0.13, 0.11)), crease=1.2),
        Visual(mesh_shape("white_pieces", _arcs(1)), plastic((0.96, 0.96, 0.94)), crease=1.2),
    )
    across = 2.0 * (RING + TUBE)
    notes = (f"visual only: use it with fixed = true; level, {across:.3f} across, {2.0 * (RING - TUBE):.3f} inside",)
    return Model("ring_marker", "objects/ring_marker", "centre", (Link("ring_marker", 0.01, visuals),), notes=notes)


def ring_guide() -> Model:
    """Return a dashed plumb line from a ring to its mark on the table, and a halo that a task lights."""
    dashes = merge(box((0.002, 0.002, 0.012), (0.0, 0.0, -0.03 - 0.02 * k)) for k in range(9))
    inner, outer, low, high = RING - TUBE, RING + TUBE, -HANGS + 0.0002, -HANGS + 0.001
    foot = lathe([(outer, low), (outer, high), (inner, high), (inner, low), (outer, low)], 16)
    visuals = (Visual(mesh_shape("plumb_line", merge([dashes, foot])), pane((0.75, 0.12, 0.10), 0.55)),)
    links = (Link("ring_guide", 0.001, visuals), _halo(RING + TUBE + 0.005))
    holder = Joint("halo_holder", "fixed", "ring_guide", "halo", (0.0, 0.0, 0.0))
    notes = ("visual only: use it with fixed = true", f"it ends {HANGS} below, at the table", HALO_NOTE)
    return Model("ring_guide", "objects/ring_guide", "centre of the ring", links, (holder,), notes)


def target_square() -> Model:
    """Return a flat green square that is only seen."""
    shape = box_shape((0.10, 0.10, 0.002), (0.0, 0.0, 0.001))
    link = Link("target_square", 0.01, (Visual(shape, shining((0.1, 0.75, 0.2), emission=HALO)),))
    notes = ("visual only: use it with fixed = true", "its upper side is 2 mm above the table", f"coloured {HALO} it shines")
    return Model("target_square", "objects/target_square", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (*(cube(*c) for c in CUBES), ball_marker(), ball_stem(), ring_marker(), ring_guide(), target_square())
