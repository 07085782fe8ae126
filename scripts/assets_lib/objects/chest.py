"""Chests of drawers: three on four legs, four, three wide ones with knobs, and three of different heights."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from assets_lib.cabinets import bevelled, bevelled_box, cabinet
from assets_lib.mesh import Mesh, box, cylinder, lathe, merge, rod
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
    Paint,
    Shape,
    Visual,
    box_shape,
    cylinder_shape,
    mesh_shape,
    metal,
    patterned,
    plastic,
)

DEPTH = 0.26
SIDE, PANEL, BACK = 0.018, 0.012, 0.008
THICK = 0.015
"""Of the fronts of drawers [m]."""
TRAVEL, SHORT_TRAVEL = 0.22, 0.15
"""How far drawers come out, and how far where a stop holds them [m]."""
BAR_RADIUS = 0.006
KNOB = (0.016, 0.013)
"""Radius and length of the head of a knob [m]."""
HANDLE = (-0.045, 0.0, 0.015)
"""Centre of the handle bar, or of the head of a knob, in the drawer frame [m]."""
OAK, DARK_OAK, PALE = (patterned(color, "wood") for color in ((0.62, 0.42, 0.24), (0.46, 0.29, 0.15), (0.84, 0.69, 0.48)))
STEEL, BRASS = metal((0.30, 0.30, 0.32)), metal((0.85, 0.68, 0.25))
TOP = patterned(plastic((0.66, 0.46, 0.27)), "wood")
HALF_PI = 1.5707963267948966

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True)
class Design:
    """How one chest differs from others; the defaults are those of `chest`. Lengths [m]."""

    name: str
    drawers: tuple[str, ...] = ("bottom", "middle", "top")
    """From below."""
    width: float = 0.34
    height: float = 0.36
    leg: float = 0.045
    foot: tuple[float, float] = (0.03, 0.03)
    """Size of a leg along x and y."""
    shares: tuple[float, ...] = ()
    """Heights of the drawers relative to each other; all the same, if there are none."""
    bar: float = 0.10
    """Length of the handle bars; with 0 the drawers have knobs."""
    body: Paint = OAK
    top: Paint = TOP
    legs: Paint = DARK_OAK
    front: Paint = PALE
    handle: Paint = STEEL

    @property
    def edges(self) -> tuple[float, ...]:
        """Heights between which the drawers are [m]."""
        shares, low = self.shares or (1.0,) * len(self.drawers), self.leg + PANEL
        unit = (self.height - self.leg - 2 * PANEL) / sum(shares)
        return tuple(low + sum(shares[:i]) * unit for i in range(len(shares) + 1))

    @property
    def heights(self) -> tuple[float, ...]:
        """Heights of the middles of the fronts [m]."""
        return tuple((low + high) / 2.0 for low, high in pairwise(self.edges))

    def front_size(self, number: int) -> tuple[float, float, float]:
        """Return the size of the front of a drawer [m]."""
        return (THICK, round(self.width - 0.04, 6), round(self.edges[number + 1] - self.edges[number] - 0.007, 6))


def _carcass(design: Design) -> tuple[Box, ...]:
    """Return the boxes (size, centre) of the fixed part, without legs."""
    leg, height = design.leg, design.height
    middle, inner = (leg + height) / 2.0, design.width - 2 * SIDE
    shift = (design.width - SIDE) / 2.0
    boxes: list[Box] = [((DEPTH, SIDE, height - leg), (0.0, y, middle)) for y in (-shift, shift)]
    boxes += [((DEPTH, inner, PANEL), (0.0, 0.0, z)) for z in (leg + PANEL / 2.0, height - PANEL / 2.0)]
    boxes.append(((BACK, inner, height - leg - 2 * PANEL), ((DEPTH - BACK) / 2.0, 0.0, middle)))
    boxes += [((0.03, inner, 0.003), (-DEPTH / 2.0 + 0.03, 0.0, z)) for z in design.edges[1:-1]]
    return tuple(boxes)


def _shell(design: Design) -> Mesh:
    """Return what is seen of the fixed part: a case that is open to the front, one opening for each drawer."""
    half, inner = design.width / 2.0, design.width / 2.0 - SIDE
    hollows = tuple((low + 0.0015, high - 0.0015) for low, high in pairwise(design.edges))
    spans = ((-DEPTH / 2.0, DEPTH / 2.0), (-half, half), (design.leg, design.height - 0.006))
    return cabinet(*spans, (-inner, inner), hollows, DEPTH - BACK)


def _legs(design: Design) -> tuple[Box, ...]:
    (x, y), leg = design.foot, design.leg
    px, py = round((DEPTH - x) / 2.0 - 0.01, 6), round((design.width - y) / 2.0 - 0.01, 6)
    return tuple(((x, y, leg), (sx * px, sy * py, leg / 2.0)) for sx in (-1, 1) for sy in (-1, 1))


def _back_board(design: Design) -> tuple[Box, ...]:
    """Return the seen lining of the back."""
    leg, height = design.leg, design.height
    return (((0.002, design.width - 0.05, height - leg - 0.05), (DEPTH / 2.0 + 0.001, 0.0, (leg + height) / 2.0)),)


def _tray(front: tuple[float, float, float]) -> tuple[Box, ...]:
    """Return the boxes of one drawer behind its front; the origin is the centre of the front face."""
    back = THICK + 0.22
    middle = (THICK + back) / 2.0
    length, width, low, wall, depth = back - THICK, front[1] - 0.01, 0.005 - front[2] / 2.0, 0.006, front[2] - 0.025
    z = low + depth / 2.0
    return (
        ((length, width, wall), (middle, 0.0, low + wall / 2.0)),
        ((length, wall, depth), (middle, (width - wall) / 2.0, z)),
        ((length, wall, depth), (middle, -(width - wall) / 2.0, z)),
        ((wall, width - 2 * wall, depth), (back - wall / 2.0, 0.0, z)),
    )


def _handle_mesh(length: float) -> Mesh:
    """Return a bar of a length on two posts, or a knob."""
    x, _, z = HANDLE
    if not length:
        radius, deep = KNOB
        rim = ((0.75 * radius, 0.0), (radius, 0.25 * deep), (radius, 0.7 * deep), (0.7 * radius, deep), (0.0, deep))
        neck = [(0.009, deep / 2.0 + x), (0.007, deep / 2.0 + 0.4 * x), (0.007, 0.0)]
        return lathe([*neck, *rim], 18).moved((x + deep / 2.0, 0.0, z), (0.0, -HALF_PI, 0.0))
    bar = rod((x, -length / 2.0, z), (x, length / 2.0, z), BAR_RADIUS, 10)
    return merge([bar, *(rod((x, y, z), (0.0, y, z), 0.005, 8) for y in _posts(length))])


def _posts(length: float) -> tuple[float, ...]:
    """Return where handles of that length are fixed to their fronts, along y."""
    return (0.008 - length / 2.0, length / 2.0 - 0.008) if length else (0.0,)


def _rosettes(length: float) -> Mesh:
    """Return the round plates under the posts of the handle."""
    turn = (0.0, HALF_PI, 0.0)
    return merge(cylinder(0.011, 0.003, 8).moved((-0.0005, y, HANDLE[2]), turn) for y in _posts(length))


def _handle_shapes(length: float) -> tuple[Shape, ...]:
    x, _, z = HANDLE
    turn = (HALF_PI, 0.0, 0.0) if length else (0.0, HALF_PI, 0.0)
    head = cylinder_shape(*((BAR_RADIUS, length) if length else KNOB), HANDLE, turn)
    return (head, *(box_shape((-x, 0.009, 0.009), (x / 2.0, y, z)) for y in _posts(length)))


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _drawer(design: Design, number: int) -> Link:
    size, mark = design.front_size(number), f"_{design.drawers[number]}" if design.shares else ""
    front: Box = (size, (THICK / 2.0, 0.0, 0.0))
    visuals = (
        Visual(mesh_shape(f"front{mark}", bevelled((front,), 0.003)), design.front),
        Visual(mesh_shape("rosettes", _rosettes(design.bar)), design.handle),
        Visual(mesh_shape(f"tray{mark}", _merged(_tray(size))), patterned((0.90, 0.82, 0.68), "wood")),
        Visual(mesh_shape("handle", _handle_mesh(design.bar)), design.handle),
    )
    shapes = tuple(box_shape(size, center) for size, center in (front, *_tray(size)))
    return Link(f"drawer_{design.drawers[number]}_link", 0.6, visuals, (*shapes, *_handle_shapes(design.bar)), friction=0.8)


def _joints(design: Design, travel: float) -> tuple[Joint, ...]:
    """Return the slides of the drawers."""
    places = ((name, (-DEPTH / 2.0, 0.0, z)) for name, z in zip(design.drawers, design.heights, strict=True))
    return tuple(
        Joint(f"drawer_{name}", "prismatic", "chest", f"drawer_{name}_link", place, (-1.0, 0.0, 0.0), 0.0, travel, damping=2.0)
        for name, place in places
    )


def _links(design: Design) -> tuple[Link, ...]:
    fixed = (*_carcass(design), *_legs(design))
    slab = bevelled_box((DEPTH, design.width, 0.014), (0.0, 0.0, design.height - 0.007), 0.004)
    visuals = (
        Visual(mesh_shape("carcass", _shell(design)), design.body),
        Visual(mesh_shape("top", slab), design.top),
        Visual(mesh_shape("legs", bevelled(_legs(design))), design.legs),
        Visual(mesh_shape("back_board", _merged(_back_board(design))), design.front),
    )
    chest = Link("chest", 6.0, visuals, tuple(box_shape(size, center) for size, center in fixed))
    return (chest, *(_drawer(design, number) for number in range(len(design.drawers))))


def _notes(design: Design) -> tuple[str, ...]:
    handle = f"handle bar along y, diameter {2 * BAR_RADIUS}, length {design.bar}, centre"
    free, heads = -HANDLE[0] - BAR_RADIUS, "bars"
    if not design.bar:
        handle, free, heads = f"knob, diameter {2 * KNOB[0]}, length {KNOB[1]}, centre", -HANDLE[0] - KNOB[1] / 2.0, "knobs"
    heights = ", ".join(f"{z:.4f}" for z in design.heights)
    insides = "inside of a drawer: x 0.015..0.229, y -{0:.3f}..{0:.3f}, floor at z = {1} in the drawer link"
    floors = ", ".join(dict.fromkeys(f"{0.011 - design.front_size(i)[2] / 2.0:.3f}" for i in range(len(design.drawers))))
    return (
        "front faces -x; joints pull the drawers along -x; drawers are hollow with a bottom",
        f"drawer links have their origin at the centre of the front face: x = {-DEPTH / 2}, z = {heights} "
        f"({', '.join(name.replace('_', ' ') for name in design.drawers)})",
        f"{handle} {HANDLE} in the drawer link; {free:.3f} m free behind it; heights of the {heads} "
        + ", ".join(f"{z + HANDLE[2]:.4f}" for z in design.heights),
        insides.format(design.width / 2.0 - 0.031, floors),
    )


CHEST = Design("chest")
WHITE, BLUE = plastic((0.93, 0.93, 0.91)), plastic((0.24, 0.42, 0.62))
WALNUT, DARK_WALNUT = (patterned(plastic(color), "wood") for color in ((0.36, 0.22, 0.14), (0.25, 0.15, 0.09)))
SAGE, CREAM = plastic((0.52, 0.62, 0.50)), plastic((0.90, 0.86, 0.76))
OTHERS = (
    Design(
        "chest_tall",
        ("bottom", "lower_middle", "upper_middle", "top"),
        width=0.30,
        height=0.44,
        leg=0.03,
        bar=0.12,
        body=SAGE,
        top=patterned(plastic((0.72, 0.55, 0.36)), "wood"),
        legs=SAGE,
        front=CREAM,
    ),
    Design(
        "chest_with_knobs",
        width=0.42,
        height=0.34,
        leg=0.04,
        foot=(0.05, 0.05),
        bar=0.0,
        body=WHITE,
        top=WHITE,
        legs=BLUE,
        front=BLUE,
        handle=WHITE,
    ),
    Design(
        "chest_graded",
        width=0.32,
        height=0.40,
        leg=0.09,
        foot=(0.018, 0.018),
        shares=(1.3, 1.0, 0.8),
        bar=0.18,
        body=WALNUT,
        top=WALNUT,
        legs=DARK_WALNUT,
        front=DARK_WALNUT,
        handle=BRASS,
    ),
)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    links, origin = _links(CHEST), "bottom centre"
    stops = (f"as chest, but stops hold the drawers after {SHORT_TRAVEL} m",)
    return (
        Model("chest", "objects/chest", origin, links, _joints(CHEST, TRAVEL), _notes(CHEST)),
        Model("chest_with_stops", "objects/chest", origin, links, _joints(CHEST, SHORT_TRAVEL), stops),
        *(Model(d.name, f"objects/{d.name}", origin, _links(d), _joints(d, TRAVEL), _notes(d)) for d in OTHERS),
    )
