"""A base for three square pillars, one such pillar, and a square ring with a bar to hold it by."""

from __future__ import annotations

from assets_lib.mesh import box, merge
from assets_lib.prisms import bevelled_box
from assets_lib.urdf import Link, Model, Shape, Visual, box_shape, mesh_shape

BASE = (0.10, 0.34, 0.02)
PILLAR = (0.03, 0.03, 0.10)
PITCH = 0.11
"""Distance of neighbouring pillars [m]."""
RING, HOLE, THICKNESS = 0.10, 0.042, 0.02
BAR = (0.05, 0.022, 0.024)
SLATE, EDGE = (0.40, 0.46, 0.53), (0.25, 0.29, 0.34)
CREAM, GRIP = (0.94, 0.90, 0.80), (0.22, 0.22, 0.25)


def _base() -> Model:
    places = [(0.0, i * PITCH, BASE[2]) for i in (-1, 0, 1)]
    rims = merge(box((0.04, 0.04, 0.0008), place) for place in places)
    visuals = (Visual(mesh_shape("board", bevelled_box(BASE, 0.004)), SLATE), Visual(mesh_shape("rims", rims), EDGE))
    link = Link("peg_base", 1.5, visuals, (box_shape(BASE, (0.0, 0.0, BASE[2] / 2.0)),))
    notes = (f"square pillars stand on it at y = -{PITCH}, 0, {PITCH}, their feet at z = {BASE[2]}",)
    return Model("peg_base", "objects/peg_base", "bottom centre", (link,), notes=notes)


def _pillar() -> Model:
    visuals = (Visual(mesh_shape("pillar", bevelled_box(PILLAR, 0.003)), (0.9, 0.1, 0.1)),)
    link = Link("square_pillar", 0.1, visuals, (box_shape(PILLAR, (0.0, 0.0, PILLAR[2] / 2.0)),))
    return Model("square_pillar", "objects/square_pillar", "bottom centre", (link,), notes=(f"{PILLAR} m",))


def _sides() -> tuple[Shape, ...]:
    """Return the four sides of the ring as boxes."""
    width = (RING - HOLE) / 2.0
    middle = (RING + HOLE) / 4.0
    along_y = [box_shape((width, RING, THICKNESS), (side * middle, 0.0, 0.0)) for side in (-1.0, 1.0)]
    return (*along_y, *(box_shape((HOLE, width, THICKNESS), (0.0, side * middle, 0.0)) for side in (-1.0, 1.0)))


def _ring() -> Model:
    bar = box_shape(BAR, (RING / 2.0 + BAR[0] / 2.0, 0.0, (BAR[2] - THICKNESS) / 2.0))
    sides = _sides()
    band = merge(box(side.size, side.xyz) for side in sides)
    visuals = (
        Visual(mesh_shape("ring", band), CREAM),
        Visual(mesh_shape("bar", bevelled_box(BAR, 0.003).moved((bar.xyz[0], 0.0, -THICKNESS / 2.0))), GRIP),
    )
    link = Link("square_ring", 0.12, visuals, (*sides, bar), friction=0.9)
    notes = (
        f"{RING} outside, hole {HOLE}, {THICKNESS} thick; rests with its origin at {THICKNESS / 2.0} m",
        f"bar {BAR} along +x from x = {RING / 2.0} to {RING / 2.0 + BAR[0]}, upper side at z = {BAR[2] - THICKNESS / 2.0:.3f}; "
        "grasp it across y",
    )
    return Model("square_ring", "objects/square_ring", "centre of the hole", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_base(), _pillar(), _ring())
