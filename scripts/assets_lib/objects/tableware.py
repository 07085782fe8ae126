"""A plate, a fork, a knife, a spoon and a glass, where they are kept, and the mat on which a place is laid."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from assets_lib.cabinets import bevelled
from assets_lib.mesh import Mesh, cylinder, hull_of, lathe, merge
from assets_lib.urdf import (
    Link,
    Model,
    Paint,
    Shape,
    Vec3,
    Visual,
    box_shape,
    cylinder_shape,
    glass,
    mesh_shape,
    metal,
    pane,
    patterned,
    plastic,
)

PLATE, RIM, WALL, FLOOR = 0.085, 0.022, 0.005, 0.005
"""Radius and height of the plate, thickness of its wall and of its floor [m]."""
SIDES = 20
LENGTH, THICK = 0.16, 0.008
"""Of the cutlery, which lies along x, its tip at +x [m]."""
HANDLE, HEAD = 0.012, 0.018
"""Widths of the handle and of the other end [m]."""
GLASS, TALL = 0.03, 0.10
"""Radius at the rim and height of the glass [m]."""
REST = (0.13, 0.20, 0.02)
"""Length, width and height of the rest for the cutlery [m]."""
STAND, STAND_HEIGHT = 0.05, 0.02
"""Radius and height of the stand for the plate [m]."""
COASTER, COASTER_HEIGHT = 0.045, 0.006
MAT = (0.30, 0.42)
"""Depth and width of the mat [m]."""
CHINA, BLUE, STEEL = glass((0.93, 0.93, 0.90)), glass((0.22, 0.34, 0.52)), metal((0.74, 0.75, 0.77))
CLEAR, WOOD, CORK, LINEN = (
    pane((0.62, 0.80, 0.86), 0.55),
    patterned(plastic((0.60, 0.43, 0.28)), "wood"),
    (0.72, 0.55, 0.36),
    (0.30, 0.37, 0.42),
)
Section = tuple[float, float, float, float]
"""Of a rod along x: x, half width, lower and upper z [m]."""


def _rod(sections: Sequence[Section], y: Sequence[float] | None = None) -> Mesh:
    """Return a closed rod along x through cross sections with bevelled edges."""
    rings = []
    for (x, half, low, high), middle in zip(sections, y or [0.0] * len(sections), strict=True):
        cut = 0.3 * min(half, high - low)
        ring = [(half - cut, low), (half, low + cut), (half, high - cut), (half - cut, high)]
        ring += [(-a, b) for a, b in reversed(ring)]
        rings.append([(x, middle + a, b) for a, b in ring])
    vertices, faces, count = np.array(rings).reshape(-1, 3), [], 8
    for k in range(len(rings) - 1):
        for i in range(count):
            j = (i + 1) % count
            a, b, c, d = k * count + i, k * count + j, (k + 1) * count + j, (k + 1) * count + i
            faces += [(a, b, c), (a, c, d)]
    last = (len(rings) - 1) * count
    faces += [(0, i + 1, i) for i in range(1, count - 1)] + [(last, last + i, last + i + 1) for i in range(1, count - 1)]
    return Mesh(vertices, np.array(faces))


BOTTOM, TOP = -THICK / 2.0, THICK / 2.0


def _handle(neck: float) -> list[Section]:
    """Return the sections of a handle from its round end to the neck at x = 0.015."""
    return [
        (-0.08, 0.002, BOTTOM + 0.0015, TOP - 0.003),
        (-0.078, 0.0048, BOTTOM + 0.0005, TOP - 0.0015),
        (-0.07, HANDLE / 2.0, BOTTOM, TOP - 0.001),
        (-0.045, 0.0058, BOTTOM, TOP),
        (-0.01, 0.0042, BOTTOM, TOP),
        (0.015, neck, BOTTOM, TOP - 0.001),
    ]


def _fork() -> Mesh:
    root = [(0.03, 0.0045, BOTTOM + 0.0005, TOP - 0.0025), (0.038, HEAD / 2.0, BOTTOM + 0.0005, TOP - 0.004)]
    body = _rod([*_handle(0.003), *root, (0.05, HEAD / 2.0, BOTTOM, TOP - 0.005)])
    tines = []
    for k in range(4):
        y = (k - 1.5) * 0.0052
        sections = [
            (0.049, 0.0016, BOTTOM, TOP - 0.005),
            (0.066, 0.0014, BOTTOM, TOP - 0.005),
            (0.08, 0.0007, BOTTOM + 0.001, TOP - 0.005),
        ]
        tines.append(_rod(sections, [y, y, y]))
    return merge([body, *tines])


def _knife() -> Mesh:
    handle = _rod([*_handle(0.0055)[:4], (-0.01, 0.0058, BOTTOM, TOP), (0.004, 0.0052, BOTTOM, TOP)])
    outline = [(0.0, -0.006), (0.0, 0.005), (0.06, 0.009), (0.072, 0.0075), (0.079, 0.002), (0.08, -0.004), (0.078, -0.006)]
    flat = [(x, y, z) for x, y in outline for z in (BOTTOM, BOTTOM + 0.0012)] + [
        (x, -0.006, BOTTOM + 0.0028) for x in (0.0, 0.07)
    ]
    return merge([handle, hull_of(np.array(flat))])


def _spoon() -> Mesh:
    neck = _rod([*_handle(0.003), (0.04, 0.003, BOTTOM + 0.002, TOP - 0.001)])
    lip = TOP - 0.001
    outer = [(0.0, BOTTOM), (0.5, BOTTOM + 0.0006), (0.85, BOTTOM + 0.003), (1.0, lip)]
    inner = [(0.93, lip), (0.78, BOTTOM + 0.0038), (0.45, BOTTOM + 0.0018), (0.0, BOTTOM + 0.0013)]
    bowl = lathe([*outer, *inner], 24).scaled((0.0235, 0.0125, 1.0)).moved((0.0565, 0.0, 0.0))
    return merge([neck, bowl])


def _cutlery(name: str, mesh: Mesh, what: str) -> Model:
    shapes = (
        box_shape((0.10, HANDLE, THICK), (-0.03, 0.0, 0.0)),
        box_shape((0.06, HEAD, THICK), (0.05, 0.0, 0.0)),
    )
    notes = (
        f"lies along x, its {what} at +x: {LENGTH} long, {HEAD} wide and {THICK} high; grasp its handle across y at x = -0.015",
    )
    link = Link(name, 0.05, (Visual(mesh_shape("steel", mesh), STEEL, crease=0.6),), shapes, friction=0.8)
    return Model(name, f"objects/{name}", "centre", (link,), notes=notes)


def _plate() -> Model:
    outline = [
        (0.0, 0.0),
        (PLATE - 0.012, 0.0),
        (PLATE - 0.003, 0.003),
        (PLATE, 0.010),
        (PLATE, RIM - 0.001),
        (PLATE - 0.001, RIM),
    ]
    inside = [
        (PLATE - WALL + 0.001, RIM),
        (PLATE - WALL, RIM - 0.001),
        (PLATE - WALL, 0.011),
        (PLATE - WALL - 0.004, FLOOR + 0.001),
    ]
    china = lathe([*outline, *inside, (PLATE - WALL - 0.010, FLOOR), (0.0, FLOOR)], 28)
    lines = [
        lathe([(r, FLOOR), (r, FLOOR + 0.0004), (r - w, FLOOR + 0.0004), (r - w, FLOOR)], 28)
        for r, w in ((0.066, 0.003), (0.060, 0.001))
    ]
    edge = lathe(
        [
            (PLATE - WALL + 0.0007, RIM),
            (PLATE - 0.0007, RIM),
            (PLATE - 0.0007, RIM + 0.0005),
            (PLATE - WALL + 0.0007, RIM + 0.0005),
        ],
        28,
    )
    visuals = (Visual(mesh_shape("china", china), CHINA), Visual(mesh_shape("lines", merge([*lines, edge])), BLUE))
    middle, width = PLATE - WALL / 2.0, 2.0 * PLATE * float(np.tan(np.pi / SIDES))
    walls = _ring(middle, (WALL, width, RIM), SIDES)
    notes = (f"floor at z = {FLOOR}, an upright rim {WALL} thick and {RIM} high at radius {PLATE}; grasp it across the rim",)
    link = Link("plate", 0.15, visuals, (*_crossed(PLATE - WALL, FLOOR), *walls), friction=0.8)
    return Model("rimmed_plate", "objects/rimmed_plate", "bottom centre", (link,), notes=notes)


def _crossed(radius: float, height: float) -> tuple[Shape, ...]:
    """Return three crossed boxes for a flat disc: on a cylinder, another would not come to rest."""
    size = (1.7 * radius, radius, height)
    return tuple(box_shape(size, (0.0, 0.0, height / 2.0), (0.0, 0.0, k * np.pi / 3.0)) for k in range(3))


def _ring(radius: float, size: Vec3, sides: int) -> tuple[Shape, ...]:
    """Return boxes in a ring around z; one has its middle on the y axis."""
    shapes = []
    for k in range(sides):
        angle = np.pi / 2.0 + 2.0 * np.pi * k / sides
        place = (radius * float(np.cos(angle)), radius * float(np.sin(angle)), size[2] / 2.0)
        shapes.append(box_shape(size, place, (0.0, 0.0, float(angle))))
    return tuple(shapes)


def _tumbler() -> Model:
    outside = [(0.0, 0.0), (GLASS - 0.005, 0.0), (GLASS - 0.002, 0.002), (GLASS, TALL - 0.001), (GLASS - 0.0008, TALL)]
    inside = [(GLASS - 0.0022, TALL), (GLASS - 0.003, TALL - 0.001), (GLASS - 0.0045, 0.012), (0.0, 0.010)]
    facets = merge(
        Mesh(np.array([(r, -w, low), (r, w, low), (r, w, high), (r, -w, high)]), np.array([(0, 1, 2), (0, 2, 3)])).moved(
            rpy=(0.0, 0.0, turn)
        )
        for turn in 2.0 * np.pi * np.arange(10) / 10
        for r, w, low, high in ((GLASS - 0.0008, 0.004, 0.010, 0.045),)
    )
    visuals = (
        Visual(mesh_shape("glass", lathe([*outside, *inside], 32)), CLEAR),
        Visual(mesh_shape("facets", facets), pane((0.60, 0.74, 0.78), 0.5)),
        Visual(
            mesh_shape("rim", _band(GLASS - 0.0028, GLASS + 0.0002, TALL - 0.0015, TALL + 0.0003)), pane((0.85, 0.93, 0.95), 0.8)
        ),
    )
    link = Link("glass", 0.15, visuals, (cylinder_shape(GLASS, TALL, (0.0, 0.0, TALL / 2.0)),), friction=0.8)
    notes = (f"diameter {2 * GLASS}, {TALL} high; solid for contact",)
    return Model("drinking_glass", "objects/drinking_glass", "bottom centre", (link,), notes=notes)


def _band(inner: float, outer: float, low: float, high: float) -> Mesh:
    return lathe([(inner, low), (outer, low), (outer, high), (inner, high), (inner, low)], 32)


def _rest() -> Model:
    x, y, z = REST
    parts = [((x, y, 0.006), (0.0, 0.0, 0.003)), *(((0.016, y, z), (s * (x - 0.016) / 2.0, 0.0, z / 2.0)) for s in (-1.0, 1.0))]
    visuals = (Visual(mesh_shape("wood", bevelled(parts)), WOOD),)
    link = Link("rest", 0.8, visuals, tuple(box_shape(size, center) for size, center in parts))
    notes = (f"two bars along y, {x - 0.016:.3f} apart, {z} high; what lies along x on both can be gripped between them",)
    return Model("cutlery_rest", "objects/cutlery_rest", "bottom centre", (link,), notes=notes)


def _disc(name: str, radius: float, height: float, paint: Vec3 | Paint, words: str) -> Model:
    disc = cylinder(radius, height, 32, bevel=0.002).moved((0.0, 0.0, height / 2.0))
    link = Link(name, 0.3, (Visual(mesh_shape("disc", disc), paint),), _crossed(radius, height))
    return Model(name, f"objects/{name}", "bottom centre", (link,), notes=(words,))


def _mat() -> Model:
    x, y = MAT
    seam = [((x - 0.02, 0.003, 0.0008), (0.0, s * (y / 2.0 - 0.014), 0.0004)) for s in (-1.0, 1.0)]
    seam += [((0.003, y - 0.02, 0.0008), (s * (x / 2.0 - 0.014), 0.0, 0.0004)) for s in (-1.0, 1.0)]
    visuals = (
        Visual(mesh_shape("linen", bevelled([((x, y, 0.0006), (0.0, 0.0, 0.0003))], 0.0002)), LINEN),
        Visual(mesh_shape("seam", bevelled(seam, 0.0001)), (0.62, 0.67, 0.70)),
    )
    link = Link("mat", 0.1, visuals, ())
    notes = (f"only seen: {x} deep along x, {y} wide along y, 0.0008 thick",)
    return Model("placemat", "objects/placemat", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (
        _plate(),
        _cutlery("fork", _fork(), "tines"),
        _cutlery("table_knife", _knife(), "blade"),
        _cutlery("spoon", _spoon(), "bowl"),
        _tumbler(),
        _rest(),
        _disc("plate_disc", STAND, STAND_HEIGHT, WOOD, f"radius {STAND}; a plate lies on it, {STAND_HEIGHT} above the table"),
        _disc("coaster", COASTER, COASTER_HEIGHT, CORK, f"radius {COASTER}, {COASTER_HEIGHT} high"),
        _mat(),
    )
