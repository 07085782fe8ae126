"""A folded umbrella, a stand for it, and a rest on which it lies."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, cylinder, icosphere, lathe, merge, rod
from assets_lib.prisms import bevelled_box
from assets_lib.urdf import (
    Link,
    Model,
    Vec3,
    Visual,
    box_shape,
    cylinder_shape,
    mesh_shape,
    metal,
    patterned,
    plastic,
    sphere_shape,
)

LENGTH = 0.34
SPIKE, CANOPY, CANOPY_RADIUS = 0.005, (0.035, 0.235), 0.015
"""Radius of the spike; where the canopy lies, from the tip, and its radius [m]."""
NARROW = (0.10, 0.010)
"""Where the canopy has its full radius, and the radius of its lower part [m]."""
HANDLE = 0.007
HOOK = (0.018, 0.315)
"""Radius of the hook, and height of the middle of its arc over the tip [m]."""
STAND, WALL, FLOOR, SEGMENTS = (0.06, 0.18), 0.005, 0.006, 16
"""Outer radius and height [m]."""
REST_HEIGHT, FORKS = 0.06, (0.12, 0.215)
"""Height of the axis of the umbrella on its rest, and places of the two forks along it [m]."""
NAVY, STRAP, WOOD = (0.17, 0.26, 0.44), (0.80, 0.74, 0.62), (0.50, 0.31, 0.17)
BRONZE, STEEL = metal((0.47, 0.38, 0.28)), metal((0.72, 0.73, 0.75))


def _arc(radius: float = HOOK[0], count: int = 9) -> list[Vec3]:
    """Return points on the axis of the hook, from the top of the handle to its end."""
    points = [
        (HOOK[0] - radius * float(np.cos(a)), 0.0, HOOK[1] + radius * float(np.sin(a))) for a in np.linspace(0, np.pi, count)
    ]
    return [*points, (2.0 * HOOK[0], 0.0, HOOK[1] - 0.012)]


def _folds() -> Mesh:
    """Return the canopy, its cloth wrapped in eight folds."""
    low, high = CANOPY
    profile = [(0.0, low), (0.006, low), (NARROW[1], low + 0.02), (CANOPY_RADIUS - 0.001, NARROW[0])]
    profile += [(CANOPY_RADIUS - 0.0005, high - 0.02), (0.011, high), (0.0, high)]
    mesh = lathe(profile, 40)
    x, y, z = mesh.vertices.T
    angle = np.arctan2(y, x) + 9.0 * z
    factor = 1.0 - 0.12 * (0.5 + 0.5 * np.cos(8.0 * angle))
    return Mesh(np.column_stack([x * factor, y * factor, z]), mesh.faces)


def _umbrella() -> Model:
    low, high = CANOPY
    arc = _arc()
    handle = [rod((0.0, 0.0, high - 0.005), (0.0, 0.0, HOOK[1]), HANDLE, 10)]
    handle += [rod(a, b, HANDLE, 8) for a, b in zip(arc[:-1], arc[1:], strict=True)]
    handle += [icosphere(HANDLE, 1).moved(p) for p in arc[-1:]]
    strap = lathe([(0.013, 0.175), (0.0156, 0.175), (0.0156, 0.189), (0.013, 0.189)], 20)
    spike = merge([rod((0.0, 0.0, SPIKE), (0.0, 0.0, low + 0.004), SPIKE, 8), icosphere(SPIKE, 1).moved((0.0, 0.0, SPIKE))])
    button = cylinder(0.004, 0.003, 10).moved((0.0, -0.0155, 0.182), (np.pi / 2.0, 0.0, 0.0))
    visuals = (
        Visual(mesh_shape("canopy", _folds()), patterned(NAVY, "cloth"), crease=0.4),
        Visual(mesh_shape("strap", strap), STRAP),
        Visual(mesh_shape("button", button), STEEL),
        Visual(mesh_shape("spike", spike), STEEL),
        Visual(mesh_shape("handle", merge(handle)), patterned(plastic(WOOD), "wood")),
    )
    a, b = NARROW[0], CANOPY_RADIUS
    straight = HOOK[1] - high
    corners = _arc(count=5)
    hook = []
    for p, q in zip(corners[:-1], corners[1:], strict=True):
        length = float(np.hypot(q[0] - p[0], q[2] - p[2]))
        pitch = float(np.arctan2(q[0] - p[0], q[2] - p[2]))
        middle = ((p[0] + q[0]) / 2.0, 0.0, (p[2] + q[2]) / 2.0)
        hook.append(box_shape((2 * HANDLE, 2 * HANDLE, length + 0.004), middle, (0.0, pitch, 0.0)))
    shapes = (
        sphere_shape(SPIKE, (0.0, 0.0, SPIKE)),
        cylinder_shape(SPIKE, low - SPIKE, (0.0, 0.0, (low + SPIKE) / 2.0)),
        cylinder_shape(NARROW[1], a - low, (0.0, 0.0, (a + low) / 2.0)),
        cylinder_shape(b, high - a, (0.0, 0.0, (a + high) / 2.0)),
        box_shape((2 * HANDLE, 2 * HANDLE, straight), (0.0, 0.0, high + straight / 2.0)),
        *hook,
    )
    link = Link("umbrella", 0.1, visuals, shapes, friction=0.6, rolling=0.0003, center=(0.002, 0.0, 0.155))
    notes = (
        f"along z, {LENGTH} long, canopy of diameter {2 * CANOPY_RADIUS} from z = {low} to {high}",
        f"handle {2 * HANDLE} thick up to z = {HOOK[1]}; hook towards +x, its top around ({HOOK[0]}, 0, {HOOK[1] + HOOK[0]})",
    )
    return Model("umbrella", "objects/umbrella", "end of the spike", (link,), notes=notes)


def _stand() -> Model:
    radius, height = STAND
    middle = radius - WALL / 2.0
    width = 2.0 * radius * float(np.tan(np.pi / SEGMENTS))
    walls = []
    for i in range(SEGMENTS):
        a = 2.0 * float(np.pi) * i / SEGMENTS
        place = (middle * float(np.cos(a)), middle * float(np.sin(a)), height / 2.0)
        walls.append(box_shape((WALL, width, height), place, (0.0, 0.0, a)))
    shell = lathe(
        [(0.0, 0.0), (radius - 0.003, 0.0), (radius, 0.003), (radius, height - 0.002), (radius - 0.0015, height)]
        + [(radius - WALL, height), (radius - WALL, FLOOR), (0.0, FLOOR)],
        32,
    )
    bands = []
    for low, high, out in ((0.0, 0.014, 0.003), (height - 0.016, height - 0.004, 0.0022)):
        bands.append(
            lathe([(radius - 0.002, low), (radius + out, low + 0.001), (radius + out, high - 0.001), (radius - 0.002, high)], 36)
        )
    ribs = [
        box((0.0025, 0.005, height - 0.04))
        .moved((radius + 0.0008, 0.0, height / 2.0))
        .moved((0, 0, 0), (0.0, 0.0, 2 * np.pi * i / 16))
        for i in range(16)
    ]
    visuals = (
        Visual(mesh_shape("shell", shell), patterned(BRONZE, "brushed")),
        Visual(mesh_shape("bands", merge(bands)), metal((0.80, 0.64, 0.36))),
        Visual(mesh_shape("ribs", merge(ribs)), metal((0.40, 0.32, 0.24))),
    )
    floor = cylinder_shape(radius - WALL, FLOOR, (0.0, 0.0, FLOOR / 2.0))
    link = Link("umbrella_stand", 2.0, visuals, (floor, *walls), friction=0.8)
    notes = (f"hollow, open above; inner radius {radius - WALL}, floor at z = {FLOOR}, rim at z = {height}",)
    return Model("umbrella_stand", "objects/umbrella_stand", "bottom centre", (link,), notes=notes)


def _rest() -> Model:
    """Return two forks on a board, 45 degrees steep inside; its origin is on the floor below the tip of the umbrella."""
    board = ((FORKS[1] - FORKS[0]) + 0.05, 0.09, 0.010)
    place = ((FORKS[0] + FORKS[1]) / 2.0, 0.0, board[2] / 2.0)
    valley = REST_HEIGHT - CANOPY_RADIUS * float(np.sqrt(2.0))
    arm, thick = 0.030, 0.008
    shapes = [box_shape(board, place)]
    posts = []
    for x in FORKS:
        for s in (-1.0, 1.0):
            out = arm / 2.0 / float(np.sqrt(2.0))
            under = thick / 2.0 / float(np.sqrt(2.0))
            shapes.append(
                box_shape((0.012, arm, thick), (x, s * (out + under), valley + out - under), (s * float(np.pi / 4.0), 0.0, 0.0))
            )
        tall = valley - 0.004 - board[2]
        shapes.append(box_shape((0.012, 0.02, tall), (x, 0.0, board[2] + tall / 2.0)))
        posts.append(bevelled_box((0.012, 0.02, tall), 0.001).moved((x, 0.0, board[2])))
    arms = [s.mesh() for s in shapes if s.rpy[0]]
    visuals = (
        Visual(
            mesh_shape("board", bevelled_box(board, 0.003).moved((place[0], 0.0, 0.0))), patterned((0.62, 0.47, 0.31), "wood")
        ),
        Visual(mesh_shape("forks", merge([*posts, *arms])), patterned((0.50, 0.36, 0.23), "wood")),
    )
    link = Link("umbrella_rest", 0.6, visuals, tuple(shapes), friction=0.6)
    notes = (f"the umbrella lies along x on it, its tip at x = 0 and its axis at z = {REST_HEIGHT}",)
    return Model("umbrella_rest", "objects/umbrella_rest", "on the floor below the tip of the umbrella", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_umbrella(), _stand(), _rest())
