"""A piece of wall with a rocker switch, of the same make as the wall with a socket.

The rocker is bistable: a weight above its axle makes it fall to either end, and the faces of its halves meet at a flat angle,
so that the raised half stands well out of the plate while the other one is pushed in.
"""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, box, hull_of, lathe, merge, rod
from assets_lib.objects.wall_socket import BLACK, FOOT, THICKNESS, TRIM, WALL, WHITE, WIDTH, YELLOW, lamp_outline
from assets_lib.prisms import mark, regular_polygon
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, box_shape, glossy, mesh_shape, plastic, shining

HEIGHT, SWITCH_HEIGHT = 0.18, 0.13
"""Height of the wall and of the axle [m]; the hand passes over the wall."""
PLATE, PLATE_THICKNESS = 0.08, 0.008
OPENING, DEPTH = (0.034, 0.058), 0.018
"""Opening in the plate along y and z, and how deep the well behind it goes into the wall [m]."""
ROCKER, AXLE, LIMIT = (0.03, 0.05), -0.006, 0.6
"""Width and height of the rocker, x of its axle [m], and how far it turns [rad]."""
VALLEY, TIP, BACK = -0.004, -0.010, 0.004
"""x of the front in the middle and at both ends, and of the back, in the frame of the rocker [m]."""
MASS, WEIGHT = 0.06, 0.012
"""Mass of the rocker [kg], and height of its centre of mass above the axle [m]."""
RED, DARK_RED = (0.93, 0.16, 0.10), (0.55, 0.06, 0.05)


def _around(x: tuple[float, float], y: float, z: tuple[float, float], opening: tuple[float, float]) -> tuple[Shape, ...]:
    """Return the four boxes of a wall from `x[0]` to `x[1]` and `z[0]` to `z[1]`, `y` wide, around an opening at the switch."""
    half, low, high = opening[0] / 2.0, SWITCH_HEIGHT - opening[1] / 2.0, SWITCH_HEIGHT + opening[1] / 2.0
    side = y / 2.0 - half
    spans = [(s * (half + side / 2.0), side, z[0], z[1]) for s in (-1.0, 1.0)]
    spans += [(0.0, opening[0], a, b) for a, b in ((z[0], low), (high, z[1]))]
    return tuple(_block(x, middle, width, (a, b)) for middle, width, a, b in spans)


def _block(x: tuple[float, float], y: float, width: float, z: tuple[float, float]) -> Shape:
    size = tuple(round(v, 6) for v in (x[1] - x[0], width, z[1] - z[0]))
    center = tuple(round(v, 6) for v in ((x[0] + x[1]) / 2.0, y, (z[0] + z[1]) / 2.0))
    return box_shape((size[0], size[1], size[2]), (center[0], center[1], center[2]))


def _seen(shapes: tuple[Shape, ...]) -> Mesh:
    return merge(shape.mesh() for shape in shapes)


def _back() -> tuple[Visual, ...]:
    """Return what the back of the wall shows: the box behind the switch, its cable, and the cap of a lamp."""
    x, y, z = THICKNESS, 0.055, 0.095
    cover = box((0.002, 0.07, 0.085), (x + 0.001, y, z + 0.02))
    pipe = rod((x, y, FOOT[2]), (x, y, z - 0.02), 0.005, 6)
    cap = mark(
        ((-y - 0.013, z - 0.022), (-y + 0.013, z - 0.022), (-y - 0.009, z - 0.048), (-y + 0.009, z - 0.048)), x + 0.0018, "x"
    )
    return (
        Visual(mesh_shape("back_box", merge([cover, pipe])), TRIM),
        Visual(mesh_shape("back_cap", cap), BLACK),
    )


def _lamp() -> Link:
    """Return the lamps on the back and beside the switch, which a task paints dark or bright as the switch asks for."""

    def bulb(sides: int) -> Mesh:
        return mark(regular_polygon(0.026, sides) + (-0.055, 0.095), THICKNESS + 0.0012, "x")

    def domes(outline: list[tuple[float, float]], sides: int) -> Mesh:
        dome = lathe(outline, sides).moved(rpy=(0.0, -np.pi / 2.0, 0.0))
        return merge(dome.moved((0.0, side * 0.08, SWITCH_HEIGHT)) for side in (-1.0, 1.0))

    outline = lamp_outline(0.019)
    lit = glossy(shining(YELLOW, emission=(1.0, 0.85, 0.2)))
    visuals = (
        Visual(mesh_shape("lamps", merge([bulb(32), domes(outline[1:], 28)])), lit),
        Visual(mesh_shape("lamp_sides", domes(outline[:2], 28)), plastic(YELLOW)),
    )
    spread = merge([bulb(16), domes([(0.019, 0.0), (0.016, 0.006), (0.0, 0.009)], 14)])
    return Link("lamp", 0.001, visuals, weighs=(mesh_shape("", spread),))


def _lamp_rims() -> Mesh:
    """Return the rings around the lamps beside the switch."""
    ring = lathe([(0.023, 0.0), (0.0225, 0.0025), (0.0185, 0.0025)], 32).moved(rpy=(0.0, -np.pi / 2.0, 0.0))
    return merge(ring.moved((0.0, side * 0.08, SWITCH_HEIGHT)) for side in (-1.0, 1.0))


