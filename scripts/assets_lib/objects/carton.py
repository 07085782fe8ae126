"""A cardboard box with a lid on a hinge."""

from __future__ import annotations

import numpy as np

from assets_lib.cabinets import bevelled, bevelled_box
from assets_lib.mesh import Mesh, box, merge
from assets_lib.prisms import Point, mark
from assets_lib.urdf import Joint, Link, Model, Visual, box_shape, mesh_shape, patterned

DEPTH, WIDTH, HEIGHT, WALL = 0.16, 0.22, 0.10, 0.005
OVERHANG = 0.015
"""How far the lid reaches over the front wall [m]."""
LID = (DEPTH + OVERHANG, WIDTH, 0.006)
GAP = 0.001
"""Between the walls and the shut lid [m]."""
HINGE = (DEPTH / 2.0, 0.0, HEIGHT)
CARDBOARD, INSIDE, LID_COLOR, TAPE, INK = (
    patterned((0.63, 0.53, 0.42), "cardboard"),
    patterned((0.52, 0.43, 0.33), "cardboard"),
    patterned((0.68, 0.58, 0.46), "cardboard"),
    (0.93, 0.87, 0.66),
    (0.30, 0.16, 0.09),
)

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _walls() -> tuple[Box, ...]:
    """Return the boxes (size, centre) of bottom and walls."""
    x, y, z = (DEPTH - WALL) / 2.0, (WIDTH - WALL) / 2.0, (HEIGHT + WALL) / 2.0
    tall = HEIGHT - WALL
    return (
        ((DEPTH, WIDTH, WALL), (0.0, 0.0, WALL / 2.0)),
        ((WALL, WIDTH, tall), (x, 0.0, z)),
        ((WALL, WIDTH, tall), (-x, 0.0, z)),
        ((DEPTH - 2 * WALL, WALL, tall), (0.0, y, z)),
        ((DEPTH - 2 * WALL, WALL, tall), (0.0, -y, z)),
    )


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _lining() -> tuple[Box, ...]:
    """Return thin sheets that make the inside darker than the outside."""
    t, x, y = 0.0006, DEPTH / 2.0 - WALL, WIDTH / 2.0 - WALL
    tall, z = HEIGHT - WALL - 0.002, WALL + (HEIGHT - WALL - 0.002) / 2.0
    return (
        ((2 * x, 2 * y, t), (0.0, 0.0, WALL + t / 2.0)),
        ((t, 2 * y, tall), (x - t / 2.0, 0.0, z)),
        ((t, 2 * y, tall), (-x + t / 2.0, 0.0, z)),
        ((2 * x, t, tall), (0.0, y - t / 2.0, z)),
        ((2 * x, t, tall), (0.0, -y + t / 2.0, z)),
    )


def _print() -> Mesh:
    """Return the marks printed on front and sides: two arrows that point up over a line, two bars, and a field on each side."""
    marks = []
    for y in (0.045, 0.075):
        marks.append(_bar((y, 0.045), (0.006, 0.026)))
        marks.append([(y - 0.010, 0.056), (y + 0.010, 0.056), (y, 0.074)])
    marks += [_bar((0.06, 0.026), (0.06, 0.004)), _bar((-0.055, 0.06), (0.07, 0.008)), _bar((-0.065, 0.042), (0.05, 0.006))]
    front = [mark([(-y, z) for y, z in corners], DEPTH / 2.0 + 0.0006, "x").moved(rpy=(0.0, 0.0, np.pi)) for corners in marks]
    field = mark(_bar((0.0, 0.05), (0.07, 0.03)), WIDTH / 2.0 + 0.0006, "x")
    return merge([*front, *(field.moved(rpy=(0.0, 0.0, side * np.pi / 2.0)) for side in (-1, 1))])


def _bar(middle: Point, size: Point) -> list[Point]:
    """Return the corners of a rectangle."""
    return [(middle[0] + sx * size[0] / 2.0, middle[1] + sy * size[1] / 2.0) for sx in (-1, 1) for sy in (-1, 1)]


def _lid_link() -> Link:
    x, z = -LID[0] / 2.0, GAP + LID[2] / 2.0
    top = GAP + LID[2] + 0.0006
    inside = mark(_bar((x, 0.0), (LID[0] - 0.01, LID[1] - 0.012)), 0.0001, "z").moved(rpy=(np.pi, 0.0, 0.0))
    visuals = (
        Visual(mesh_shape("lid", bevelled_box(LID, (x, 0.0, z), 0.002)), LID_COLOR),
        Visual(mesh_shape("lid_tape", mark(_bar((x, 0.0), (LID[0] - 0.005, 0.036)), top, "z")), TAPE),
        Visual(mesh_shape("lid_label", mark(_bar((x, -0.062), (0.05, 0.06)), top, "z")), (0.95, 0.95, 0.93)),
        Visual(mesh_shape("lid_inside", inside), INSIDE),
    )
    return Link("lid", 0.06, visuals, (box_shape(LID, (x, 0.0, z)),), friction=1.0)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    visuals = (
        Visual(mesh_shape("walls", bevelled(_walls(), 0.002)), CARDBOARD),
        Visual(mesh_shape("lining", _merged(_lining())), INSIDE),
        Visual(mesh_shape("print", _print()), INK),
    )
    carton = Link("carton", 1.0, visuals, tuple(box_shape(size, center) for size, center in _walls()))
    joint = Joint("lid_hinge", "revolute", "carton", "lid", HINGE, (0.0, 1.0, 0.0), 0.0, 2.85, damping=0.01)
    notes = (
        "front faces -x, long side along y; hollow, open on top under the lid; "
        "inside x -0.075..0.075, y -0.105..0.105, floor at z = 0.005",
        f"link `lid` has its origin on the hinge at the middle of the back edge {HINGE}; at 0 it is shut and "
        f"spans x -{LID[0]:.3f}..0, z {GAP}..{GAP + LID[2]:.3f} there, "
        f"{OVERHANG} beyond the front wall; it opens upwards and backwards",
        f"middle of the free edge {(-LID[0], 0.0, GAP + LID[2] / 2.0)} in `lid`",
    )
    return (Model("carton", "objects/carton", "bottom centre", (carton, _lid_link()), (joint,), notes),)
