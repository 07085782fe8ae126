"""A desktop computer with a port in its front, a memory stick that fits it, and a little stand for the stick."""

from __future__ import annotations

import numpy as np

from assets_lib.cabinets import bevelled_box
from assets_lib.mesh import Mesh, box, cylinder, hull_of, lathe, merge, rod
from assets_lib.prisms import mark, rectangle, regular_polygon
from assets_lib.urdf import Link, Model, Shape, Visual, box_shape, mesh_shape, metal, patterned, plastic, shining

DEPTH, WIDTH, HEIGHT = 0.36, 0.20, 0.25
FEET = 0.008
TIP = (0.018, 0.015, 0.006)
"""Length, width and height of the metal tip of the stick [m]."""
BODY = (0.035, 0.020, 0.012)
CLEARANCE = 0.001
SLOT_DEPTH, SLOT_WIDTH, SLOT_HEIGHT = 0.02, TIP[1] + 2.0 * CLEARANCE, TIP[2] + 2.0 * CLEARANCE
PORT = 0.12
"""Height of the middle of the slot [m]."""
BEVEL = 0.003
STAND = (0.03, 0.016, 0.04)
STAND_FOOT = (0.06, 0.06, 0.006)
CASE, BEZEL, DARK, SILVER, LIGHT = (
    patterned(metal((0.46, 0.48, 0.51)), "brushed"),
    plastic((0.46, 0.48, 0.51)),
    (0.03, 0.03, 0.035),
    metal((0.80, 0.81, 0.83)),
    (0.93, 0.94, 0.95),
)
STICK, CAP = plastic((0.15, 0.62, 0.66)), plastic((0.92, 0.92, 0.90))
HALF_PI = float(np.pi) / 2.0

Span = tuple[tuple[float, float], tuple[float, float]]
"""Lowest and highest y, z [m]."""


def _around_slot() -> tuple[Span, ...]:
    """Return the front around the slot: below, above, right and left of it."""
    w, y, low, high = WIDTH / 2.0, SLOT_WIDTH / 2.0, PORT - SLOT_HEIGHT / 2.0, PORT + SLOT_HEIGHT / 2.0
    return (((-w, w), (FEET, low)), ((-w, w), (high, HEIGHT)), ((-w, -y), (low, high)), ((y, w), (low, high)))


def _front() -> Mesh:
    """Return the front around the slot; its outer edges are bevelled towards -x."""
    pieces = []
    for (left, right), (low, high) in _around_slot():
        points = [(SLOT_DEPTH, y, z) for y in (left, right) for z in (low, high)]
        ys = [y - np.sign(y) * BEVEL * (abs(y) == WIDTH / 2.0) for y in (left, right)]
        zs = [low + BEVEL * (low == FEET), high - BEVEL * (high == HEIGHT)]
        points += [(0.0, y, z) for y in ys for z in zs]
        points += [(BEVEL, y, z) for y in (left, right) for z in (low, high)]
        pieces.append(hull_of(np.array(points)))
    return merge(pieces)


def _on_front(y: float, z: float, width: float, height: float, thickness: float = 0.0008) -> Mesh:
    """Return a flat plate on the front."""
    return box((thickness, width, height), (-thickness / 2.0, y, z))


def _port_frame() -> Mesh:
    """Return a bright frame around the slot."""
    y, z, wide = SLOT_WIDTH / 2.0, SLOT_HEIGHT / 2.0, 0.003
    bars = [_on_front(s * (y + wide / 2.0), PORT, wide, 2.0 * (z + wide)) for s in (-1, 1)]
    return merge([*bars, *(_on_front(0.0, PORT + s * (z + wide / 2.0), 2.0 * y, wide) for s in (-1, 1))])


def _symbol() -> Mesh:
    """Return the trident of the port on the front, to its left."""
    y, z, t = 0.032, PORT, 0.0005
    lines = [_on_front(y, z, 0.026, 0.0016, t), _on_front(y + 0.003, z + 0.005, 0.008, 0.0016, t)]
    lines += [_on_front(y - 0.002, z - 0.005, 0.008, 0.0016, t), _on_front(y - 0.006, z - 0.003, 0.0016, 0.005, t)]
    lines += [_on_front(y + 0.007, z + 0.003, 0.0016, 0.005, t)]
    return merge(
        [*lines, *(_on_front(y + dy, z + dz, 0.004, 0.004, t) for dy, dz in ((0.014, 0.0), (-0.002, 0.005), (0.004, -0.005)))]
    )