def _half(sign: float) -> FloatArray:
    """Return the corners (8, 3) of one half of the rocker, in its frame: the upper one for 1, the lower one for -1."""
    outline = ((VALLEY, 0.0), (BACK, 0.0), (TIP, ROCKER[1] / 2.0), (TIP + 0.006, ROCKER[1] / 2.0))
    return np.array([(x, y * ROCKER[0] / 2.0, sign * z) for x, z in outline for y in (-1.0, 1.0)])


def _skirt(sign: float) -> Mesh:
    """Return what is seen of one half: its front and, behind that, sides as deep as the well, so that the plate stays closed."""
    half, end = ROCKER[0] / 2.0, ROCKER[1] / 2.0
    outline = ((VALLEY, 0.0), (BACK + 0.008, 0.0), (TIP, end), (TIP + 0.006, end), (TIP + 0.026, end - 0.004))
    return hull_of(np.array([(x, y * half, sign * z) for x, z in outline for y in (-1.0, 1.0)]))


def _marks() -> Mesh:
    """Return a bar on the upper half and a ring on the lower one."""
    slope = float(np.arctan2(VALLEY - TIP, ROCKER[1] / 2.0))
    x, z = (VALLEY + TIP) / 2.0, ROCKER[1] / 4.0
    bar = box((0.0012, 0.0035, 0.014)).moved((x, 0.0, z), (0.0, -slope, 0.0))
    ring = lathe([(0.0035, 0.0), (0.0068, 0.0), (0.0068, 0.0006), (0.0035, 0.0006), (0.0035, 0.0)], 16)
    return merge([bar, ring.moved((x, 0.0, -z), (0.0, -np.pi / 2.0 + slope, 0.0))])


def _rocker() -> Link:
    upper, lower = (hull_of(_half(sign)) for sign in (1.0, -1.0))
    visuals = (
        Visual(mesh_shape("upper_half", _skirt(1.0)), RED, crease=0.3),
        Visual(mesh_shape("lower_half", _skirt(-1.0)), DARK_RED, crease=0.3),
        Visual(mesh_shape("marks", _marks()), WHITE),
    )
    solid = tuple(mesh_shape(f"{name}_solid", half) for name, half in (("upper", upper), ("lower", lower)))
    return Link("rocker", MASS, visuals, solid, friction=0.6, center=(0.0, 0.0, WEIGHT))


def _panel() -> Link:
    plate = _around((-PLATE_THICKNESS, 0.0), PLATE, (SWITCH_HEIGHT - PLATE / 2.0, SWITCH_HEIGHT + PLATE / 2.0), OPENING)
    wall = _around((0.0, DEPTH), WIDTH, (0.0, HEIGHT), OPENING)
    back = _block((DEPTH, THICKNESS), 0.0, WIDTH, (0.0, HEIGHT))
    foot = box_shape(FOOT, (THICKNESS + FOOT[0] / 2.0, 0.0, FOOT[2] / 2.0))
    skirting = box((0.004, WIDTH, 0.02), (-0.002, 0.0, 0.01))
    rim = _around((-PLATE_THICKNESS - 0.0008, -PLATE_THICKNESS), OPENING[0] + 0.01, _rim(), OPENING)
    visuals = (
        Visual(mesh_shape("wall", _seen((*wall, back))), WALL),
        Visual(mesh_shape("trim", merge([foot.mesh(), skirting])), TRIM),
        Visual(mesh_shape("plate", _seen(plate)), WHITE),
        Visual(mesh_shape("rim", _seen(rim)), BLACK),
        Visual(mesh_shape("lamp_rims", _lamp_rims()), WHITE),
        *_back(),
    )
    return Link("switch_panel", 3.0, visuals, (*wall, back, foot, *plate), friction=0.6)


def _rim() -> tuple[float, float]:
    """Return the lowest and highest z of the dark rim around the opening [m]."""
    half = OPENING[1] / 2.0 + 0.005
    return SWITCH_HEIGHT - half, SWITCH_HEIGHT + half


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    holder = Joint("lamp_holder", "fixed", "switch_panel", "lamp", (0.0, 0.0, 0.0))
    joint = Joint(
        "rocker_joint",
        "revolute",
        "switch_panel",
        "rocker",
        (AXLE, 0.0, SWITCH_HEIGHT),
        (0.0, 1.0, 0.0),
        -LIMIT,
        LIMIT,
        damping=2e-4,
    )
    notes = (
        f"front faces -x; wall face at x = 0, plate to x = {-PLATE_THICKNESS}, top at z = {HEIGHT}",
        f"rocker about the y axis at x = {AXLE}, z = {SWITCH_HEIGHT}: pushing its upper half in increases the joint position; "
        "it rests at either end, because its centre of mass lies above the axle",
        "recolour the link `lamp`, two domes in front and a disc on the back: that is its light",
    )
    links = (_panel(), _rocker(), _lamp())
    return (Model("switch_panel", "objects/switch_panel", "middle of the lower front edge", links, (joint, holder), notes),)
