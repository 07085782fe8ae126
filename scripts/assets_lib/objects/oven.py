"""A cooker: four plates on top, six knobs, an oven with a grid behind a door that folds down, and what glows when it is on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from assets_lib.cabinets import bevelled_box, cabinet, rectangle_at
from assets_lib.mesh import Mesh, box, cylinder, lathe, merge, rod
from assets_lib.prisms import mark, rectangle
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
    Paint,
    Shape,
    Visual,
    box_shape,
    cylinder_shape,
    glass,
    mesh_shape,
    metal,
    patterned,
)

DEPTH, WIDTH, HEIGHT, WALL = 0.36, 0.44, 0.42, 0.015
FLOOR, CEILING = 0.10, 0.345
"""Height of the floor and of the ceiling of the oven [m]."""
DOOR = (0.02, 0.40, 0.26)
GAP = 0.0015
HINGE = (-DEPTH / 2.0 - GAP, 0.0, 0.09)
"""Middle of the inner lower edge of the door [m]."""
HANDLE = (-DOOR[0] - 0.068, 0.0, 0.235)
"""Centre of the handle bar in the door frame [m]."""
BAR_RADIUS, BAR_LENGTH = 0.006, 0.28
GRID = 0.16
"""Height of the upper side of the grid [m]."""
KNOB_Z, KNOB_STEP, PILOT_Y = 0.387, 0.068, 0.204
STEEL, DARK, GLASS, SILVER = metal((0.72, 0.73, 0.75)), (0.12, 0.12, 0.13), glass((0.30, 0.22, 0.16)), metal((0.88, 0.89, 0.91))
BRUSHED = patterned(metal((0.78, 0.79, 0.81)), "brushed")
PLATES = ((-0.085, 0.105, 0.07), (0.085, 0.105, 0.055), (-0.085, -0.105, 0.055), (0.085, -0.105, 0.07))
"""x, y and radius of the cooking plates; the first belongs to the left-most knob [m]."""
GLOW = (1.0, 0.42, 0.08)
HALF_PI = 1.57079633

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _body() -> tuple[Box, ...]:
    """Return the boxes (size, centre) of the shell around the hollow."""
    side = (WIDTH - WALL) / 2.0
    inner, middle = CEILING - FLOOR, (CEILING + FLOOR) / 2.0
    return (
        ((DEPTH, WIDTH, FLOOR - 0.01), (0.0, 0.0, (FLOOR + 0.01) / 2.0)),
        ((DEPTH, WIDTH, HEIGHT - CEILING), (0.0, 0.0, (HEIGHT + CEILING) / 2.0)),
        ((DEPTH, WALL, inner), (0.0, side, middle)),
        ((DEPTH, WALL, inner), (0.0, -side, middle)),
        ((WALL, WIDTH - 2 * WALL, inner), ((DEPTH - WALL) / 2.0, 0.0, middle)),
    )


def _shell() -> Mesh:
    """Return the shell around the hollow."""
    half = WIDTH / 2.0
    spans = ((-DEPTH / 2.0, DEPTH / 2.0), (-half, half), (0.01, HEIGHT))
    return cabinet(*spans, (-half + WALL, half - WALL), ((FLOOR, CEILING),), DEPTH - WALL)


def _feet() -> tuple[Box, ...]:
    return tuple(((0.04, 0.04, 0.01), (x, y, 0.005)) for x in (-0.14, 0.14) for y in (-0.18, 0.18))


def _grid_box() -> Box:
    return ((DEPTH - WALL - 0.02, WIDTH - 2 * WALL, 0.006), (-WALL / 2.0, 0.0, GRID - 0.003))


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _grid() -> Mesh:
    """Return the rods of the grid."""
    (depth, width, _), (x, _, z) = _grid_box()
    rods = [box((depth, 0.005, 0.006), (x, -width / 2.0 + width * (i + 0.5) / 9.0, z)) for i in range(9)]
    return merge([*rods, *(box((0.006, width, 0.006), (x + side * (depth / 2.0 - 0.01), 0.0, z)) for side in (-1, 1))])


def _lining() -> Mesh:
    """Return thin sheets that make the inside dark."""
    t, half, mid, tall = 0.001, WIDTH / 2.0 - WALL, (FLOOR + CEILING) / 2.0, CEILING - FLOOR
    sheets = [box((DEPTH - WALL, t, tall), (-WALL / 2.0, side * (half - t / 2.0), mid)) for side in (-1, 1)]
    sheets += [box((DEPTH - WALL, 2 * half, t), (-WALL / 2.0, 0.0, z)) for z in (FLOOR + t / 2.0, CEILING - t / 2.0)]
    return merge([*sheets, box((t, 2 * half, tall), (DEPTH / 2.0 - WALL - t / 2.0, 0.0, mid))])


def _plates() -> Mesh:
    """Return the four cooking plates."""
    return merge(lathe([(r, 0.0), (r, 0.006), (0.0, 0.006)], 24).moved((x, y, HEIGHT)) for x, y, r in PLATES)


def _knob_discs(places: tuple[float, ...], x: float, z: float) -> Mesh:
    """Return the discs of knobs on a panel at `x`, which faces -x."""
    disc = lathe([(0.0225, 0.0), (0.0225, 0.012), (0.0, 0.012)], 10)
    return merge(disc.moved((x, y, z), (0.0, -HALF_PI, 0.0)) for y in places)


def _knob_bars(places: tuple[float, ...], x: float, z: float) -> Mesh:
    """Return the upright bars on knobs."""
    return merge(box((0.018, 0.012, 0.042), (x - 0.021, y, z)) for y in places)


def _knob_shapes(y: float = 0.0, x: float = 0.0, z: float = 0.0) -> tuple[Shape, ...]:
    disc = cylinder_shape(0.0225, 0.012, (x - 0.006, y, z), (0.0, HALF_PI, 0.0))
    return (disc, box_shape((0.018, 0.012, 0.042), (x - 0.021, y, z)))


def _knob_places() -> tuple[float, ...]:
    """Return y of the five fixed knobs, left to right."""
    return tuple(KNOB_STEP * k for k in (1.5, 0.5, -0.5, -1.5, -2.5))


def _pointers(places: tuple[float, ...], x: float, z: float) -> Mesh:
    """Return the marks of knobs: from the middle of the bar to its upper end, and over that end."""
    front = mark(rectangle(0.007, 0.021) + (0.0, 0.0105), 0.0305, "x").moved(rpy=(0.0, 0.0, 2.0 * HALF_PI))
    above = mark(rectangle(0.018, 0.007) + (-0.021, 0.0), 0.0214, "z")
    return merge(part.moved((x, y, z)) for y in places for part in (front, above))


def _ticks(x: float) -> Mesh:
    """Return the marks around each knob, a longer one at the top, where it is off."""
    marks = []
    for k in range(6):
        for angle in np.deg2rad((-135.0, -90.0, -45.0, 0.0, 45.0, 90.0, 135.0)):
            length, width = (0.008, 0.004) if angle == 0.0 else (0.005, 0.0022)
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            corners = rectangle(width, length) @ turn.T + (0.0245 + length / 2.0) * turn[:, 1]
            marks.append(mark(corners, -x, "x").moved((0.0, -KNOB_STEP * (2.5 - k), KNOB_Z)).moved(rpy=(0.0, 0.0, 2.0 * HALF_PI)))
    return merge(marks)


def _glow_link() -> Link:
    """Return what glows while the oven is on: window of the closed door, pilot lamp, plate of the left-most knob."""
    t, w, h = DOOR
    size = (w - 0.11, h - 0.13)
    place = (HINGE[0] - t - 0.0024, 0.0, HINGE[2] + h / 2.0 - 0.015)
    whole = box((0.0008, *size), place)
    x, y, radius = PLATES[0]

    def lights(sides: int, round_: int, window: Sequence[Mesh]) -> Mesh:
        rings = [
            lathe([(r, 0.0), (r - 0.008, 0.0)], sides).moved((x, y, HEIGHT + 0.0068))
            for r in (radius - 0.006, radius - 0.026, radius - 0.046)
        ]
        lamp = cylinder(0.006, 0.004, round_).moved((-DEPTH / 2.0 - 0.004, PILOT_Y, KNOB_Z), (0.0, HALF_PI, 0.0))
        return merge([*window, lamp, *rings])

    bright, dim = ([part.moved(place) for part in parts] for parts in _lit_window(size))
    seen = (
        Visual(mesh_shape("glow", lights(24, 12, bright)), Paint(GLOW, opacity=0.0, emission=GLOW, reach=0.0)),
        Visual(mesh_shape("glow_edge", merge(dim)), Paint(GLOW, opacity=0.0)),
    )
    return Link("glow", 0.001, seen, weighs=(mesh_shape("", lights(12, 6, [whole])),))


def _lit_window(size: tuple[float, float]) -> tuple[list[Mesh], list[Mesh]]:
    """Return the bright and the dim parts of the lit window, around its middle: dim along its border, dark at the rods."""
    y, z = size[0] / 2.0, size[1] / 2.0
    edge, low, high, rod_ = 0.016, -z + 0.030, -z + 0.044, 0.003

    def part(ys: tuple[float, float], zs: tuple[float, float]) -> Mesh:
        return rectangle_at(-0.0004, ys, zs)

    inner = y - edge
    bright = [part((-inner, inner), (-z + edge, low - rod_)), part((-inner, inner), (high + rod_, z - edge))]
    steps = np.linspace(-inner, inner, 10)
    bright += [part((a + rod_ / 2.0, b - rod_ / 2.0), (low, high)) for a, b in zip(steps[:-1], steps[1:], strict=True)]
    dim = [part((-y, y), span) for span in ((-z, -z + edge), (z - edge, z))]
    for side in (-1, 1):
        ys = (inner, y) if side > 0 else (-y, -inner)
        dim += [part(ys, span) for span in ((-z + edge, low - rod_), (low, high), (high + rod_, z - edge))]
    return bright, dim


def _body_link() -> Link:
    front = -DEPTH / 2.0
    panel = box((0.002, WIDTH, HEIGHT - 0.356), (front - 0.001, 0.0, (HEIGHT + 0.356) / 2.0))
    tall = CEILING - FLOOR
    sides = (s * (WIDTH / 2.0 - WALL - 0.007) for s in (-1, 1))
    cheeks = [rectangle_at(front - 0.0005, (y - 0.007, y + 0.007), (FLOOR, FLOOR + tall)) for y in sides]
    places = _knob_places()
    pilot = cylinder(0.0075, 0.002, 14).moved((front - 0.003, PILOT_Y, KNOB_Z), (0.0, HALF_PI, 0.0))
    visuals = (
        Visual(mesh_shape("shell", _shell()), STEEL),
        Visual(mesh_shape("lining", _lining()), (0.20, 0.19, 0.19)),
        Visual(mesh_shape("cheeks", merge(cheeks)), STEEL),
        Visual(mesh_shape("panel", panel), DARK),
        Visual(mesh_shape("ticks", _ticks(front - 0.0025)), (1.0, 1.0, 1.0)),
        Visual(mesh_shape("hob", box((DEPTH - 0.02, WIDTH - 0.02, 0.002), (0.0, 0.0, HEIGHT + 0.001))), DARK),
        Visual(mesh_shape("plates", _plates()), (0.33, 0.33, 0.35)),
        Visual(mesh_shape("pilot", pilot), (0.30, 0.10, 0.07)),
        Visual(mesh_shape("knobs", _knob_discs(places, front - 0.002, KNOB_Z)), SILVER),
        Visual(mesh_shape("bars", _knob_bars(places, front - 0.002, KNOB_Z)), DARK),
        Visual(mesh_shape("pointers", _pointers(places, front - 0.002, KNOB_Z)), (1.0, 1.0, 1.0)),
        Visual(mesh_shape("grid", _grid()), (0.60, 0.61, 0.63)),
        Visual(mesh_shape("feet", _merged(_feet())), DARK),
    )
    shapes = tuple(box_shape(size, center) for size, center in (*_body(), *_feet(), _grid_box()))
    fixed = tuple(shape for y in places for shape in _knob_shapes(y, front - 0.002, KNOB_Z))
    return Link("oven", 15.0, visuals, (*shapes, *fixed))


def _rim() -> Mesh:
    """Return the dark edge of the window on both sides of the door."""
    t, w, h = DOOR
    y, low, high = w / 2.0 - 0.042, h / 2.0 - 0.015 - (h - 0.104) / 2.0, h / 2.0 - 0.015 + (h - 0.104) / 2.0
    outside = rectangle_at(-t - 0.0005, (-y, y), (low, high))
    return merge([outside, rectangle_at(-0.0005, (-y, y), (low, high)).moved(rpy=(0.0, 0.0, 2.0 * HALF_PI))])


def _door_link() -> Link:
    t, w, h = DOOR
    x, y, z = HANDLE
    posts = tuple(rod((x, side * 0.11, z), (-t, side * 0.11, z), 0.005, 4) for side in (-1, 1))
    bar = rod((x, -BAR_LENGTH / 2.0, z), (x, BAR_LENGTH / 2.0, z), BAR_RADIUS, 10)
    visuals = (
        Visual(mesh_shape("door", bevelled_box(DOOR, (-t / 2.0, 0.0, h / 2.0), 0.004)), BRUSHED),
        Visual(mesh_shape("window_rim", _rim()), DARK),
        Visual(mesh_shape("window", box((t + 0.002, w - 0.10, h - 0.12), (-t / 2.0, 0.0, h / 2.0 - 0.015))), GLASS),
        Visual(mesh_shape("handle", merge([bar, *posts])), SILVER),
    )
    length = -x - t - BAR_RADIUS + 0.002
    stays = tuple(box_shape((length, 0.009, 0.009), (-t - length / 2.0, side * 0.11, z)) for side in (-1, 1))
    grip = cylinder_shape(BAR_RADIUS, BAR_LENGTH, HANDLE, (HALF_PI, 0.0, 0.0))
    return Link("door_link", 1.0, visuals, (box_shape(DOOR, (-t / 2.0, 0.0, h / 2.0)), grip, *stays))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    visuals = (
        Visual(mesh_shape("knob", _knob_discs((0.0,), 0.0, 0.0)), SILVER),
        Visual(mesh_shape("bar", _knob_bars((0.0,), 0.0, 0.0)), DARK),
        Visual(mesh_shape("pointer", _pointers((0.0,), 0.0, 0.0)), (1.0, 1.0, 1.0)),
    )
    knob = Link("knob_link", 0.05, visuals, _knob_shapes(), friction=1.0)
    place = (-DEPTH / 2.0 - 0.002, 2.5 * KNOB_STEP, KNOB_Z)
    door = Joint("door", "revolute", "oven", "door_link", HINGE, (0.0, -1.0, 0.0), 0.0, 1.57, damping=0.05)
    turn = Joint("knob", "revolute", "oven", "knob_link", place, (-1.0, 0.0, 0.0), -2.5, 2.5, damping=0.002)
    lights = Joint("glow_holder", "fixed", "oven", "glow", (0.0, 0.0, 0.0))
    inside = DEPTH / 2.0 - WALL
    notes = (
        "front faces -x; the door hangs on its lower edge and folds down towards -x",
        f"link `door_link` has its origin on the hinge {HINGE}; closed, it "
        f"spans x -{DOOR[0]}..0, y -+{DOOR[1] / 2.0}, z 0..{DOOR[2]} there; "
        f"folded down, its upper side is at z = {HINGE[2]}",
        f"handle bar along y, diameter {2 * BAR_RADIUS}, length {BAR_LENGTH}, centre {HANDLE} in `door_link`, "
        f"{-HANDLE[0] - DOOR[0] - BAR_RADIUS:.3f} m free behind it",
        f"inside: x -{DEPTH / 2.0}..{inside}, y -+{WIDTH / 2.0 - WALL}, floor at z = {FLOOR}, ceiling {CEILING}; "
        f"the grid's upper side is at z = {GRID}",
        f"link `knob_link` is the left-most of six knobs for a viewer in front, {tuple(round(v, 4) for v in place)}; "
        "the joint `knob` increases anticlockwise in their view; its raised bar, 0.012 x 0.042, upright at 0, x -0.030..-0.012",
        f"link `glow` is not seen; coloured {GLOW} it shines: window of the closed door, pilot lamp, plate of the left-most knob",
    )
    links = (_body_link(), _door_link(), knob, _glow_link())
    return (Model("oven", "objects/oven", "bottom centre", links, (door, turn, lights), notes),)
