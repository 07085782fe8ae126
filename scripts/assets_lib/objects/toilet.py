"""A toilet with a cistern, and a seat on a hinge."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, box, cylinder, hull_of, merge, rod
from assets_lib.prisms import bevelled_box, mark
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, box_shape, glass, mesh_shape, metal, plastic

RIM, HEIGHT, WATER = 0.15, 0.24, 0.085
"""Heights of the rim of the bowl, of the cistern, and of the water in the bowl [m]."""
CISTERN = (0.054, 0.22, 0.125)
BACK = 0.15
"""x of the back of the cistern [m]."""
SEAT = (0.218, 0.20, 0.012)
HINGE = (0.066, 0.0, RIM + 0.002 + SEAT[2] / 2.0)
CERAMIC, SHADE, SEAT_COLOR, CHROME, BLUE = (
    glass((0.95, 0.96, 0.97)),
    (0.80, 0.83, 0.86),
    plastic((0.10, 0.33, 0.60)),
    metal((0.62, 0.64, 0.67)),
    glass((0.66, 0.84, 0.91)),
)

Level = tuple[float, float, float, float]
"""Of an outline: its front, its back, half its width, its height [m]."""
OUTER: tuple[Level, ...] = (
    (-0.085, 0.125, 0.062, 0.0),
    (-0.084, 0.120, 0.060, 0.06),
    (-0.118, 0.110, 0.086, 0.10),
    (-0.130, 0.100, 0.096, 0.135),
    (-0.131, 0.098, 0.097, RIM),
)
INNER: tuple[Level, ...] = ((-0.108, 0.024, 0.074, RIM), (-0.103, 0.018, 0.068, 0.13), (-0.07, 0.0, 0.045, WATER))
SEAT_OUTER, SEAT_HOLE = (-SEAT[0], 0.0, SEAT[1] / 2.0), (-0.176, -0.052, 0.061)


def outline(front: float, back: float, half: float, count: int = 24) -> FloatArray:
    """Return the corners (n, 2) of an outline that is round in front and nearly square behind, counter-clockwise."""
    angles = 2.0 * np.pi * np.arange(count) / count
    c, s = np.cos(angles), np.sin(angles)
    middle = front + min(half * 1.15, 0.6 * (back - front))
    power = np.where(c > 0.0, 0.45, 1.0)
    reach = np.where(c > 0.0, back - middle, middle - front)
    return np.column_stack([middle + reach * np.sign(c) * np.abs(c) ** power, half * np.sign(s) * np.abs(s) ** power])


def _loft(levels: Sequence[Level], ends: bool = True, count: int = 24) -> Mesh:
    """Return a skin over outlines; `ends` closes the first and the last, otherwise the last is to be the first again."""
    rings = [np.column_stack([outline(*level[:3], count), np.full(count, level[3])]) for level in levels]
    vertices, faces = np.concatenate(rings), []
    for low, high in pairwise(range(0, len(vertices), count)):
        for i in range(count):
            j = (i + 1) % count
            faces += [(low + i, low + j, high + j), (low + i, high + j, high + i)]
    if ends:
        middles = np.array([rings[0].mean(axis=0), rings[-1].mean(axis=0)])
        first, last, top = len(vertices), len(vertices) + 1, len(vertices) - count
        faces += [(first, (i + 1) % count, i) for i in range(count)]
        faces += [(last, top + i, top + (i + 1) % count) for i in range(count)]
        vertices = np.concatenate([vertices, middles])
    return Mesh(vertices, np.array(faces))


def _around(name: str, outer: Sequence[Level], inner: Sequence[Level], count: int = 12) -> tuple[Shape, ...]:
    """Return convex pieces between outer and inner outlines of two levels each."""
    rings = [np.column_stack([outline(*level[:3], count), np.full(count, level[3])]) for level in (*outer, *inner)]
    pieces = (np.concatenate([ring[[i, (i + 1) % count]] for ring in rings]) for i in range(count))
    return tuple(mesh_shape(f"{name}{i}", hull_of(points)) for i, points in enumerate(pieces))


def _cistern() -> tuple[Mesh, Mesh]:
    """Return the cistern with its cover, and the two halves of the flush button."""
    x, lid = BACK - CISTERN[0] / 2.0, 0.016
    bottom = HEIGHT - CISTERN[2]
    body = box((CISTERN[0] - 0.006, CISTERN[1] - 0.008, CISTERN[2] - lid), (x + 0.001, 0.0, bottom + (CISTERN[2] - lid) / 2.0))
    cover = bevelled_box((CISTERN[0], CISTERN[1], lid), 0.004).moved((x, 0.0, HEIGHT - lid))
    button = cylinder(0.017, 0.006, 14).moved((x, 0.0, HEIGHT))
    return merge([body, cover]), button


def _pan() -> Link:
    cistern, button = _cistern()
    brackets = merge(box((0.016, 0.016, 0.012), (HINGE[0] + 0.002, y, RIM + 0.006)) for y in (-0.055, 0.055))
    water = mark(outline(*INNER[-1][:3], 44), WATER + 0.001, "z")
    visuals = (
        Visual(mesh_shape("bowl", _loft((*OUTER, *INNER), count=28)), CERAMIC),
        Visual(mesh_shape("cistern", cistern), CERAMIC),
        Visual(mesh_shape("plinth", _loft([(-0.088, 0.128, 0.065, 0.0), (-0.088, 0.128, 0.065, 0.008)], count=16)), SHADE),
        Visual(mesh_shape("water", water), BLUE),
        Visual(mesh_shape("button", button), CHROME),
        Visual(mesh_shape("brackets", brackets), CHROME),
    )
    foot = np.concatenate(
        [np.column_stack([outline(*lv[:3], 12), np.full(12, lv[3])]) for lv in (*OUTER[:2], (*OUTER[1][:3], WATER))]
    )
    walls = _around("wall", ((-0.105, 0.113, 0.077, WATER), OUTER[-1]), (INNER[-1], INNER[0]))
    tank = box_shape(CISTERN, (BACK - CISTERN[0] / 2.0, 0.0, HEIGHT - CISTERN[2] / 2.0))
    return Link("pan", 6.0, visuals, (mesh_shape("foot", hull_of(foot)), *walls, tank))


def _seat() -> Link:
    half, soft = SEAT[2] / 2.0, 0.003

    def inset(edges: tuple[float, float, float], by: float, z: float) -> Level:
        return (edges[0] + by, edges[1] - by, edges[2] - by, z)

    outer = [inset(SEAT_OUTER, by, z) for by, z in ((0.0, -half), (0.0, half - soft), (soft, half))]
    hole = [inset(SEAT_HOLE, by, z) for by, z in ((-soft, half), (0.0, half - soft), (0.0, -half))]
    pins = merge(rod((0.0, y - 0.014, 0.0), (0.0, y + 0.014, 0.0), half, 8) for y in (-0.055, 0.055))
    visuals = (
        Visual(mesh_shape("seat", _loft([*outer, *hole, outer[0]], ends=False, count=28)), SEAT_COLOR),
        Visual(mesh_shape("pins", pins), CHROME),
    )
    pieces = _around("seat_piece", [(*SEAT_OUTER, z) for z in (-half, half)], [(*SEAT_HOLE, z) for z in (-half, half)], 12)
    return Link("seat", 0.25, visuals, pieces, friction=1.0)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    hinge = Joint("seat_hinge", "revolute", "pan", "seat", HINGE, (0.0, 1.0, 0.0), 0.0, 1.85, damping=0.01)
    notes = (
        f"front faces -x, cistern at +x; bowl hollow, rim at z = {RIM}, water at {WATER}",
        f"link `seat` is a ring of thickness {SEAT[2]} with its origin on the hinge {tuple(round(v, 4) for v in HINGE)}; at 0 it "
        f"lies on the bowl and spans x -{SEAT[0]}..0, y -+{SEAT[1] / 2.0} there, its hole x {SEAT_HOLE[0]}..{SEAT_HOLE[1]}; "
        "it opens upwards and backwards",
        f"the front edge stands {-SEAT_OUTER[0] - HINGE[0] + OUTER[-1][0]:.3f} beyond the bowl, which a finger gets under",
    )
    return (Model("toilet", "objects/toilet", "bottom centre", (_pan(), _seat()), (hinge,), notes),)