def _holes() -> Mesh:
    """Return grilles and jacks of the front, and the shade in the slot."""
    rows = [_on_front(0.0, 0.028 + 0.010 * k, 0.13, 0.004) for k in range(5)]
    jacks = [cylinder(0.004, 0.001, 8).moved((-0.0005, y, PORT + 0.034), (0.0, HALF_PI, 0.0)) for y in (-0.012, 0.012)]
    gaps = [_on_front(0.0, z, 0.16, 0.0016) for z in (0.176, 0.236)]
    inside = box((0.0004, SLOT_WIDTH, SLOT_HEIGHT), (SLOT_DEPTH - 0.0002, 0.0, PORT))
    top = [box((0.012, 0.13, 0.0006), (0.12 + 0.03 * k, 0.0, HEIGHT + 0.0003)) for k in range(5)]
    sides = [box((0.012, 0.0006, 0.14), (0.16 + 0.03 * k, s * (WIDTH / 2.0 + 0.0003), 0.13)) for k in range(3) for s in (-1, 1)]
    return merge([*rows, *jacks, *gaps, inside, *top, *sides])


def _back() -> tuple[Visual, ...]:
    """Return the back: sockets, a fan and slots for cards."""
    x = DEPTH
    plate = mark(rectangle(0.045, 0.13) + (-0.06, 0.17), x + 0.0006, "x")
    sockets = [
        mark(rectangle(0.014, 0.016) + (-0.06 + dy, 0.122 + 0.024 * k), x + 0.0012, "x") for dy in (-0.01, 0.01) for k in range(5)
    ]
    slots = [mark(rectangle(0.10, 0.007) + (-0.02, 0.03 + 0.012 * k), x + 0.0006, "x") for k in range(5)]
    fan = mark(regular_polygon(0.045, 16) + (0.035, 0.17), x + 0.0006, "x")
    ring = lathe([(0.045, 0.0), (0.048, 0.0), (0.048, 0.002), (0.045, 0.002)], 16).moved((x, 0.035, 0.17), (0.0, HALF_PI, 0.0))
    grille = [
        rod((x + 0.002, 0.035 - dy, 0.17 - dz), (x + 0.002, 0.035 + dy, 0.17 + dz), 0.0012, 6)
        for dy, dz in ((0.046, 0.0), (0.0, 0.046))
    ]
    return (
        Visual(mesh_shape("back_plates", merge([plate, ring, *slots, *grille])), SILVER),
        Visual(mesh_shape("back_holes", merge([fan, *sockets])), DARK),
    )


