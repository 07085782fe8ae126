"""A lamp with an open socket, a holder with the same socket, and a bulb."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, lathe, merge, rod
from assets_lib.objects.saucepan import wall_boxes
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, cylinder_shape, mesh_shape, sphere_shape

SOCKET_RADIUS, SOCKET_DEPTH, WALL, FLOOR = 0.016, 0.03, 0.006, 0.004
SEGMENTS = 8
FOOT_RADIUS, FOOT_HEIGHT = 0.06, 0.03
HOLDER_RADIUS = 0.03
GLASS, THREAD_RADIUS, THREAD_LENGTH, THREAD_TOP = 0.025, 0.013, 0.03, -0.022
SEATED = -THREAD_TOP + THREAD_LENGTH
"""Height of the bulb's origin above the floor of a socket in which it stands [m]."""
DARK, BRASS, WHITE = (0.16, 0.17, 0.20), (0.83, 0.68, 0.34), (1.0, 1.0, 1.0)


def _socket(low: float, outer: float) -> Mesh:
    """Return a tube with a floor, its foot at height `low`."""
    rim, floor = low + FLOOR + SOCKET_DEPTH, low + FLOOR
    outside = [(0.0, low), (outer, low), (outer, rim - 0.002), (outer - 0.002, rim)]
    return lathe([*outside, (SOCKET_RADIUS, rim), (SOCKET_RADIUS, floor), (0.0, floor)], 24)


def _socket_shapes(low: float, outer: float) -> tuple[Shape, ...]:
    rim, floor = low + FLOOR + SOCKET_DEPTH, low + FLOOR
    walls = wall_boxes(outer, rim, outer - SOCKET_RADIUS, floor, SEGMENTS)
    return (cylinder_shape(outer, FLOOR, (0.0, 0.0, low + FLOOR / 2.0)), *walls)


def _lamp() -> Model:
    foot = [(0.0, 0.0), (FOOT_RADIUS, 0.0), (FOOT_RADIUS, 0.016), (FOOT_RADIUS - 0.012, FOOT_HEIGHT), (0.0, FOOT_HEIGHT)]
    cable = merge(
        [rod((-0.058, 0.0, 0.006), (-0.10, 0.0, 0.006), 0.004, 8), rod((-0.10, 0.0, 0.006), (-0.13, 0.03, 0.005), 0.004, 8)]
    )
    switch = box((0.016, 0.010, 0.006), (0.044, 0.0, FOOT_HEIGHT - 0.001))
    outer = SOCKET_RADIUS + WALL
    visuals = (
        Visual(mesh_shape("foot", lathe(foot, 32)), DARK),
        Visual(mesh_shape("socket", _socket(FOOT_HEIGHT, outer)), BRASS),
        Visual(mesh_shape("cable", cable), (0.25, 0.25, 0.27)),
        Visual(mesh_shape("switch", switch), (0.85, 0.2, 0.15)),
    )
    solid = cylinder_shape(FOOT_RADIUS, FOOT_HEIGHT, (0.0, 0.0, FOOT_HEIGHT / 2.0))
    link = Link("bulb_lamp", 1.0, visuals, (solid, *_socket_shapes(FOOT_HEIGHT, outer)), friction=0.5)
    floor = FOOT_HEIGHT + FLOOR
    notes = (
        f"open socket, inner diameter {2 * SOCKET_RADIUS}, floor at z = {floor}, rim at z = {floor + SOCKET_DEPTH}",
        f"a `light_bulb` in it has its origin at z = {floor + SEATED}",
    )
    return Model("bulb_lamp", "objects/bulb_lamp", "bottom centre", (link,), notes=notes)


def _holder() -> Model:
    visuals = (Visual(mesh_shape("holder", _socket(0.0, HOLDER_RADIUS)), (0.9, 0.1, 0.1)),)
    link = Link("bulb_holder", 0.3, visuals, _socket_shapes(0.0, HOLDER_RADIUS), friction=0.5)
    notes = (
        f"the socket of `bulb_lamp`, floor at z = {FLOOR}, rim at z = {FLOOR + SOCKET_DEPTH}, diameter {2 * HOLDER_RADIUS}",
        f"a `light_bulb` in it has its origin at z = {FLOOR + SEATED}",
    )
    return Model("bulb_holder", "objects/bulb_holder", "bottom centre", (link,), notes=notes)


def _glass_outline() -> list[tuple[float, float]]:
    """Return the outline of a pear: a ball that narrows towards the thread."""
    angles = np.linspace(-np.pi / 3.2, np.pi / 2.0, 10)
    ball = [(GLASS * float(np.cos(a)), GLASS * float(np.sin(a))) for a in angles[:-1]]
    return [(0.0, THREAD_TOP), (THREAD_RADIUS - 0.001, THREAD_TOP), *ball, (0.0, GLASS)]


def _thread_mesh() -> Mesh:
    low, high = THREAD_TOP - THREAD_LENGTH, THREAD_TOP
    outline = [(0.0, low), (0.006, low), (0.008, low + 0.004)]
    for i in range(4):
        z = low + 0.004 + i * 0.006
        outline += [
            (THREAD_RADIUS - 0.0015, z),
            (THREAD_RADIUS, z + 0.002),
            (THREAD_RADIUS, z + 0.004),
            (THREAD_RADIUS - 0.0015, z + 0.006),
        ]
    return lathe([*outline, (THREAD_RADIUS - 0.001, high), (0.0, high)], 16)


def _bulb() -> Model:
    glass = Visual(mesh_shape("glass", lathe(_glass_outline(), 24)), WHITE, crease=1.2)
    ball = Link("glass", 0.03, (glass,), (sphere_shape(GLASS),), friction=1.0)
    middle = (0.0, 0.0, THREAD_TOP - THREAD_LENGTH / 2.0)
    thread = Visual(mesh_shape("thread", _thread_mesh()), (0.66, 0.67, 0.70), crease=0.4)
    screw = Link("thread", 0.03, (thread,), (cylinder_shape(THREAD_RADIUS, THREAD_LENGTH, middle),), friction=0.5)
    joint = Joint("neck", "fixed", "glass", "thread", (0.0, 0.0, 0.0))
    notes = (
        f"glass diameter {2 * GLASS}; thread {2 * THREAD_RADIUS} from z = {THREAD_TOP - THREAD_LENGTH:.3f} to {THREAD_TOP}",
        "recolour the link `glass` alone; no thread is simulated",
    )
    return Model("light_bulb", "objects/light_bulb", "centre of the glass", (ball, screw), (joint,), notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_lamp(), _holder(), _bulb())
