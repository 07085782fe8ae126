"""Cardboard boxes with a lid on a hinge: a parcel, and a red gift box with a ribbon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assets_lib.cabinets import bevelled, bevelled_box
from assets_lib.mesh import Mesh, box, cylinder, merge
from assets_lib.prisms import Point, mark
from assets_lib.urdf import Joint, Link, Model, Paint, Visual, box_shape, mesh_shape, patterned

WALL = 0.005
OVERHANG = 0.015
"""How far the lid reaches over the front wall [m]."""
THICK = 0.006
"""Of the lid [m]."""
GAP = 0.001
"""Between the walls and the shut lid [m]."""
RIBBON = 0.024
"""Width of the ribbon of a gift box [m]."""
CARDBOARD, INSIDE, LID_COLOR, TAPE, INK = (
    patterned((0.63, 0.53, 0.42), "cardboard"),
    patterned((0.52, 0.43, 0.33), "cardboard"),
    patterned((0.68, 0.58, 0.46), "cardboard"),
    (0.93, 0.87, 0.66),
    (0.30, 0.16, 0.09),
)

Vec3 = tuple[float, float, float]
Box = tuple[Vec3, Vec3]


@dataclass(frozen=True)
class Design:
    """How one box differs from another; the defaults are those of `carton`. Lengths [m]."""

    name: str = "carton"
    depth: float = 0.16
    width: float = 0.22
    height: float = 0.10
    wall: Paint = CARDBOARD
    inside: Paint = INSIDE
    lid: Paint = LID_COLOR
    tape: Vec3 = TAPE
    ribbon: bool = False
    """Whether it is a gift box: bands around it and a bow, instead of what is printed on a parcel."""

    @property
    def lid_size(self) -> Vec3:
        """Size of the lid."""
        return (self.depth + OVERHANG, self.width, THICK)

    @property
    def hinge(self) -> Vec3:
        """Middle of the hinge."""
        return (self.depth / 2.0, 0.0, self.height)


def _walls(design: Design) -> tuple[Box, ...]:
    """Return the boxes (size, centre) of bottom and walls."""
    depth, width, height = design.depth, design.width, design.height
    x, y, z = (depth - WALL) / 2.0, (width - WALL) / 2.0, (height + WALL) / 2.0
    tall = height - WALL
    return (
        ((depth, width, WALL), (0.0, 0.0, WALL / 2.0)),
        ((WALL, width, tall), (x, 0.0, z)),
        ((WALL, width, tall), (-x, 0.0, z)),
        ((depth - 2 * WALL, WALL, tall), (0.0, y, z)),
        ((depth - 2 * WALL, WALL, tall), (0.0, -y, z)),
    )


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _lining(design: Design) -> tuple[Box, ...]:
    """Return thin sheets that make the inside darker than the outside."""
    t, x, y = 0.0006, design.depth / 2.0 - WALL, design.width / 2.0 - WALL
    tall, z = design.height - WALL - 0.002, WALL + (design.height - WALL - 0.002) / 2.0
    return (
        ((2 * x, 2 * y, t), (0.0, 0.0, WALL + t / 2.0)),
        ((t, 2 * y, tall), (x - t / 2.0, 0.0, z)),
        ((t, 2 * y, tall), (-x + t / 2.0, 0.0, z)),
        ((2 * x, t, tall), (0.0, y - t / 2.0, z)),
        ((2 * x, t, tall), (0.0, -y + t / 2.0, z)),
    )


def _print(design: Design) -> Mesh:
    """Return the marks printed on front and sides: two arrows that point up over a line, two bars, and a field on each side."""
    marks = []
    for y in (0.045, 0.075):
        marks.append(_bar((y, 0.045), (0.006, 0.026)))
        marks.append([(y - 0.010, 0.056), (y + 0.010, 0.056), (y, 0.074)])
    marks += [_bar((0.06, 0.026), (0.06, 0.004)), _bar((-0.055, 0.06), (0.07, 0.008)), _bar((-0.065, 0.042), (0.05, 0.006))]
    x = design.depth / 2.0 + 0.0006
    front = [mark([(-y, z) for y, z in corners], x, "x").moved(rpy=(0.0, 0.0, np.pi)) for corners in marks]
    field = mark(_bar((0.0, 0.05), (0.07, 0.03)), design.width / 2.0 + 0.0006, "x")
    return merge([*front, *(field.moved(rpy=(0.0, 0.0, side * np.pi / 2.0)) for side in (-1, 1))])


def _bar(middle: Point, size: Point) -> list[Point]:
    """Return the corners of a rectangle."""
    return [(middle[0] + sx * size[0] / 2.0, middle[1] + sy * size[1] / 2.0) for sx in (-1, 1) for sy in (-1, 1)]


def _bands(design: Design) -> Mesh:
    """Return the ribbon on the front and on the sides of a gift box."""
    tall, middle = design.height - 0.004, design.height / 2.0
    front = mark(_bar((0.0, middle), (RIBBON, tall)), design.depth / 2.0 + 0.0006, "x")
    sides = mark(_bar((0.0, middle), (RIBBON, tall)), design.width / 2.0 + 0.0006, "x")
    return merge([front.moved(rpy=(0.0, 0.0, np.pi)), *(sides.moved(rpy=(0.0, 0.0, s * np.pi / 2.0)) for s in (-1, 1))])


def _bow(x: float, z: float) -> Mesh:
    """Return the bow on the lid of a gift box: two flat loops and a knot."""
    loop = cylinder(0.017, 0.008, 16, bevel=0.003)
    knot = bevelled_box((0.016, 0.014, 0.010), (x, 0.0, z + 0.005), 0.003)
    return merge([knot, *(loop.moved((x, side * 0.021, z + 0.004)) for side in (-1, 1))])


def _lid_marks(design: Design) -> tuple[Visual, ...]:
    """Return what is on the lid: tape and a label, or a ribbon with its bow."""
    x, z, size = -design.lid_size[0] / 2.0, GAP + THICK + 0.0006, design.lid_size
    if design.ribbon:
        cross = [_bar((x, 0.0), (size[0] - 0.003, RIBBON)), _bar((x, 0.0), (RIBBON, size[1] - 0.003))]
        mesh = merge([*(mark(bar, z + 0.0002 * i, "z") for i, bar in enumerate(cross)), _bow(x, GAP + THICK)])
        return (Visual(mesh_shape("lid_ribbon", mesh), design.tape),)
    return (
        Visual(mesh_shape("lid_tape", mark(_bar((x, 0.0), (size[0] - 0.005, 0.036)), z, "z")), design.tape),
        Visual(mesh_shape("lid_label", mark(_bar((x, -0.062), (0.05, 0.06)), z, "z")), (0.95, 0.95, 0.93)),
    )


def _lid_link(design: Design) -> Link:
    size = design.lid_size
    x, z = -size[0] / 2.0, GAP + THICK / 2.0
    inside = mark(_bar((x, 0.0), (size[0] - 0.01, size[1] - 0.012)), 0.0001, "z").moved(rpy=(np.pi, 0.0, 0.0))
    visuals = (
        Visual(mesh_shape("lid", bevelled_box(size, (x, 0.0, z), 0.002)), design.lid),
        *_lid_marks(design),
        Visual(mesh_shape("lid_inside", inside), design.inside),
    )
    solid = [box_shape(size, (x, 0.0, z))]
    if design.ribbon:
        solid.append(box_shape((0.034, 0.076, 0.008), (x, 0.0, GAP + THICK + 0.004)))
    return Link("lid", 0.06, visuals, tuple(solid), friction=1.0)


def _model(design: Design) -> Model:
    outside = ("ribbon", _bands(design), design.tape) if design.ribbon else ("print", _print(design), INK)
    visuals = (
        Visual(mesh_shape("walls", bevelled(_walls(design), 0.002)), design.wall),
        Visual(mesh_shape("lining", _merged(_lining(design))), design.inside),
        Visual(mesh_shape(*outside[:2]), outside[2]),
    )
    carton = Link("carton", 1.0, visuals, tuple(box_shape(size, center) for size, center in _walls(design)))
    joint = Joint("lid_hinge", "revolute", "carton", "lid", design.hinge, (0.0, 1.0, 0.0), 0.0, 2.85, damping=0.01)
    length, x, y = round(design.lid_size[0], 6), design.depth / 2.0 - WALL, design.width / 2.0 - WALL
    notes = (
        "front faces -x, long side along y; hollow, open on top under the lid; "
        f"inside x -{x:.3f}..{x:.3f}, y -{y:.3f}..{y:.3f}, floor at z = 0.005",
        f"link `lid` has its origin on the hinge at the middle of the back edge {design.hinge}; at 0 it is closed and "
        f"spans x -{length:.3f}..0, z {GAP}..{GAP + THICK:.3f} there, "
        f"{OVERHANG} beyond the front wall; it opens upwards and backwards",
        f"middle of the free edge {(-length, 0.0, GAP + THICK / 2.0)} in `lid`",
    )
    return Model(design.name, f"objects/{design.name}", "bottom centre", (carton, _lid_link(design)), (joint,), notes)


GIFT_BOX = Design(
    "gift_box",
    depth=0.15,
    width=0.18,
    height=0.12,
    wall=patterned((0.66, 0.13, 0.18), "cardboard"),
    inside=patterned((0.90, 0.86, 0.78), "cardboard"),
    lid=patterned((0.72, 0.16, 0.21), "cardboard"),
    tape=(0.95, 0.82, 0.42),
    ribbon=True,
)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_model(Design()), _model(GIFT_BOX))
