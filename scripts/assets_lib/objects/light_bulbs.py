"""A lamp with an open socket and a reflector, a holder with the same socket, and a pear-shaped bulb."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from assets_lib.mesh import Mesh, box, hull_of, lathe, merge, rod
from assets_lib.objects.saucepan import wall_boxes
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, cylinder_shape, glass, mesh_shape, metal, plastic, sphere_shape

SOCKET_RADIUS, SOCKET_DEPTH, WALL, FLOOR = 0.016, 0.03, 0.006, 0.004
SEGMENTS = 8
FOOT_RADIUS, FOOT_HEIGHT = 0.06, 0.03
HOLDER_RADIUS = 0.03
REFLECTOR_LOW, REFLECTOR_RIM, REFLECTOR_WALL = (0.023, 0.042), (0.050, 0.064), 0.003
"""Radius and height of the lower and the upper edge of the reflector's inside, and its thickness along z [m]."""
GLASS, THREAD_RADIUS, THREAD_LENGTH, THREAD_TOP = 0.025, 0.013, 0.03, -0.046
COLLAR = 0.009
"""Height of the brass above the thread, which stays in sight when the thread is in a socket [m]."""
NECK_RADIUS = 0.0145
SEATED = -THREAD_TOP + THREAD_LENGTH
"""Height of the bulb's origin above the floor of a socket in which it stands [m]."""
DARK, BRASS, WHITE = (0.16, 0.17, 0.20), metal((0.83, 0.62, 0.20)), (1.0, 1.0, 1.0)
GLOW = (1.0, 0.91, 0.66)
"""Colour of the glass while it shines."""
ENAMEL, GREEN = plastic((0.93, 0.92, 0.86)), (0.05, 0.38, 0.30)


def _socket(low: float, outer: float) -> Mesh:
    """Return a tube with a floor, its foot at height `low`."""
    rim, floor = low + FLOOR + SOCKET_DEPTH, low + FLOOR
    outside = [(0.0, low), (outer, low), (outer, rim - 0.002), (outer - 0.002, rim)]
    return lathe([*outside, (SOCKET_RADIUS, rim), (SOCKET_RADIUS, floor), (0.0, floor)], 18)


def _socket_shapes(low: float, outer: float) -> tuple[Shape, ...]:
    rim, floor = low + FLOOR + SOCKET_DEPTH, low + FLOOR
    walls = wall_boxes(outer, rim, outer - SOCKET_RADIUS, floor, SEGMENTS)
    return (cylinder_shape(outer, FLOOR, (0.0, 0.0, low + FLOOR / 2.0)), *walls)


def _reflector() -> tuple[Mesh, Mesh]:
    """Return the enamelled inside and the outside of the reflector."""
    (low, z), (rim, top) = REFLECTOR_LOW, REFLECTOR_RIM
    under = [(low, z - REFLECTOR_WALL), (rim, top - REFLECTOR_WALL), (rim, top)]
    return lathe([(rim, top), (low, z)], 20), lathe([*under, (low, z - REFLECTOR_WALL / 2.0), under[0]], 20)


def _reflector_shapes() -> tuple[Shape, ...]:
    """Return the reflector as convex panels."""
    half = np.pi / SEGMENTS
    corners = [
        (radius, side * radius * float(np.tan(half)), z - down)
        for radius, z in (REFLECTOR_LOW, REFLECTOR_RIM)
        for side in (-1.0, 1.0)
        for down in (0.0, REFLECTOR_WALL)
    ]
    panel = hull_of(np.array(corners))
    return tuple(mesh_shape("reflector_panel", panel, rpy=(0.0, 0.0, 2.0 * float(half) * k)) for k in range(SEGMENTS))


def _cable() -> Mesh:
    """Return the cable and the plug at its end."""
    steps = [(-0.058, 0.0), (-0.10, 0.0), (-0.122, 0.022)]
    rods = [rod((*a, 0.006), (*b, 0.006), 0.0035, 6) for a, b in pairwise(steps)]
    along, across = np.array([-0.7071, 0.7071, 0.0]), np.array([0.7071, 0.7071, 0.0])
    end = np.array([*steps[-1], 0.0075])
    plug = rod(end, end + 0.016 * along, 0.0075, 10)
    prongs = [rod(end + side * across, end + side * across + 0.026 * along, 0.0014, 6) for side in (-0.004, 0.004)]
    return merge([*rods, plug, *prongs])


