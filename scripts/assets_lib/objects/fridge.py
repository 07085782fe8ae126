"""Upright fridges with two doors on the left edge and three shelves: a mint one, and a red one that is lower and narrower."""

from __future__ import annotations

from dataclasses import dataclass

from assets_lib.cabinets import bevelled, cabinet, rectangle_at
from assets_lib.mesh import Mesh, box, cylinder, icosphere, merge, rod
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
    Paint,
    Shape,
    Visual,
    box_shape,
    cylinder_shape,
    glossy,
    mesh_shape,
    metal,
    plastic,
    shining,
)

DEPTH, FOOT, WALL = 0.30, 0.012, 0.015
THICK, GAP = 0.03, 0.002
"""Of the doors, and between them and the body [m]."""
FRONT = -DEPTH / 2.0 + THICK + GAP
"""x of the front of the body behind the doors [m]."""
BACK = DEPTH / 2.0 - WALL
SHELF_FRONT = FRONT + 0.052
"""The shelves leave room for the racks of the upper door [m]."""
HANDLE = (-THICK - 0.056, 0.048)
"""x of the handle bars in the doors' frames, and how far they are from the free edges [m]."""
BAR_RADIUS, SEEN_RADIUS = 0.007, 0.0085
"""Of a handle bar where it is grasped, and as it is seen [m]."""
MINT, WHITE, INSIDE = plastic((0.42, 0.70, 0.68)), (0.95, 0.96, 0.96), (0.88, 0.92, 0.94)
DARK, CHROME, SEAL = (0.14, 0.14, 0.15), metal((0.84, 0.85, 0.88)), (0.30, 0.32, 0.33)
BRIGHT, GROOVE = glossy((0.93, 0.94, 0.95), 0.15), (0.31, 0.54, 0.53)
RED, DARK_RED = plastic((0.66, 0.10, 0.10)), (0.44, 0.06, 0.06)
HALF_PI = 1.57079633

Vec3 = tuple[float, float, float]
Box = tuple[Vec3, Vec3]
Span = tuple[float, float]


@dataclass(frozen=True)
class Design:
    """How one fridge differs from another; the defaults are those of `fridge`. Lengths [m]."""

    name: str = "fridge"
    width: float = 0.36
    height: float = 0.60
    upper: Span = (0.218, 0.598)
    """Lowest and highest z of the upper door."""
    lower: Span = (0.014, 0.214)
    """Lowest and highest z of the lower door."""
    floors: Span = (0.027, 0.224)
    """Heights of the floors of both compartments."""
    shelves: tuple[float, ...] = (0.12, 0.305, 0.52)
    """Heights of the upper sides of the shelves."""
    upper_bar: Span = (-0.09, 0.20)
    """Middle height of the upper handle bar in the frame of its door, and its length."""
    lower_bar: Span = (0.02, 0.10)
    body: Paint = MINT
    groove: Vec3 = GROOVE
    handle: Paint = BRIGHT

    @property
    def half(self) -> float:
        """Half of its width."""
        return self.width / 2.0

    @property
    def inner(self) -> float:
        """Half of the width inside."""
        return self.half - WALL


