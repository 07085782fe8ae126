"""A watering can and a plant in a pot."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, hull_of, icosphere, lathe, merge, rod
from assets_lib.objects.cups import leaning_walls
from assets_lib.urdf import Link, Model, Shape, Vec3, Visual, cylinder_shape, glass, mesh_shape, metal

RADIUS, HEIGHT = 0.045, 0.10
SPOUT, SPOUT_RADIUS = ((0.036, 0.030), (0.116, 0.110)), 0.007
"""x and z of both ends of the spout, and its radius [m]."""
ROSE = 0.017
"""Radius of the head of the spout [m]."""
HEAD: Vec3 = (0.1265, 0.0, 0.117)
"""Middle of the holes of the head [m]."""
FACE = 0.985
"""Angle between where they face and upwards [rad]."""
SLOPE, BAR, BAR_RADIUS = 0.2, 0.09, 0.009
"""Slope of the handle bar, which rises towards the spout [rad], its length and radius [m]."""
GRIP: Vec3 = (-0.02, 0.0, 0.155)
POT, POT_TOP, POT_HEIGHT, POT_WALL, SOIL = 0.045, 0.06, 0.10, 0.006, 0.07
"""Radius below and at the rim, height, wall, height of the soil [m]."""
STEM: tuple[Vec3, Vec3] = ((0.028, 0.0, 0.06), (0.036, 0.0, 0.20))
ENAMEL, BRASS = glass((0.28, 0.47, 0.45)), metal((0.72, 0.55, 0.27))
CLAY, EARTH, LEAF, FLOWER, HEART = (
    (0.68, 0.36, 0.22),
    (0.17, 0.11, 0.07),
    (0.27, 0.47, 0.17),
    (0.86, 0.52, 0.62),
    (0.90, 0.72, 0.20),
)


def _bar_ends() -> tuple[Vec3, Vec3]:
    half = BAR / 2.0
    x, z = half * float(np.cos(SLOPE)), half * float(np.sin(SLOPE))
    return (GRIP[0] - x, 0.0, GRIP[2] - z), (GRIP[0] + x, 0.0, GRIP[2] + z)


def _tube(start: Vec3, end: Vec3, radius: float) -> Shape:
    """Return a cylinder between two points of the plane y = 0."""
    a, b = np.array(start), np.array(end)
    pitch = float(np.arctan2(b[0] - a[0], b[2] - a[2]))
    x, _, z = (a + b) / 2.0
    return cylinder_shape(radius, float(np.linalg.norm(b - a)), (float(x), 0.0, float(z)), (0.0, pitch, 0.0))


def _can() -> Model:
    rear, front = _bar_ends()
    struts = [(rear, (-RADIUS + 0.003, 0.0, 0.055)), (front, (0.030, 0.0, HEIGHT - 0.002))]
    (x0, z0), (x1, z1) = SPOUT
    spout = rod((x0, 0.0, z0), (x1, 0.0, z1), SPOUT_RADIUS, 10)
    body = lathe(
        [
            (0.0, 0.0),
            (RADIUS - 0.002, 0.0),
            (RADIUS, 0.003),
            (RADIUS, HEIGHT - 0.002),
            (RADIUS - 0.0015, HEIGHT),
            (RADIUS - 0.003, HEIGHT - 0.002),
            (RADIUS - 0.003, 0.072),
            (0.0, 0.072),
        ],
        24,
    )
    water = lathe([(0.0, 0.0735), (RADIUS - 0.003, 0.0735), (0.0, 0.0737)], 16)
    hoops = [
        lathe([(RADIUS, z), (RADIUS + 0.0012, z + 0.001), (RADIUS + 0.0012, z + 0.004), (RADIUS, z + 0.005)], 24)
        for z in (0.006, 0.088)
    ]
    cone = lathe([(0.0, -0.016), (SPOUT_RADIUS, -0.016), (ROSE, -0.002), (ROSE, 0.0), (0.0, 0.0)], 14)
    holes = [
        lathe([(0.0017, 0.0), (0.0, 0.0003)], 6).moved((r * float(np.cos(a)), r * float(np.sin(a)), 0.0003))
        for r, n in ((0.0, 1), (0.006, 6), (0.012, 10))
        for a in np.arange(n) * 2.0 * np.pi / n
    ]
    face = (0.0, FACE, 0.0)
    curve = [rod(a, b, BAR_RADIUS * 0.6, 8) for a, b in struts]
    knees = [icosphere(BAR_RADIUS * 0.98, 1).moved(place) for place in (rear, front)]
    visuals = (
        Visual(mesh_shape("body", body), ENAMEL),
        Visual(mesh_shape("spout", merge([spout, *curve])), ENAMEL),
        Visual(mesh_shape("bar", merge([rod(rear, front, BAR_RADIUS, 10), *knees])), (0.42, 0.25, 0.13)),
        Visual(mesh_shape("hoops", merge(hoops)), BRASS),
        Visual(mesh_shape("rose", cone.moved(HEAD, face)), BRASS),
        Visual(mesh_shape("holes", merge(holes).moved(HEAD, face)), (0.10, 0.09, 0.08)),
        Visual(mesh_shape("water", water), glass((0.25, 0.50, 0.72))),
    )
    shapes = (
        cylinder_shape(RADIUS, HEIGHT, (0.0, 0.0, HEIGHT / 2.0)),
        _tube((x0, 0.0, z0), (x1, 0.0, z1), SPOUT_RADIUS),
        _tube(rear, front, BAR_RADIUS),
        *(_tube(a, b, BAR_RADIUS * 0.6) for a, b in struts),
    )
    link = Link("watering_can", 0.2, visuals, shapes, friction=0.8, center=(0.0, 0.0, 0.045))
    notes = (
        f"body {2 * RADIUS} across and {HEIGHT} high; spout towards +x, middle of its head at {HEAD}, {FACE} rad from upwards",
        f"handle bar, diameter {2 * BAR_RADIUS}, in the plane y = 0, middle at {GRIP}, rising towards +x by {SLOPE} rad",
    )
    return Model("watering_can", "objects/watering_can", "bottom centre", (link,), notes=notes)


def _leaf(length: float, width: float, droop: float) -> Mesh:
    """Return a leaf along +x that bends down."""
    t = np.linspace(0.0, 1.0, 5)
    middle = np.column_stack([length * t, 0.0 * t, length * (0.45 * t - droop * t**2)])
    half = 0.5 * width * np.sin(np.pi * np.clip(t, 0.06, 0.98)) ** 0.8
    pieces = []
    for i in range(len(t) - 1):
        points = [middle[k] + (0.0, s * half[k], w) for k in (i, i + 1) for s in (-1.0, 1.0) for w in (0.0, 0.0012)]
        pieces.append(hull_of(np.round(np.array(points), 6)))
    return merge(pieces)


def _plant() -> Model:
    bottom, top = STEM
    height = top[2] - bottom[2]
    leaves = []
    for share, turn, length in (
        (0.28, 0.9, 0.055),
        (0.34, -0.9, 0.055),
        (0.50, 0.1, 0.05),
        (0.62, 2.0, 0.045),
        (0.66, -2.0, 0.045),
        (0.8, -0.2, 0.04),
    ):
        place = tuple(np.array(bottom) + share * (np.array(top) - bottom))
        leaves.append(_leaf(length, 0.024, 0.75).moved(place, (0.0, 0.0, turn)))
    petals = [
        lathe([(0.0, -0.0085), (0.0075, -0.0045), (0.0075, 0.0045), (0.0, 0.0085)], 8).moved(
            (0.011 * float(np.cos(a)), 0.011 * float(np.sin(a)), 0.0)
        )
        for a in np.arange(6) * np.pi / 3.0
    ]
    bend = (0.0, 0.7, 0.0)
    pot = lathe(
        [
            (0.0, 0.0),
            (POT - 0.002, 0.0),
            (POT, 0.002),
            (POT_TOP - 0.004, 0.078),
            (POT_TOP, 0.080),
            (POT_TOP, POT_HEIGHT - 0.002),
            (POT_TOP - 0.002, POT_HEIGHT),
            (POT_TOP - POT_WALL, POT_HEIGHT - 0.002),
            (POT_TOP - POT_WALL, SOIL),
            (0.0, SOIL),
        ],
        20,
    )
    soil = lathe([(POT_TOP - POT_WALL, SOIL + 0.0005), (0.02, SOIL + 0.001), (0.0, SOIL + 0.001)], 16)
    clods = [
        icosphere(0.004, 0).moved((r * float(np.cos(a)), r * float(np.sin(a)), SOIL - 0.001))
        for r, a in ((0.04, 0.4), (0.035, 1.6), (0.042, 2.6), (0.03, 3.9), (0.044, 5.0))
    ]
    visuals = (
        Visual(mesh_shape("pot", pot), CLAY),
        Visual(mesh_shape("soil", merge([soil, *clods])), EARTH, crease=0.1),
        Visual(mesh_shape("stem", rod(bottom, top, 0.003, 6)), LEAF),
        Visual(mesh_shape("leaves", merge(leaves)), LEAF, crease=0.4),
        Visual(mesh_shape("petals", merge(petals).moved(top, bend)), FLOWER),
        Visual(mesh_shape("heart", icosphere(0.008, 1).moved((top[0] + 0.003, 0.0, top[2] + 0.004))), HEART),
    )
    walls = leaning_walls(POT_TOP, POT_TOP, POT_HEIGHT, POT_WALL, SOIL - 0.01)
    foot = cylinder_shape(POT, SOIL, (0.0, 0.0, SOIL / 2.0))
    ground = cylinder_shape(POT_TOP - POT_WALL, 0.02, (0.0, 0.0, SOIL - 0.01))
    link = Link(
        "potted_plant",
        1.5,
        visuals,
        (foot, ground, *walls, cylinder_shape(0.003, height, (0.032, 0.0, bottom[2] + height / 2.0), (0.0, 0.057, 0.0))),
        friction=0.9,
    )
    notes = (
        f"pot {2 * POT_TOP} across and {POT_HEIGHT} high, open above; soil at z = {SOIL}",
        f"the stem stands at x = {bottom[0]}, the soil towards -x is free; leaves and flower are visual only",
    )
    return Model("potted_plant", "objects/potted_plant", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_can(), _plant())