def _lamp() -> Model:
    foot = [(0.0, 0.0), (FOOT_RADIUS, 0.0), (FOOT_RADIUS, 0.016), (FOOT_RADIUS - 0.012, FOOT_HEIGHT), (0.0, FOOT_HEIGHT)]
    switch = box((0.016, 0.010, 0.006), (0.044, 0.0, FOOT_HEIGHT - 0.001))
    outer = SOCKET_RADIUS + WALL
    inside, outside = _reflector()
    visuals = (
        Visual(mesh_shape("foot", lathe(foot, 24)), DARK),
        Visual(mesh_shape("socket", _socket(FOOT_HEIGHT, outer)), BRASS),
        Visual(mesh_shape("reflector", inside), ENAMEL),
        Visual(mesh_shape("shade", outside), GREEN),
        Visual(mesh_shape("cable", _cable()), (0.25, 0.25, 0.27)),
        Visual(mesh_shape("switch", switch), (0.85, 0.2, 0.15)),
    )
    solid = cylinder_shape(FOOT_RADIUS, FOOT_HEIGHT, (0.0, 0.0, FOOT_HEIGHT / 2.0))
    shapes = (solid, *_socket_shapes(FOOT_HEIGHT, outer), *_reflector_shapes())
    link = Link("bulb_lamp", 1.0, visuals, shapes, friction=0.5)
    floor = FOOT_HEIGHT + FLOOR
    notes = (
        f"open socket, inner diameter {2 * SOCKET_RADIUS}, floor at z = {floor}, rim at z = {floor + SOCKET_DEPTH}",
        f"reflector around it, up to radius {REFLECTOR_RIM[0]} at z = {REFLECTOR_RIM[1]}",
        f"a `light_bulb` in it has its origin at z = {floor + SEATED:.3f}",
    )
    return Model("bulb_lamp", "objects/bulb_lamp", "bottom centre", (link,), notes=notes)


def _holder() -> Model:
    visuals = (Visual(mesh_shape("holder", _socket(0.0, HOLDER_RADIUS)), (0.9, 0.1, 0.1)),)
    link = Link("bulb_holder", 0.3, visuals, _socket_shapes(0.0, HOLDER_RADIUS), friction=0.5)
    notes = (
        f"the socket of `bulb_lamp`, floor at z = {FLOOR}, rim at z = {FLOOR + SOCKET_DEPTH}, diameter {2 * HOLDER_RADIUS}",
        f"a `light_bulb` in it has its origin at z = {FLOOR + SEATED:.3f}",
    )
    return Model("bulb_holder", "objects/bulb_holder", "bottom centre", (link,), notes=notes)


def _glass_outline() -> list[tuple[float, float]]:
    """Return the outline of a pear: a ball that narrows towards the collar."""
    low = THREAD_TOP + COLLAR
    angles = np.linspace(-0.45, np.pi / 2.0, 8)
    ball = [(GLASS * float(np.cos(a)), GLASS * float(np.sin(a))) for a in angles[:-1]]
    return [(0.0, low), (NECK_RADIUS - 0.001, low), (0.0155, low + 0.008), (0.0195, -0.0185), *ball, (0.0, GLASS)]


def _thread_mesh() -> Mesh:
    """Return the contact, three turns of thread and the collar above them."""
    low, high = THREAD_TOP - THREAD_LENGTH, THREAD_TOP
    outline = [(0.0, low), (0.006, low), (0.008, low + 0.004)]
    for i in range(3):
        z = low + 0.004 + i * 0.008
        outline += [(THREAD_RADIUS - 0.0015, z), (THREAD_RADIUS, z + 0.004)]
    outline += [(THREAD_RADIUS - 0.0015, high - 0.002), (NECK_RADIUS, high), (NECK_RADIUS, high + COLLAR)]
    return lathe([*outline, (0.0, high + COLLAR)], 16)


def _bulb() -> Model:
    pear = Visual(mesh_shape("glass", lathe(_glass_outline(), 20)), replace(glass(WHITE), emission=GLOW, reach=0.25), crease=1.2)
    top = THREAD_TOP + COLLAR
    neck = cylinder_shape(NECK_RADIUS, -0.016 - top, (0.0, 0.0, (top - 0.016) / 2.0))
    ball = Link("glass", 0.03, (pear,), (sphere_shape(GLASS), neck), friction=1.0)
    middle = (0.0, 0.0, THREAD_TOP - THREAD_LENGTH / 2.0)
    thread = Visual(mesh_shape("thread", _thread_mesh()), BRASS, crease=0.4)
    collar = cylinder_shape(NECK_RADIUS, COLLAR, (0.0, 0.0, THREAD_TOP + COLLAR / 2.0))
    screw = Link("thread", 0.03, (thread,), (cylinder_shape(THREAD_RADIUS, THREAD_LENGTH, middle), collar), friction=0.5)
    joint = Joint("neck", "fixed", "glass", "thread", (0.0, 0.0, 0.0))
    notes = (
        f"glass diameter {2 * GLASS}; thread {2 * THREAD_RADIUS} from z = {THREAD_TOP - THREAD_LENGTH:.3f} to {THREAD_TOP}, "
        f"a collar of {2 * NECK_RADIUS} above it",
        "recolour the link `glass` alone; no thread is simulated",
    )
    return Model("light_bulb", "objects/light_bulb", "centre of the glass", (ball, screw), (joint,), notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_lamp(), _holder(), _bulb())
