"""A barbecue with a domed hood on a hinge; the open grill of `grill.py` is another one."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, box, cylinder, hull_of, merge, rod
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape, metal, patterned, plastic

DEPTH, WIDTH, HEIGHT, WALL = 0.28, 0.40, 0.18, 0.008
TUB = 0.07
"""Height of the tub's underside [m]."""
GRATE = 0.165
"""Height of the upper side of the grate [m]."""
HINGE = (DEPTH / 2.0, 0.0, HEIGHT + 0.002)
OUTLINE = ((-0.28, 0.0), (-0.272, 0.05), (-0.22, 0.095), (-0.14, 0.112), (-0.06, 0.095), (-0.008, 0.05), (0.0, 0.0))
"""x, z of the outside of the hood, from the front over the top to the hinge, in its own frame [m]."""
HANDLE = (-0.334, 0.0, 0.042)
"""Middle of the handle bar in the hood's frame [m]."""
BAR_RADIUS, BAR_LENGTH = 0.0075, 0.14
HALF_PI = 1.57079633
RED, IRON, STEEL, WOOD = (
    plastic((0.66, 0.10, 0.09)),
    (0.15, 0.15, 0.16),
    patterned(metal((0.70, 0.71, 0.73)), "brushed"),
    patterned((0.36, 0.21, 0.12), "wood"),
)

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _tub() -> tuple[Box, ...]:
    """Return the boxes (size, centre) of the tub: floor and four walls, open above."""
    z, tall = (TUB + HEIGHT) / 2.0, HEIGHT - TUB
    x, y = (DEPTH - WALL) / 2.0, (WIDTH - WALL) / 2.0
    return (
        ((DEPTH, WIDTH, WALL), (0.0, 0.0, TUB + WALL / 2.0)),
        ((WALL, WIDTH, tall), (x, 0.0, z)),
        ((WALL, WIDTH, tall), (-x, 0.0, z)),
        ((DEPTH - 2 * WALL, WALL, tall), (0.0, y, z)),
        ((DEPTH - 2 * WALL, WALL, tall), (0.0, -y, z)),
    )


def _legs() -> tuple[Box, ...]:
    return tuple(((0.022, 0.022, TUB), (x, y, TUB / 2.0)) for x in (-0.11, 0.11) for y in (-0.17, 0.17))


def _boards() -> tuple[Box, ...]:
    """Return the wooden boards beside the tub."""
    return tuple(((0.22, 0.07, 0.012), (0.0, side * (WIDTH / 2.0 + 0.035), 0.165)) for side in (-1, 1))


def _grate() -> Mesh:
    """Return the bars of the grate."""
    x, y = DEPTH / 2.0 - WALL, WIDTH / 2.0 - WALL
    bars = [box((2 * x - 0.012, 0.005, 0.005), (0.0, place, GRATE - 0.0025)) for place in np.linspace(-y + 0.012, y - 0.012, 15)]
    return merge([*bars, *(box((0.005, 2 * y - 0.012, 0.005), (side * 0.09, 0.0, GRATE - 0.006)) for side in (-1, 1))])


def _lip() -> tuple[Box, ...]:
    """Return a thin edge on the walls of the tub that closes the slit below the shut hood; it stands within the hood."""
    x, y, wall, low, high = DEPTH / 2.0 - 0.012, WIDTH / 2.0 - 0.0105, 0.003, HEIGHT - 0.02, HEIGHT + 0.007
    tall, z = high - low, (low + high) / 2.0
    return (
        *(((wall, 2.0 * y, tall), (side * x, 0.0, z)) for side in (-1, 1)),
        *(((2.0 * x, wall, tall), (0.0, side * y, z)) for side in (-1, 1)),
    )


def _coals() -> Mesh:
    """Return lumps of charcoal below the grate."""
    rng = np.random.default_rng(11)
    lumps = []
    for x in (-0.085, -0.03, 0.03, 0.085):
        for y in np.linspace(-0.15, 0.15, 5):
            place = (x + 0.008 * rng.standard_normal(), y + 0.008 * rng.standard_normal(), TUB + 0.028)
            lumps.append(box(tuple(0.036 + 0.012 * rng.random(3))).moved(place, tuple(0.5 * rng.standard_normal(3))))
    return merge(lumps)


def _inner() -> FloatArray:
    """Return the outline (n, 2) of the inside of the hood."""
    middle = np.array([-0.14, 0.0])
    points = middle + (np.array(OUTLINE) - middle) * (1.0 - WALL / 0.12)
    return np.round(points, 6)


def _plates() -> tuple[Mesh, ...]:
    """Return the convex plates of the hood: front, top and back, and both ends."""
    outer, inner, half = np.array(OUTLINE), _inner(), WIDTH / 2.0
    plates = []
    for i, j in pairwise(range(len(outer))):
        corners = [(x, y, z) for x, z in (outer[i], outer[j], inner[i], inner[j]) for y in (-half, half)]
        plates.append(hull_of(np.array(corners)))
    ends = [[(x, side * y, z) for x, z in OUTLINE for y in (half, half - WALL)] for side in (-1, 1)]
    return (*plates, *(hull_of(np.array(corners)) for corners in ends))