def _between(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Box:
    """Return size and centre of the box between bounds."""
    size = (x[1] - x[0], y[1] - y[0], z[1] - z[0])
    return (size, ((x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0, (z[0] + z[1]) / 2.0))


def _walls(design: Design) -> tuple[Box, ...]:
    """Return the boxes (size, centre) around both compartments."""
    half, depth, floors = design.half, (FRONT, DEPTH / 2.0), design.floors
    level = (floors[0], design.height - WALL)
    return (
        _between(depth, (-half, half), (FOOT, floors[0])),
        _between(depth, (-half, half), (design.height - WALL, design.height)),
        _between(depth, (half - WALL, half), level),
        _between(depth, (-half, -half + WALL), level),
        _between((BACK, DEPTH / 2.0), (-half + WALL, half - WALL), level),
        _between((FRONT, BACK), (-half + WALL, half - WALL), (floors[1] - WALL, floors[1])),
    )


def _shell(design: Design) -> Mesh:
    """Return the shell around both compartments."""
    half, hollows = design.half, _hollows(design)
    inner = (-half + WALL, half - WALL)
    return cabinet((FRONT, DEPTH / 2.0), (-half, half), (FOOT, design.height), inner, hollows, BACK - FRONT)


def _hollows(design: Design) -> tuple[Span, Span]:
    """Return what both compartments span along z."""
    low, high = design.floors
    return ((low, high - WALL), (high, design.height - WALL))


def _shelves(design: Design) -> tuple[Box, ...]:
    half = design.inner
    fronts = (FRONT + 0.02, SHELF_FRONT, SHELF_FRONT)
    return tuple(_between((x, BACK), (-half, half), (z - 0.006, z)) for x, z in zip(fronts, design.shelves, strict=True))


def _food(design: Design) -> tuple[tuple[str, Box, tuple[float, float, float]], ...]:
    """Return name, box and colour of what lies below the middle shelf and on the upper one."""
    low, high, side = design.floors[1], design.shelves[2], round(design.inner - 0.01, 6)
    return (
        ("crisper", _between((SHELF_FRONT, 0.12), (-side, side), (low, low + 0.055)), (0.55, 0.80, 0.42)),
        ("butter", _between((-0.01, 0.10), (0.06, 0.12), (high, high + 0.04)), (0.98, 0.85, 0.30)),
        ("jam", _between((0.0, 0.06), (-0.02, 0.03), (high, high + 0.055)), (0.78, 0.12, 0.16)),
        ("milk", _between((0.0, 0.08), (-0.13, -0.07), (high, high + 0.058)), (0.25, 0.45, 0.85)),
    )


def _feet(design: Design) -> tuple[Box, ...]:
    side = round(design.half - 0.03, 6)
    return tuple(((0.04, 0.04, FOOT), (x, y, FOOT / 2.0)) for x in (-0.08, 0.12) for y in (-side, side))


def _lining(design: Design) -> Mesh:
    """Return thin sheets that make the inside white."""
    t, half = 0.001, design.inner
    sheets = []
    for low, high in _hollows(design):
        sheets += [_between((FRONT, BACK), (side - t, side + t), (low, high)) for side in (-half, half)]
        sheets += [_between((FRONT, BACK), (-half, half), (z - t, z + t)) for z in (low, high)]
        sheets.append(_between((BACK - t, BACK + t), (-half, half), (low, high)))
    return _merged(tuple(sheets))


def _coil(design: Design) -> Mesh:
    """Return the pipes on the back, seen by the front camera."""
    x, side = DEPTH / 2.0 + 0.006, round(design.half - 0.04, 6)
    runs = [box((0.006, 2 * side, 0.007), (x, 0.0, 0.20 + 0.045 * i)) for i in range(8)]
    bends = [box((0.006, 0.007, 0.045), (x, (side if i % 2 else -side), 0.2225 + 0.045 * i)) for i in range(7)]
    return merge([*runs, *bends, *(box((0.008, 0.006, 0.36), (x - 0.002, y, 0.36)) for y in (-0.09, 0.09))])


def _compressor(design: Design) -> Box:
    side = round(design.half - 0.05, 6)
    return _between((DEPTH / 2.0, DEPTH / 2.0 + 0.012), (-side, side), (0.03, 0.15))


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _body_link(design: Design) -> Link:
    food = _food(design)
    visuals = (
        Visual(mesh_shape("shell", _shell(design)), design.body),
        Visual(mesh_shape("lining", _lining(design)), INSIDE),
        Visual(mesh_shape("shelves", _merged(_shelves(design))), (0.62, 0.74, 0.80)),
        Visual(mesh_shape("feet", _merged((*_feet(design), *_plinth(design)))), DARK),
        Visual(mesh_shape("coil", _coil(design)), DARK),
        Visual(mesh_shape("compressor", _merged((_compressor(design),))), (0.30, 0.31, 0.33)),
        *(Visual(mesh_shape(name, _merged((part,))), color) for name, part, color in food),
    )
    solid = (*_walls(design), *_shelves(design), *_feet(design), _compressor(design), *(part for _, part, _ in food))
    side = round(design.half - 0.036, 6)
    coil = _between((DEPTH / 2.0, DEPTH / 2.0 + 0.009), (-side, side), (0.19, 0.54))
    return Link("fridge", 20.0, visuals, tuple(box_shape(size, center) for size, center in (*solid, coil)))


def _handle(y: float, z: float, length: float) -> tuple[Mesh, tuple[Shape, ...]]:
    """Return a vertical bar on two posts."""
    x = HANDLE[0]
    reach = -x - THICK
    ends = tuple(z + side * (length / 2.0 - 0.012) for side in (-1, 1))
    bar = rod((x, y, z - length / 2.0), (x, y, z + length / 2.0), SEEN_RADIUS, 14)
    posts = tuple(box((reach, 0.014, 0.018), (x + reach / 2.0, y, e)) for e in ends)
    stays = tuple(box_shape((reach, 0.012, 0.014), (x + reach / 2.0, y, e)) for e in ends)
    return merge([bar, *posts]), (cylinder_shape(BAR_RADIUS, length, (x, y, z)), *stays)


def _bolted_plates(y: float, z: float, length: float) -> Mesh:
    """Return the plates by which a handle is fixed to its door."""
    ends = (z + side * (length / 2.0 - 0.012) for side in (-1, 1))
    return merge(box((0.004, 0.026, 0.028), (-THICK - 0.001, y, end)) for end in ends)


def _seal(width: float, tall: float) -> Mesh:
    """Return the rubber around the inner side of a door, seen when it is open."""
    y, z, wide = (-width + 0.006, -0.006), (-tall / 2.0 + 0.006, tall / 2.0 - 0.006), 0.016
    strips = [((y[0], y[0] + wide), z), ((y[1] - wide, y[1]), z), (y, (z[0], z[0] + wide)), (y, (z[1] - wide, z[1]))]
    # a rectangle is seen from -x, turned about z from +x
    return merge(rectangle_at(-0.0012, (-own[1], -own[0]), high) for own, high in strips).moved(rpy=(0.0, 0.0, 2.0 * HALF_PI))


def _groove(width: float, tall: float) -> Mesh:
    """Return the line that is pressed into the front of a door, around its panel."""
    inset, wide = 0.024, 0.0035
    y, z = (-width + inset, -inset), (inset - tall / 2.0, tall / 2.0 - inset)
    strips = [((y[0], y[0] + wide), z), ((y[1] - wide, y[1]), z)]
    strips += [((y[0] + wide, y[1] - wide), span) for span in ((z[0], z[0] + wide), (z[1] - wide, z[1]))]
    return merge(rectangle_at(-THICK - 0.0006, *strip) for strip in strips)


def _plinth(design: Design) -> tuple[Box, ...]:
    """Return the dark board below the doors and the rubber between them."""
    half = design.half
    return (
        _between((FRONT - 0.004, DEPTH / 2.0 - 0.01), (0.006 - half, half - 0.006), (0.0, FOOT)),
        _between((FRONT - GAP - THICK + 0.005, FRONT), (0.004 - half, half - 0.004), (design.lower[1], design.upper[0])),
    )


def _racks(width: float, tall: float) -> tuple[Box, ...]:
    """Return the racks on the inner side of the upper door: floor and front board of each."""
    far = round(width - 0.04, 6)
    racks: list[Box] = []
    for z in (-tall / 2.0 + 0.03, 0.03):
        racks.append(_between((0.0, 0.042), (-far, -0.045), (z, z + 0.006)))
        racks.append(_between((0.037, 0.042), (-far, -0.045), (z + 0.006, z + 0.045)))
    return tuple(racks)


def _door_link(design: Design, name: str, bounds: Span, bar: Span, mass: float) -> Link:
    """Return a door; its origin is on the hinge at half its height."""
    width, tall = design.width, bounds[1] - bounds[0]
    slab: Box = ((THICK, width, tall), (-THICK / 2.0, -width / 2.0, 0.0))
    pad: Box = ((0.002, width - 0.05, tall - 0.05), (0.001, -width / 2.0, 0.0))
    place = (round(HANDLE[1] - width, 6), *bar)
    handle, shapes = _handle(*place)
    visuals = [
        Visual(mesh_shape(f"{name}_door", bevelled((slab,), 0.004)), design.body),
        Visual(mesh_shape(f"{name}_groove", _groove(width, tall)), design.groove),
        Visual(mesh_shape(f"{name}_pad", _merged((pad,))), WHITE),
        Visual(mesh_shape(f"{name}_seal", _seal(width, tall)), SEAL),
        Visual(mesh_shape(f"{name}_handle", merge([handle, _bolted_plates(*place)])), design.handle),
    ]
    solid: list[Box] = [slab]
    if name == "upper":
        racks = _racks(width, tall)
        solid += racks
        bottles = [cylinder(0.016, 0.09, 8).moved((0.02, y, -tall / 2.0 + 0.081)) for y in (-0.09, -0.15)]
        eggs = [icosphere(0.014, 0).moved((0.02, -0.08 - 0.035 * i, 0.051)) for i in range(6)]
        high = round(tall / 2.0 - 0.04, 6)
        badge = box((0.002, 0.10, 0.018), (-THICK - 0.001, -0.13, high))
        display = box((0.002, 0.05, 0.012), (-THICK - 0.001, -0.24, high))
        visuals += [
            Visual(mesh_shape("racks", _merged(racks)), (0.62, 0.74, 0.80)),
            Visual(mesh_shape("juice", merge(bottles)), (0.95, 0.50, 0.12)),
            Visual(mesh_shape("eggs", merge(eggs)), (0.90, 0.72, 0.55)),
            Visual(mesh_shape("badge", badge), CHROME),
            Visual(mesh_shape("display", display), shining((0.35, 0.80, 0.95))),
        ]
    return Link(
        f"{name}_link", mass, tuple(visuals), (*(box_shape(size, center) for size, center in solid), *shapes), friction=1.0
    )


def _model(design: Design) -> Model:
    links, joints, width = [_body_link(design)], [], design.width
    upper, lower, bars = design.upper, design.lower, {"upper": design.upper_bar, "lower": design.lower_bar}
    for name, bounds, mass in (("upper", upper, 1.6), ("lower", lower, 0.9)):
        links.append(_door_link(design, name, bounds, bars[name], mass))
        hinge = (FRONT - GAP, design.half, (bounds[0] + bounds[1]) / 2.0)
        axis = (0.0, 0.0, -1.0)
        joints.append(Joint(f"{name}_door", "revolute", "fridge", f"{name}_link", hinge, axis, 0.0, 1.9, damping=0.1))
    notes = (
        "front faces -x; hollow; both doors hang on the left edge for a viewer in front (at +y) and open towards -x",
        f"links `upper_link` and `lower_link` have their origins on the hinge x {FRONT - GAP:.3f}, y {design.half} at half door "
        f"height, z {sum(upper) / 2.0:.3f} and {sum(lower) / 2.0:.3f}; closed, each spans x -{THICK}..0 and y -{width}..0 there, "
        f"z -+{(upper[1] - upper[0]) / 2.0:.2f} and -+{(lower[1] - lower[0]) / 2.0:.2f}",
        f"handle bars vertical, diameter {2 * BAR_RADIUS}, at x, y {(HANDLE[0], round(HANDLE[1] - width, 6))} in the links; "
        f"middle and length {bars}; {-HANDLE[0] - THICK - BAR_RADIUS:.3f} m free behind them",
        f"inside: x {FRONT:.3f}..{BACK:.3f}, y -+{design.inner:.3f}; floors at z = {design.floors}, "
        f"ceiling {design.height - WALL:.3f}; upper "
        f"sides of the shelves at z = {design.shelves}; behind the upper door they begin at x = {SHELF_FRONT:.3f}; "
        "the middle one is empty",
    )
    return Model(design.name, f"objects/{design.name}", "bottom centre", tuple(links), tuple(joints), notes)


RED_FRIDGE = Design(
    "fridge_red",
    width=0.35,
    height=0.56,
    upper=(0.228, 0.558),
    lower=(0.014, 0.224),
    floors=(0.027, 0.234),
    shelves=(0.12, 0.305, 0.48),
    upper_bar=(-0.10, 0.12),
    lower_bar=(0.01, 0.15),
    body=RED,
    groove=DARK_RED,
    handle=CHROME,
)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_model(Design()), _model(RED_FRIDGE))
