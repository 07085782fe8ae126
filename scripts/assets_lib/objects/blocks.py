"""Coloured cubes, a floating ball, a floating ring and flat squares."""

from __future__ import annotations

import numpy as np

from assets_lib.cabinets import bevelled_box
from assets_lib.mesh import icosphere, lathe
from assets_lib.urdf import Link, Model, Visual, box_shape, glossy, mesh_shape, plastic

RED, PALE = (0.9, 0.1, 0.1), (1.0, 0.62, 0.55)
EDGE, CHAMFER = 0.002, 0.0075
"""Bevel of a cube, and of the chamfered one [m]."""
CUBES = (
    ("cube", 0.05, 0.1, EDGE),
    ("cube_small", 0.04, 0.05, EDGE),
    ("cube_45", 0.045, 0.06, EDGE),
    ("block_60", 0.06, 0.12, EDGE),
    ("cube_chamfered", 0.05, 0.1, CHAMFER),
)
"""Name, side [m], mass [kg], bevel [m]."""
BALL = 0.05
"""Diameter of the ball [m]."""
RING, TUBE = 0.041, 0.007
"""Radius of the circle in the middle of the ring, and half its thickness [m]; a cube of 0.045 passes through at every yaw."""
THIN = 0.0045
"""Half the thickness of the ring across its circle, as it is seen [m]."""


def cube(name: str, side: float, mass: float, bevel: float) -> Model:
    """Return a cube; the bevel of its edges is visual only, so that all cubes behave alike."""
    size = (side, side, side)
    seen = mesh_shape("cube", bevelled_box(size, bevel=bevel))
    link = Link(name, mass, (Visual(seen, plastic(RED), crease=0.1),), (box_shape(size),), friction=0.8)
    return Model(name, f"objects/{name}", "centre", (link,), notes=(f"rests with its origin at {side / 2} m",))


def ball_marker() -> Model:
    """Return a ball that is only seen."""
    shape = mesh_shape("ball", icosphere(BALL / 2.0, 2))
    link = Link("ball_marker", 0.01, (Visual(shape, glossy(RED), crease=3.0),))
    return Model("ball_marker", "objects/ball_marker", "centre", (link,), notes=("visual only: use it with fixed = true",))


def ring_marker() -> Model:
    """Return a level ring that is only seen, the place that something is lifted to."""
    angles = np.pi / 3.0 * np.arange(7)
    spread = [(RING + TUBE * float(np.cos(a)), TUBE * float(np.sin(a))) for a in angles]
    high = TUBE * float(np.sin(np.pi / 3.0))
    section = [(RING + TUBE - THIN + THIN * float(np.cos(a)), high * float(np.sin(a))) for a in np.pi / 4.0 * np.arange(9)]
    shape = mesh_shape("ring", lathe(section, 48))
    link = Link("ring_marker", 0.01, (Visual(shape, plastic(PALE), crease=3.0),), weighs=(mesh_shape("", lathe(spread, 20)),))
    across = 2.0 * (RING + TUBE)
    notes = (f"visual only: use it with fixed = true; level, {across:.3f} across, {across - 4.0 * THIN:.3f} inside",)
    return Model("ring_marker", "objects/ring_marker", "centre", (link,), notes=notes)


def target_square() -> Model:
    """Return a flat green square that is only seen."""
    shape = box_shape((0.10, 0.10, 0.002), (0.0, 0.0, 0.001))
    link = Link("target_square", 0.01, (Visual(shape, (0.1, 0.75, 0.2)),))
    notes = ("visual only: use it with fixed = true", "its upper side is 2 mm above the table")
    return Model("target_square", "objects/target_square", "bottom centre", (link,), notes=notes)


def building_strip() -> Model:
    """Return a flat strip with an outline that is only seen: the place for a row of three small cubes."""
    outline = Visual(box_shape((0.06, 0.16, 0.001), (0.0, 0.0, 0.0005)), (0.35, 0.33, 0.30))
    field = Visual(box_shape((0.054, 0.154, 0.0014), (0.0, 0.0, 0.0007)), (0.90, 0.87, 0.80))
    link = Link("building_strip", 0.01, (outline, field))
    notes = ("visual only: use it with fixed = true", "the row is along y")
    return Model("building_strip", "objects/building_strip", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (*(cube(*c) for c in CUBES), ball_marker(), ring_marker(), target_square(), building_strip())
