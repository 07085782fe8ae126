"""An open grill, a chicken drumstick and a steak."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, hull_of, icosphere, lathe, merge, rod
from assets_lib.urdf import Link, Model, Visual, box_shape, mesh_shape, metal, patterned

LENGTH, WIDTH, HEIGHT = 0.36, 0.26, 0.14
TUB = 0.06
"""Height of the tub's underside [m]."""
IRON, STEEL = (0.13, 0.13, 0.14), patterned(metal((0.55, 0.56, 0.58)), "brushed")
HALF_PI = 1.5707963267948966

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _tub() -> tuple[Box, ...]:
    """Return the boxes (size, centre) of the tub: floor and four walls, open above."""
    wall, top = 0.008, HEIGHT - 0.005
    z, tall = (TUB + top) / 2.0, top - TUB
    return (
        ((LENGTH, WIDTH, wall), (0.0, 0.0, TUB + wall / 2.0)),
        ((wall, WIDTH, tall), ((LENGTH - wall) / 2.0, 0.0, z)),
        ((wall, WIDTH, tall), (-(LENGTH - wall) / 2.0, 0.0, z)),
        ((LENGTH - 2 * wall, wall, tall), (0.0, (WIDTH - wall) / 2.0, z)),
        ((LENGTH - 2 * wall, wall, tall), (0.0, -(WIDTH - wall) / 2.0, z)),
    )


def _liner() -> Mesh:
    """Return the sooty lining of the tub, open above: its floor and the faces of its walls."""
    x, y, low, high = LENGTH / 2.0 - 0.0085, WIDTH / 2.0 - 0.0085, TUB + 0.009, HEIGHT - 0.005
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    vertices = np.array([(a, b, z) for z in (low, high) for a, b in corners])
    faces = [(0, 1, 2), (0, 2, 3)]
    for i in range(4):
        j = (i + 1) % 4
        faces += [(j, i, 4 + i), (j, 4 + i, 4 + j)]
    return Mesh(vertices, np.array(faces))


def _legs() -> tuple[Box, ...]:
    return tuple(((0.022, 0.022, TUB), (x, y, TUB / 2.0)) for x in (-0.15, 0.15) for y in (-0.10, 0.10))


def _grate() -> Mesh:
    """Return the bars; their upper side is at the grill's full height."""
    radius = 0.0028
    z = HEIGHT - radius
    long = WIDTH / 2.0 - 0.004
    bars = [rod((x, -long, z), (x, long, z), radius, 6) for x in np.linspace(-0.164, 0.164, 17)]
    cross = [rod((-0.172, y, z - 0.003), (0.172, y, z - 0.003), radius, 6) for y in (-0.08, 0.08)]
    return merge([*bars, *cross])


def _coals() -> Mesh:
    """Return lumps of charcoal below the grate."""
    rng = np.random.default_rng(7)
    lumps = []
    for x in np.linspace(-0.135, 0.135, 6):
        for y in (-0.075, -0.025, 0.025, 0.075):
            size = 0.018 + 0.006 * rng.random(3)
            place = (x + 0.008 * rng.standard_normal(), y + 0.006 * rng.standard_normal(), TUB + 0.016)
            lumps.append(box(tuple(2.0 * size)).moved(place, tuple(0.5 * rng.standard_normal(3))))
    return merge(lumps)


def _side_handles() -> Mesh:
    """Return one bar on each short side."""
    parts = []
    for side in (-1.0, 1.0):
        x = side * (LENGTH / 2.0 + 0.02)
        parts.append(rod((x, -0.05, 0.105), (x, 0.05, 0.105), 0.006, 8))
        parts += [rod((side * LENGTH / 2.0, y, 0.105), (x, y, 0.105), 0.005, 6) for y in (-0.04, 0.04)]
    return merge(parts)


def _grill() -> Model:
    merged = merge(box(size, center) for size, center in _tub())
    visuals = (
        Visual(mesh_shape("tub", merged), (0.62, 0.10, 0.08)),
        Visual(mesh_shape("legs", merge(box(s, c) for s, c in _legs())), IRON),
        Visual(mesh_shape("grate", _grate()), STEEL),
        Visual(mesh_shape("coals", _coals()), (0.20, 0.17, 0.16)),
        Visual(mesh_shape("liner", _liner()), (0.09, 0.09, 0.10)),
        Visual(mesh_shape("side_handles", _side_handles()), IRON),
    )
    slab = box_shape((LENGTH - 0.016, WIDTH - 0.016, 0.008), (0.0, 0.0, HEIGHT - 0.004))
    boxes = tuple(box_shape(s, c) for s, c in (*_tub(), *_legs()))
    sides = tuple(box_shape((0.026, 0.10, 0.012), (s * (LENGTH / 2.0 + 0.013), 0.0, 0.105)) for s in (-1.0, 1.0))
    notes = (
        f"long side along x; the grate, upper side at z = {HEIGHT}, spans x -0.172..0.172 and y -0.122..0.122",
        f"rim at z = {HEIGHT - 0.005:.3f}",
        "grasp between the bars is not modelled: the grate is one slab for collisions",
        "side handles stick out to x = +-0.206",
    )
    return Model("grill", "objects/grill", "bottom centre", (Link("grill", 3.0, visuals, (*boxes, slab, *sides)),), notes=notes)