def _lining() -> Mesh:
    """Return the sooty inside of the hood."""
    inner, half = _inner(), WIDTH / 2.0 - WALL
    middle = np.array([-0.14, 0.0])
    deeper = middle + (inner - middle) * 0.985
    parts = []
    for i, j in pairwise(range(len(inner))):
        corners = [(x, y, z) for x, z in (inner[i], inner[j], deeper[i], deeper[j]) for y in (-half, half)]
        parts.append(hull_of(np.round(np.array(corners), 6)))
    return merge(parts)


def _handle() -> tuple[Mesh, Mesh, tuple[Shape, ...]]:
    """Return the bar, its posts, and their shapes."""
    x, _, z = HANDLE
    end, half = -0.274, BAR_LENGTH / 2.0
    bar = rod((x, -half, z), (x, half, z), BAR_RADIUS, 12)
    size = (end - x + 0.004, 0.012, 0.012)
    places = [(x + size[0] / 2.0, side * (half - 0.008), z) for side in (-1, 1)]
    shapes = (cylinder_shape(BAR_RADIUS, BAR_LENGTH, HANDLE, (HALF_PI, 0.0, 0.0)), *(box_shape(size, place) for place in places))
    return bar, merge(box(size, place) for place in places), shapes


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _body_link() -> Link:
    x, y = DEPTH / 2.0 - WALL, WIDTH / 2.0 - WALL
    knobs = [cylinder(0.015, 0.016, 10).moved((-DEPTH / 2.0 - 0.008, p, 0.12), (0.0, HALF_PI, 0.0)) for p in (-0.08, 0.0, 0.08)]
    visuals = (
        Visual(mesh_shape("tub", _merged((*_tub(), *_lip()))), IRON),
        Visual(mesh_shape("legs", _merged(_legs())), IRON),
        Visual(mesh_shape("boards", _merged(_boards())), WOOD),
        Visual(mesh_shape("grate", _grate()), STEEL),
        Visual(mesh_shape("coals", _coals()), (0.85, 0.33, 0.10)),
        Visual(mesh_shape("knobs", merge(knobs)), STEEL),
    )
    slab: Box = ((2 * x, 2 * y, 0.008), (0.0, 0.0, GRATE - 0.004))
    fronts: Box = ((0.016, 0.19, 0.03), (-DEPTH / 2.0 - 0.008, 0.0, 0.12))
    solid = (*_tub(), *_legs(), *_boards(), slab, fronts)
    return Link("hooded_grill", 6.0, visuals, tuple(box_shape(size, center) for size, center in solid))


def _hood_link() -> Link:
    """Return the hood; its origin is on the hinge."""
    plates = _plates()
    bar, posts, shapes = _handle()
    gauge = cylinder(0.024, 0.008, 24).moved((-0.25, 0.0, 0.077), (0.0, -0.86, 0.0))
    scale = [box((0.005, 0.002, 0.0006), (0.019, 0.0, 0.0043)).moved(rpy=(0.0, 0.0, k * np.pi / 4.0)) for k in range(-3, 4)]
    needle = box((0.022, 0.0026, 0.0006), (0.006, 0.0, 0.0043)).moved(rpy=(0.0, 0.0, -1.2))
    dial = merge([*scale, needle]).moved((-0.25, 0.0, 0.077), (0.0, -0.86, 0.0))
    vent = cylinder(0.02, 0.012, 12).moved((-0.14, 0.11, 0.114))
    visuals = (
        Visual(mesh_shape("hood", merge(plates)), RED),
        Visual(mesh_shape("soot", _lining()), (0.11, 0.10, 0.10)),
        Visual(mesh_shape("bar", bar), WOOD),
        Visual(mesh_shape("posts", posts), STEEL),
        Visual(mesh_shape("gauge", gauge), (0.95, 0.95, 0.92)),
        Visual(mesh_shape("dial", dial), IRON),
        Visual(mesh_shape("vent", vent), STEEL),
    )
    hulls = tuple(mesh_shape(f"plate{i}", plate) for i, plate in enumerate(plates))
    return Link("hood", 0.7, visuals, (*hulls, *shapes), friction=1.0)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    lid = Joint("lid", "revolute", "hooded_grill", "hood", HINGE, (0.0, 1.0, 0.0), 0.0, 1.4, damping=0.05)
    notes = (
        f"front faces -x, {WIDTH} wide along y, boards beside it to y = -+{WIDTH / 2.0 + 0.07:.2f}; rim at z = {HEIGHT}; "
        f"grate, one slab for collisions, upper side at z = {GRATE}",
        f"link `hood` has its origin on the hinge at the middle of the rear edge {HINGE}; closed, it spans x -0.28..0 and "
        "z 0..0.112 there; it is hollow and opens upwards and backwards",
        f"handle bar along y, diameter {2 * BAR_RADIUS}, length {BAR_LENGTH}, middle {HANDLE} in `hood`; "
        f"{-HANDLE[0] - 0.274 - BAR_RADIUS:.3f} m free behind it",
    )
    links = (_body_link(), _hood_link())
    return (Model("hooded_grill", "objects/hooded_grill", "bottom centre", links, (lid,), notes),)
