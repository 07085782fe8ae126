"""A hockey stick on its rest, a ball and a goal."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, cylinder, icosphere, merge, rod
from assets_lib.urdf import Link, Model, Shape, Vec3, Visual, box_shape, cylinder_shape, mesh_shape, sphere_shape

SLANT = 0.43
"""Angle between the shaft and the floor when the blade lies flat [rad]."""
SHAFT_RADIUS, SHAFT = 0.01, (-0.03, 0.29)
"""Radius, and both ends along the shaft from the grip [m]."""
GRIP_HEIGHT = 0.14
"""Height of the grip over the floor when the blade lies flat [m]."""
BLADE = (0.07, 0.01, 0.03)
BLADE_X = 0.285
REST_X = 0.08
BALL = 0.0175
GOAL = (0.14, 0.08, 0.09)
POST = 0.004
BLUE, TAPE, WHITE = (0.10, 0.30, 0.72), (0.12, 0.12, 0.13), (0.97, 0.97, 0.95)
COS, SIN = float(np.cos(SLANT)), float(np.sin(SLANT))


def _on_shaft(along: float, above: float = 0.0, side: float = 0.0) -> Vec3:
    """Return the place at a distance along the shaft from the grip, and above it."""
    return (along * COS + above * SIN, side, -along * SIN + above * COS)


def _stick() -> Model:
    length, middle = SHAFT[1] - SHAFT[0], (SHAFT[0] + SHAFT[1]) / 2.0
    tilt = (0.0, float(np.pi / 2.0) + SLANT, 0.0)
    blade = box_shape(BLADE, (BLADE_X, 0.0, BLADE[2] / 2.0 - GRIP_HEIGHT))
    toe = cylinder(BLADE[2] / 2.0, BLADE[1], 18).moved(
        (BLADE_X + BLADE[0] / 2.0, 0.0, blade.xyz[2]), (float(np.pi / 2.0), 0.0, 0.0)
    )
    taped = [rod(_on_shaft(a), _on_shaft(b), SHAFT_RADIUS + 0.001, 14) for a, b in ((-0.03, 0.035), (0.24, 0.25))]
    stripes = [rod(_on_shaft(a), _on_shaft(a + 0.012), SHAFT_RADIUS + 0.0006, 14) for a in (0.11, 0.13)]
    visuals = (
        Visual(mesh_shape("shaft", rod(_on_shaft(SHAFT[0]), _on_shaft(SHAFT[1]), SHAFT_RADIUS, 14)), BLUE),
        Visual(mesh_shape("blade", merge([blade.mesh(), toe])), BLUE, crease=0.3),
        Visual(mesh_shape("tape", merge(taped)), TAPE),
        Visual(mesh_shape("stripes", merge(stripes)), WHITE),
    )
    shapes = (cylinder_shape(SHAFT_RADIUS, length, _on_shaft(middle), tilt), blade)
    link = Link("hockey_stick", 0.2, visuals, shapes, friction=0.8)
    notes = (
        f"shaft from the grip downwards along +x, slanted by {SLANT} rad, diameter {2 * SHAFT_RADIUS}",
        f"blade at x = {BLADE_X}, its faces towards +-y",
        f"with the blade flat on the table the grip is at z = {GRIP_HEIGHT}; lies on `hockey_rest` that stands below the grip",
    )
    return Model("hockey_stick", "objects/hockey_stick", "grip on the axis of the shaft", (link,), notes=notes)


def _rest() -> Model:
    """Return a forked post; its origin is on the floor below the grip of the stick."""
    along = REST_X / COS
    pitch = (0.0, SLANT, 0.0)

    def lifted(above: float, side: float) -> Vec3:
        x, y, z = _on_shaft(along, above, side)
        return (x, y, z + GRIP_HEIGHT)

    saddle = box_shape((0.02, 0.034, 0.006), lifted(-SHAFT_RADIUS - 0.003, 0.0), pitch)
    prongs = tuple(box_shape((0.02, 0.005, 0.022), lifted(-0.002, s * 0.0145), pitch) for s in (-1.0, 1.0))
    tall = saddle.xyz[2] - 0.004
    post = box_shape((0.016, 0.02, tall), (saddle.xyz[0], 0.0, tall / 2.0))
    foot = box_shape((0.07, 0.09, 0.006), (saddle.xyz[0], 0.0, 0.003))
    shapes: tuple[Shape, ...] = (saddle, *prongs, post, foot)
    mesh = merge(shape.mesh() for shape in shapes)
    link = Link("hockey_rest", 0.5, (Visual(mesh_shape("fork", mesh), (0.36, 0.38, 0.42), crease=0.1),), shapes)
    return Model("hockey_rest", "objects/hockey_rest", "on the floor below the grip of the stick", (link,))


def _ball() -> Model:
    visuals = (Visual(mesh_shape("ball", icosphere(BALL, 2)), WHITE, crease=1.2),)
    link = Link("hockey_ball", 0.03, visuals, (sphere_shape(BALL),), friction=0.6, rolling=0.0002)
    return Model("hockey_ball", "objects/hockey_ball", "centre", (link,), notes=(f"rests with its origin at {BALL} m",))


def _net() -> Mesh:
    """Return the strings of the net: back, sides and top."""
    x, y, z = GOAL
    strings = []
    for i in range(1, 9):
        u = -x / 2.0 + x * i / 9
        strings += [rod((u, y, 0.0), (u, y, z), 0.0007, 3), rod((u, 0.0, z), (u, y, z), 0.0007, 3)]
    for i in range(6):
        h, v = z * (i + 0.5) / 6, y * (i + 0.5) / 6
        strings += [rod((-x / 2.0, y, h), (x / 2.0, y, h), 0.0007, 3), rod((-x / 2.0, v, z), (x / 2.0, v, z), 0.0007, 3)]
        for side in (-x / 2.0, x / 2.0):
            strings += [rod((side, 0.0, h), (side, y, h), 0.0007, 3), rod((side, v, 0.0), (side, v, z), 0.0007, 3)]
    return merge(strings)


def _goal() -> Model:
    """Return a goal that opens towards -y."""
    x, y, z = GOAL
    corners = [(s * x / 2.0, v) for s in (-1.0, 1.0) for v in (0.0, y)]
    bars = [rod((u, v, 0.0), (u, v, z), POST, 10) for u, v in corners]
    bars += [rod((-x / 2.0, v, z), (x / 2.0, v, z), POST, 10) for v in (0.0, y)]
    bars += [rod((s * x / 2.0, 0.0, h), (s * x / 2.0, y, h), POST, 8) for s in (-1.0, 1.0) for h in (POST, z)]
    bars.append(rod((-x / 2.0, y, POST), (x / 2.0, y, POST), POST, 8))
    thick = 2 * POST
    shapes = (
        *(box_shape((thick, y, z), (s * x / 2.0, y / 2.0, z / 2.0)) for s in (-1.0, 1.0)),
        box_shape((x, thick, z), (0.0, y, z / 2.0)),
        box_shape((x, y, thick), (0.0, y / 2.0, z)),
    )
    visuals = (
        Visual(mesh_shape("frame", merge(bars)), (0.85, 0.10, 0.10)),
        Visual(mesh_shape("net", _net()), (0.95, 0.95, 0.95), crease=0.1),
    )
    notes = (f"opens towards -y, its line at y = 0; {x} wide, {y} deep, {z} high; sides, back and top are closed",)
    return Model(
        "hockey_goal",
        "objects/hockey_goal",
        "on the floor, middle of the line",
        (Link("hockey_goal", 1.0, visuals, shapes),),
        notes=notes,
    )


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_stick(), _rest(), _ball(), _goal())