def _drumstick_parts() -> tuple[Mesh, Mesh, Mesh]:
    """Return the meat, the bone and the knuckle; the thick end is at -x and the underside is flat."""
    profile = [(0.0, -0.050), (0.012, -0.0485), (0.0195, -0.042), (0.0225, -0.031), (0.0215, -0.018)]
    profile += [(0.016, -0.003), (0.0105, 0.010), (0.008, 0.019), (0.0, 0.0205)]
    meat = lathe(profile, 16).moved(rpy=(0.0, HALF_PI, 0.0)).scaled((1.0, 1.0, 1.03)).moved((0.0, 0.0, -0.0032))
    vertices = meat.vertices.copy()
    vertices[:, 2] = np.maximum(vertices[:, 2], -0.02)
    bone = rod((0.012, 0.0, -0.004), (0.042, 0.0, -0.006), 0.0052, 10)
    knuckle = merge([icosphere(0.0072, 1).moved((0.0428, y, -0.006)) for y in (-0.0045, 0.0045)])
    return Mesh(vertices, meat.faces), bone, knuckle


def _chicken() -> Model:
    meat, bone, knuckle = _drumstick_parts()
    visuals = (
        Visual(mesh_shape("meat", meat), (0.80, 0.47, 0.16), crease=1.2),
        Visual(mesh_shape("bone", merge([bone, knuckle])), (0.95, 0.91, 0.80), crease=1.2),
    )
    hull = hull_of(np.round(meat.vertices, 5))
    rear = hull_of(np.round(merge([bone, knuckle]).vertices, 5))
    shapes = (mesh_shape("meat_hull", hull), mesh_shape("bone_hull", rear))
    notes = (
        "drumstick along x, bone at +x; rests with its origin at 0.02 m",
        "0.045 wide (y) at x = -0.031; grasp across y at x = -0.02..0.0",
    )
    link = Link("chicken", 0.12, visuals, shapes, friction=1.0, rolling=0.0005, center=(-0.021, 0.0, -0.003))
    return Model("chicken", "objects/chicken", "centre", (link,), notes=notes)


def _outline(scale: float) -> np.ndarray:
    """Return the steak's outline (n, 2), a rounded kidney within 0.11 x 0.06 at scale 1."""
    t = 2.0 * np.pi * np.arange(20) / 20
    radius = 1.0 + 0.10 * np.cos(2.0 * t + 0.6) + 0.06 * np.cos(3.0 * t + 1.0)
    points = np.column_stack([radius * np.cos(t), radius * np.sin(t)])
    low, high = points.min(axis=0), points.max(axis=0)
    return (points - (low + high) / 2.0) / (high - low) * np.array([0.11, 0.06]) * scale


def prism(outline: np.ndarray, low: float, high: float) -> Mesh:
    """Return an upright prism over a star-shaped outline (n, 2), with fans as lids."""
    n = len(outline)
    rings = [np.column_stack([outline, np.full(n, z)]) for z in (low, high)]
    vertices = np.vstack([*rings, [[0.0, 0.0, low], [0.0, 0.0, high]]])
    faces = []
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, j, n + j), (i, n + j, n + i), (j, i, 2 * n), (n + i, n + j, 2 * n + 1)]
    return Mesh(vertices, np.array(faces))


def _steak() -> Model:
    fat = prism(_outline(1.0), -0.0095, 0.0075)
    meat = prism(_outline(0.95), -0.010, 0.010)
    bars = [box((0.004, w, 0.0012), (x, 0.0, 0.0101)) for x, w in ((-0.03, 0.032), (-0.01, 0.038), (0.01, 0.038), (0.03, 0.032))]
    visuals = (
        Visual(mesh_shape("fat", fat), (0.82, 0.62, 0.48)),
        Visual(mesh_shape("meat", meat), (0.52, 0.20, 0.14)),
        Visual(mesh_shape("sear_marks", merge(bars)), (0.18, 0.07, 0.05)),
    )
    hull = hull_of(np.round(prism(_outline(1.0), -0.010, 0.010).vertices, 5))
    link = Link("steak", 0.2, visuals, (mesh_shape("steak_hull", hull),), friction=1.0)
    notes = ("long side along x; rests with its origin at 0.01 m; grasp across y (0.06 wide)",)
    return Model("steak", "objects/steak", "centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_grill(), _chicken(), _steak())