def _computer() -> Model:
    w, rear = WIDTH / 2.0, DEPTH - SLOT_DEPTH
    size, center = (rear, WIDTH - 0.004, HEIGHT - FEET), ((DEPTH + SLOT_DEPTH) / 2.0, 0.0, (HEIGHT + FEET) / 2.0)
    feet = [box((0.04, 0.03, FEET), (x, s * (w - 0.022), FEET / 2.0)) for x in (0.05, DEPTH - 0.04) for s in (-1, 1)]
    plinth = box((DEPTH - 0.012, WIDTH - 0.014, FEET), (DEPTH / 2.0, 0.0, FEET / 2.0))
    button = cylinder(0.011, 0.003, 16, bevel=0.001).moved((-0.001, 0.0, 0.207), (0.0, HALF_PI, 0.0))
    ring = lathe([(0.011, 0.0), (0.0135, 0.0), (0.0135, 0.0012), (0.011, 0.0012)], 16).moved(
        (0.0, 0.0, 0.207), (0.0, -HALF_PI, 0.0)
    )
    visuals = (
        Visual(mesh_shape("case", bevelled_box(size, center)), CASE),
        Visual(mesh_shape("front", _front()), BEZEL, crease=0.3),
        Visual(mesh_shape("holes", merge([*feet, plinth, _holes()])), DARK),
        Visual(mesh_shape("port_frame", _port_frame()), SILVER),
        Visual(mesh_shape("symbol", _symbol()), LIGHT),
        Visual(mesh_shape("button", button), SILVER),
        Visual(mesh_shape("button_ring", ring), shining((0.35, 0.75, 0.95))),
        *_back(),
    )
    front = [
        box_shape(
            (SLOT_DEPTH, round(y[1] - y[0], 6), round(z[1] - z[0], 6)), (SLOT_DEPTH / 2.0, sum(y) / 2.0, round(sum(z) / 2.0, 6))
        )
        for y, z in _around_slot()
    ]
    stand = box_shape((DEPTH - 0.06, WIDTH - 0.02, FEET), (DEPTH / 2.0 + 0.005, 0.0, FEET / 2.0))
    solid: tuple[Shape, ...] = (*front, box_shape((rear, WIDTH, HEIGHT - FEET), center), stand)
    notes = (
        f"front faces -x at x = 0; slot {SLOT_WIDTH} wide, {SLOT_HEIGHT} high, {SLOT_DEPTH} deep at y = 0, z = {PORT}",
        f"a memory stick fits it; pushed home its origin is at x = {-BODY[0] / 2.0}",
    )
    link = Link("computer", 6.0, visuals, solid, friction=0.6)
    return Model("computer", "objects/computer", "middle of the lower front edge", (link,), notes=notes)


def _stick() -> Model:
    x = BODY[0] / 2.0
    tip_size, tip_at = TIP, (x + TIP[0] / 2.0, 0.0, 0.0)
    rear = 0.006
    main = bevelled_box((BODY[0] - rear, BODY[1], BODY[2]), (rear / 2.0, 0.0, 0.0), 0.002)
    cap = bevelled_box((rear + 0.002, BODY[1] - 0.001, BODY[2] - 0.001), (-x + rear / 2.0 + 0.001, 0.0, 0.0), 0.002)
    label = box((0.016, 0.010, 0.0004), (0.004, 0.0, BODY[2] / 2.0))
    holes = [box((0.003, 0.003, 0.0004), (x + 0.010, s * 0.0035, side * TIP[2] / 2.0)) for s in (-1, 1) for side in (-1, 1)]
    mouth = box((0.0004, TIP[1] - 0.002, TIP[2] - 0.002), (x + TIP[0], 0.0, 0.0))
    visuals = (
        Visual(mesh_shape("body", main), STICK),
        Visual(mesh_shape("cap", merge([cap, label])), CAP),
        Visual(mesh_shape("tip", bevelled_box(tip_size, tip_at, 0.0005)), SILVER),
        Visual(mesh_shape("tip_holes", merge([*holes, mouth])), DARK),
    )
    link = Link("memory_stick", 0.03, visuals, (box_shape(BODY), box_shape(tip_size, tip_at)), friction=0.9, anchored=True)
    notes = (
        f"metal tip along +x, {TIP[1]} wide, {TIP[2]} high, to x = {x + TIP[0]:.4f}",
        f"rests with its origin at {BODY[2] / 2.0} m; grasp it across y ({BODY[1]})",
    )
    return Model("memory_stick", "objects/memory_stick", "centre of the body without its tip", (link,), notes=notes)


def _stand() -> Model:
    post = bevelled_box(STAND, (0.0, 0.0, STAND[2] / 2.0), 0.002)
    foot = bevelled_box(STAND_FOOT, (0.0, 0.0, STAND_FOOT[2] / 2.0), 0.002)
    visuals = (Visual(mesh_shape("stand", merge([post, foot])), plastic((0.55, 0.57, 0.60))),)
    solid = (box_shape(STAND, (0.0, 0.0, STAND[2] / 2.0)), box_shape(STAND_FOOT, (0.0, 0.0, STAND_FOOT[2] / 2.0)))
    notes = (f"a memory stick rests on it with its origin at z = {STAND[2] + BODY[2] / 2.0}",)
    return Model("stick_stand", "objects/stick_stand", "bottom centre", (Link("stick_stand", 0.3, visuals, solid),), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_computer(), _stick(), _stand())
