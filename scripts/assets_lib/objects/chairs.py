"""A toy chair that stacks: splayed legs, a leaning backrest, a cushion."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, hull_of, merge, rod
from assets_lib.prisms import bevelled_box
from assets_lib.urdf import Joint, Link, Model, Shape, Vec3, Visual, box_shape, mesh_shape, metal, patterned

LEG, SHORTER = 0.005, 0.001
"""Thickness of a leg, and height of the middle of its end: no corner is below the floor [m]."""
TOP, FOOT = (0.028, 0.0318, 0.074), (0.0375, 0.0475, SHORTER)
"""Ends of the front left leg [m]."""
SEAT, PLATE, CUSHION = (0.064, 0.059, 0.07), 0.006, (0.058, 0.052, 0.012)
"""Length, width and lower side of the seat, thickness of its plate, and size of the cushion [m]."""
SEAT_X = 0.002
APRON = (0.044, 0.042, 0.012)
"""Size of the frame below the seat, on which a stacked chair rests [m]."""
LEAN, PIVOT = 0.22, (-0.03, 0.072)
"""Slope of the backrest, and x and z of a point on its middle plane [m]."""
BACK, POST = (0.005, 0.058, 0.042), 0.006
"""Thickness, width and height of the backrest, and width of its posts [m]."""
HEIGHT = 0.16


def _leaning(size: Vec3, low: float, y: float) -> tuple[Vec3, Vec3]:
    """Return place and rotation of a box that leans as the backrest does, from its lower end upwards."""
    a = float(np.arctan(LEAN))
    z = low + size[2] * float(np.cos(a)) / 2.0
    return (PIVOT[0] - LEAN * (z - PIVOT[1]), y, z), (0.0, -a, 0.0)


def _leg(x: float, y: float) -> tuple[Vec3, Vec3]:
    """Return the upper and the lower end of a leg, on the sides of the signs `x` and `y`."""
    return (x * TOP[0], y * TOP[1], TOP[2]), (x * FOOT[0], y * FOOT[1], FOOT[2])


def _beam(top: Vec3, foot: Vec3, thickness: float) -> Shape:
    """Return a square beam between two points."""
    along = np.subtract(top, foot)
    length = float(np.linalg.norm(along))
    x, y, z = (float(value) for value in along / length)
    middle = tuple(float(value) for value in np.add(top, foot) / 2.0)
    return box_shape((thickness, thickness, length), middle, (-float(np.arcsin(y)), float(np.arctan2(x, z)), 0.0))  # type: ignore[arg-type]


def _panel(size: Vec3, bevel: float) -> Mesh:
    """Return a panel whose edges are bevelled all round, its middle at the origin."""
    half, inner = np.array(size) / 2.0, np.array(size) / 2.0 - bevel
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return hull_of(np.concatenate([signs * np.where(np.arange(3) == axis, half, inner) for axis in range(3)]))


def _chair() -> Model:
    length, width, under = SEAT
    over = under + PLATE
    legs = [_leg(x, y) for x in (-1.0, 1.0) for y in (-1.0, 1.0)]
    slope = float(np.cos(np.arctan(LEAN)))
    back = _leaning(BACK, HEIGHT - BACK[2] * slope - BACK[0] / 2.0 * float(np.sin(np.arctan(LEAN))), 0.0)
    post = (BACK[0], POST, (HEIGHT - 0.006 - PIVOT[1]) / slope)
    posts = [_leaning(post, PIVOT[1], y * (BACK[1] / 2.0 - POST)) for y in (-1.0, 1.0)]
    apron = (SEAT_X, 0.0, under - APRON[2] / 2.0)
    collisions = (
        box_shape((length, width, PLATE), (SEAT_X, 0.0, under + PLATE / 2.0)),
        box_shape(CUSHION, (SEAT_X, 0.0, over + CUSHION[2] / 2.0)),
        box_shape(APRON, apron),
        *(_beam(top, foot, LEG) for top, foot in legs),
        *(box_shape(post, *place) for place in posts),
        box_shape(BACK, *back),
    )
    steel, wood = metal((0.30, 0.31, 0.33)), patterned((0.62, 0.42, 0.24), "wood")
    visuals = (
        Visual(mesh_shape("seat", bevelled_box((length, width, PLATE), 0.002), (SEAT_X, 0.0, under)), wood),
        Visual(mesh_shape("back", _panel(BACK, 0.002), *back), wood),
        Visual(mesh_shape("legs", merge(rod(top, foot, LEG / 2.0, 10) for top, foot in legs)), steel),
        Visual(mesh_shape("posts", merge(box(post).moved(*place) for place in posts)), steel),
        Visual(box_shape(APRON, apron), steel),
    )
    cushion = mesh_shape("cushion", bevelled_box(CUSHION, 0.003), (SEAT_X, 0.0, over))
    links = (
        Link("chair", 0.115, visuals, collisions, friction=0.5, center=(-0.004, 0.0, 0.07)),
        Link("cushion", 0.005, (Visual(cushion, (0.85, 0.20, 0.18)),), center=(SEAT_X, 0.0, over + 0.006)),
    )
    pitch = over + CUSHION[2] - (under - APRON[2])
    notes = (
        f"faces +x; cushion up to z = {over + CUSHION[2]:.3f}, backrest up to {HEIGHT}, leaning by {LEAN} in x for each 1 in z",
        f"chairs nest straight above each other, {pitch:.3f} apart; recolour the link `cushion`",
    )
    holder = Joint("cushion_holder", "fixed", "chair", "cushion", (0.0, 0.0, 0.0))
    return Model("stacking_chair", "objects/stacking_chair", "bottom centre", links, (holder,), notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_chair(),)
