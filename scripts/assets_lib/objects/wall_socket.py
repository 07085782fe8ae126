"""A piece of wall with a socket for two pins, a charger that fits it, and a little stand for the charger."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from assets_lib.mesh import Mesh, box, cylinder, hull_of, lathe, merge, rod
from assets_lib.prisms import bevelled_box, mark
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
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

WIDTH, HEIGHT, THICKNESS = 0.24, 0.20, 0.03
FOOT = (0.09, 0.24, 0.012)
PLATE, PLATE_THICKNESS, SOCKET_HEIGHT = 0.07, 0.008, 0.15
HOLE, DEPTH, PITCH = 0.010, 0.02, 0.02
BODY = (0.05, 0.045, 0.04)
PIN_RADIUS, PIN_LENGTH = 0.003, 0.018
STAND = (0.036, 0.036, 0.03)
WALL, TRIM, WHITE, BLACK, METAL = (
    (0.63, 0.72, 0.76),
    (0.45, 0.52, 0.56),
    plastic((0.95, 0.95, 0.93)),
    (0.08, 0.08, 0.09),
    metal((0.92, 0.92, 0.95)),
)
IDLE = (0.74, 0.76, 0.79)
"""Colour of the lights as long as no task colours them: like the heads of screws."""
CASE, YELLOW, LIVE = plastic((0.24, 0.25, 0.29)), (0.98, 0.80, 0.10), (0.15, 0.95, 0.25)

FRAME = plastic((0.83, 0.83, 0.80))
SIGN_HEIGHT = SOCKET_HEIGHT - 0.018

Span = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
"""Lowest and highest x, y, z [m]."""


def _box(span: Span) -> Shape:
    """Return a box given by its borders."""
    size = tuple(round(high - low, 6) for low, high in span)
    return box_shape((size[0], size[1], size[2]), tuple(round((low + high) / 2.0, 6) for low, high in span))  # type: ignore[arg-type]


def _around_holes(x: tuple[float, float]) -> tuple[Shape, ...]:
    """Return the socket plate as boxes that leave the two holes open."""
    half, z = PLATE / 2.0, SOCKET_HEIGHT
    inner, outer = PITCH / 2.0 - HOLE / 2.0, PITCH / 2.0 + HOLE / 2.0
    low, high = z - HOLE / 2.0, z + HOLE / 2.0
    rows = (((-half, half), (z - half, low)), ((-half, half), (high, z + half)))
    columns = (((-half, -outer), (low, high)), ((-inner, inner), (low, high)), ((outer, half), (low, high)))
    return tuple(_box((x, y, zs)) for y, zs in (*rows, *columns))


def _wall_around_plate(x: tuple[float, float]) -> tuple[Shape, ...]:
    """Return the wall beside the socket, at the depth of its holes."""
    half, w = PLATE / 2.0, WIDTH / 2.0
    low, high = SOCKET_HEIGHT - half, SOCKET_HEIGHT + half
    sides = (((-w, -half), (0.0, HEIGHT)), ((half, w), (0.0, HEIGHT)))
    middle = (((-half, half), (0.0, low)), ((-half, half), (high, HEIGHT)))
    return tuple(_box((x, y, z)) for y, z in (*sides, *middle))


def _bolt() -> Visual:
    """Return the bolt on the sign on the back that warns of electricity."""
    x, z, left = THICKNESS, SIGN_HEIGHT, 0.0
    upper = ((left - 0.004, z + 0.022), (left + 0.006, z + 0.022), (left - 0.012, z - 0.012), (left + 0.002, z - 0.006))
    lower = ((left - 0.002, z - 0.004), (left + 0.013, z - 0.002), (left - 0.004, z - 0.034))
    return Visual(mesh_shape("bolt", merge(mark(points, x + 0.0012, "x") for points in (upper, lower))), BLACK)


def lamp_outline(radius: float) -> list[tuple[float, float]]:
    """Return the outline (radius, height) of a domed lamp on a wall, from below [m]."""
    angles = (0.0, 0.25, 0.5, 0.75, 1.0)
    dome = [(radius * float(np.cos(a * np.pi / 2.0)), 0.7 * radius * float(np.sin(a * np.pi / 2.0))) for a in angles[:-1]]
    return [*dome, (0.0, 0.7 * radius)]


def _light() -> Link:
    """Return the sign on the back and two lights beside the socket, which a task lights while the socket is in use."""
    turned, places = (0.0, np.pi / 2.0, 0.0), [(-0.002, s * 0.075, SOCKET_HEIGHT) for s in (-1.0, 1.0)]

    def sign(y: float) -> Mesh:
        z = SIGN_HEIGHT
        return mark(((y - 0.05, z - 0.04), (y + 0.05, z - 0.04), (y, z + 0.045)), THICKNESS + 0.0006, "x")

    domes, sides = (
        merge(lathe(outline, 24).moved((0.0, y, z), (0.0, -np.pi / 2.0, 0.0)) for _, y, z in places)
        for outline in (lamp_outline(0.012)[1:], lamp_outline(0.012)[:2])
    )
    lit = glossy(shining(YELLOW, emission=LIVE))
    visuals = (
        Visual(mesh_shape("light", domes), replace(lit, color=IDLE)),
        Visual(mesh_shape("sign", sign(0.0)), lit),
        Visual(mesh_shape("light_sides", sides), plastic(IDLE)),
    )
    spread = merge([sign(-0.055), *(cylinder(0.012, 0.006, 12).moved(place, turned) for place in places)])
    return Link("light", 0.001, visuals, weighs=(mesh_shape("", spread),))


def _panel() -> Model:
    bottom = DEPTH - PLATE_THICKNESS
    plate, wall = _around_holes((-PLATE_THICKNESS, bottom)), _wall_around_plate((0.0, bottom))
    back = _box(((bottom, THICKNESS), (-WIDTH / 2.0, WIDTH / 2.0), (0.0, HEIGHT)))
    foot = _box(((THICKNESS, THICKNESS + FOOT[0]), (-FOOT[1] / 2.0, FOOT[1] / 2.0), (0.0, FOOT[2])))
    turned = (0.0, np.pi / 2.0, 0.0)
    places = [(-PLATE_THICKNESS - 0.0002, side * PITCH / 2.0, SOCKET_HEIGHT) for side in (-1.0, 1.0)]
    ring = merge(cylinder(HOLE * 0.62, 0.0006, 16).moved(place, turned) for place in places)
    frame = bevelled_box((PLATE + 0.016, PLATE + 0.016, 0.005), 0.002).moved((0.0, 0.0, SOCKET_HEIGHT), (0.0, -np.pi / 2.0, 0.0))
    screws = [
        lathe([(0.0032, 0.0), (0.0026, 0.0012), (0.0, 0.0014)], 14).moved(
            (-PLATE_THICKNESS, 0.0, SOCKET_HEIGHT + s * 0.027), (0.0, -np.pi / 2.0, 0.0)
        )
        for s in (-1, 1)
    ]
    visuals = (
        Visual(mesh_shape("wall", merge(box(s.size, s.xyz) for s in (*wall, back))), WALL),
        Visual(mesh_shape("trim", merge([box(foot.size, foot.xyz), box((0.004, WIDTH, 0.02), (-0.002, 0.0, 0.01))])), TRIM),
        Visual(mesh_shape("frame", frame), FRAME),
        Visual(mesh_shape("plate_screws", merge(screws)), METAL),
        Visual(mesh_shape("plate", merge(box(s.size, s.xyz) for s in plate)), WHITE),
        Visual(mesh_shape("hole_rims", ring), BLACK),
        _bolt(),
    )
    link = Link("socket_panel", 3.0, visuals, (*wall, back, foot, *plate), friction=0.6)
    notes = (
        f"front faces -x; wall face at x = 0, socket plate to x = {-PLATE_THICKNESS}, top at z = {HEIGHT}",
        f"two holes {HOLE} wide, {DEPTH} deep at y = -{PITCH / 2.0} and {PITCH / 2.0}, z = {SOCKET_HEIGHT}; a charger fits, "
        f"pushed home its origin is at x = {-PLATE_THICKNESS - BODY[0] / 2.0}",
        f"link `light`, two domes in front and a sign on the back: coloured {LIVE} it shines",
    )
    holder = Joint("light_holder", "fixed", "socket_panel", "light", (0.0, 0.0, 0.0))
    return Model("socket_panel", "objects/socket_panel", "middle of the lower front edge", (link, _light()), (holder,), notes)


def _case() -> Mesh:
    """Return the charger's case, its edges round, more so towards its back."""
    x, y, z = (s / 2.0 for s in BODY)
    radius, points = 0.007, []
    for px, inset in ((x, 0.0015), (x - 0.0015, 0.0), (-x + 0.009, 0.0), (-x + 0.003, 0.0025), (-x, 0.008)):
        for angle in np.linspace(0.0, np.pi / 2.0, 5):
            py, pz = (y - radius - inset + radius * np.cos(angle), z - radius - inset + radius * np.sin(angle))
            points += [(px, sy * py, sz * pz) for sy in (-1, 1) for sz in (-1, 1)]
    return hull_of(np.round(np.array(points), 6))


def _charger() -> Model:
    pins = [(BODY[0] / 2.0, side * PITCH / 2.0, 0.0) for side in (-1.0, 1.0)]
    seen = merge(rod((x - 0.001, y, z), (x + PIN_LENGTH, y, z), PIN_RADIUS, 12) for x, y, z in pins)
    cable = rod((-BODY[0] / 2.0 - 0.016, 0.0, -0.004), (-BODY[0] / 2.0 + 0.002, 0.0, -0.004), 0.004, 10)
    mark = box((0.016, 0.006, 0.0006), (-0.004, 0.0, BODY[2] / 2.0 + 0.0002))
    visuals = (
        Visual(mesh_shape("case", _case()), CASE),
        Visual(mesh_shape("pins", seen), METAL),
        Visual(mesh_shape("cable", cable), (0.85, 0.85, 0.82)),
        Visual(mesh_shape("mark", mark), (0.25, 0.95, 0.45)),
    )
    turned = (0.0, float(np.pi) / 2.0, 0.0)
    solid = [cylinder_shape(PIN_RADIUS, PIN_LENGTH, (x + PIN_LENGTH / 2.0, y, z), turned) for x, y, z in pins]
    link = Link("charger", 0.08, visuals, (box_shape(BODY), *solid), friction=0.9)
    notes = (
        f"two pins along +x at y = +-{PITCH / 2.0}, diameter {2 * PIN_RADIUS}, to x = {BODY[0] / 2.0 + PIN_LENGTH:.3f}",
        f"rests with its origin at {BODY[2] / 2.0} m; grasp it across y ({BODY[1]})",
    )
    return Model("charger", "objects/charger", "centre of the case", (link,), notes=notes)


def _stand() -> Model:
    visuals = (Visual(mesh_shape("stand", bevelled_box(STAND, 0.002)), TRIM),)
    link = Link("charger_stand", 0.3, visuals, (box_shape(STAND, (0.0, 0.0, STAND[2] / 2.0)),))
    notes = (f"a charger rests on it with its origin at z = {STAND[2] + BODY[2] / 2.0}",)
    return Model("charger_stand", "objects/charger_stand", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_panel(), _charger(), _stand())
