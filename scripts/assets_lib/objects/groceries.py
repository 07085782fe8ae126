"""An open cupboard with two shelves on legs, and nine groceries."""

from __future__ import annotations

from dataclasses import dataclass

from assets_lib.cabinets import bevelled
from assets_lib.mesh import Mesh, box, lathe, merge
from assets_lib.prisms import bevelled_box, mark, rectangle, regular_polygon
from assets_lib.urdf import Link, Model, Shape, Vec3, Visual, box_shape, cylinder_shape, mesh_shape, metal, patterned

WIDTH, DEPTH, HEIGHT, BOARD, LEGS = 0.45, 0.25, 0.50, 0.015, 0.15
RAIL = 0.045
"""Height of the rails that close the shelves behind, from the undersides of the shelves [m]."""
SHELVES = (0.165, 0.4075)
"""Heights of the upper sides of the two shelves [m]."""
BODY, BACK, EDGE, LEG = (0.90, 0.89, 0.85), (0.50, 0.60, 0.64), (0.47, 0.29, 0.16), (0.30, 0.20, 0.13)
METAL, WHITE, PAPER = metal((0.75, 0.76, 0.78)), (0.96, 0.95, 0.92), (0.98, 0.97, 0.93)


def _boards() -> tuple[Shape, ...]:
    """Return the rails behind the shelves, sides, both shelves and top."""
    inner, middle, top = WIDTH - 2.0 * BOARD, LEGS + HEIGHT / 2.0, LEGS + HEIGHT
    flat = [box_shape((DEPTH - BOARD, inner, BOARD), (-BOARD / 2.0, 0.0, z - BOARD / 2.0)) for z in (*SHELVES, top)]
    sides = [box_shape((DEPTH, BOARD, HEIGHT), (0.0, s * (WIDTH - BOARD) / 2.0, middle)) for s in (-1.0, 1.0)]
    rails = [box_shape((BOARD, inner, RAIL), ((DEPTH - BOARD) / 2.0, 0.0, z + RAIL / 2.0 - BOARD)) for z in SHELVES]
    return (*rails, *sides, *flat)


def _legs() -> tuple[Shape, ...]:
    x, y = DEPTH / 2.0 - 0.025, WIDTH / 2.0 - 0.025
    return tuple(box_shape((0.03, 0.03, LEGS), (sx * x, sy * y, LEGS / 2.0)) for sx in (-1, 1) for sy in (-1, 1))


def _seen(shapes: tuple[Shape, ...]) -> Mesh:
    return bevelled([(shape.size, shape.xyz) for shape in shapes], 0.002)


def _edges() -> Mesh:
    """Return the strips along the front edges of sides, shelves and top, and a cornice."""
    x, t, wide = -DEPTH / 2.0, 0.002, BOARD + 0.004
    flat = [box((t, WIDTH, wide), (x, 0.0, z - BOARD / 2.0)) for z in (*SHELVES, LEGS + HEIGHT)]
    upright = [box((t, wide, HEIGHT), (x, s * (WIDTH - BOARD) / 2.0, LEGS + HEIGHT / 2.0)) for s in (-1.0, 1.0)]
    return merge([*flat, *upright, box((DEPTH + 0.012, WIDTH + 0.016, 0.008), (-0.002, 0.0, LEGS + HEIGHT + 0.002))])


def _back() -> Mesh:
    """Return the thin panel behind, which is only seen: the rails stop what slides there."""
    return box((0.0055, WIDTH - 0.018, HEIGHT - 0.018), (DEPTH / 2.0 - 0.00125, 0.0, LEGS + HEIGHT / 2.0))


def _cupboard() -> Model:
    lower, upper, *boards = _boards()
    legs = _legs()
    visuals = (
        Visual(mesh_shape("boards", _seen(tuple(boards))), BODY),
        Visual(mesh_shape("rails", _seen((lower, upper))), BODY),
        Visual(mesh_shape("back", _back()), BACK),
        Visual(mesh_shape("edges", _edges()), patterned(EDGE, "wood")),
        Visual(mesh_shape("legs", _seen(legs)), LEG),
    )
    link = Link("cupboard", 8.0, visuals, (lower, upper, *boards, *legs))
    free = SHELVES[1] - BOARD - SHELVES[0], LEGS + HEIGHT - BOARD - SHELVES[1]
    notes = (
        f"open towards -x, front edge at x = {-DEPTH / 2.0}, rails behind at x = {DEPTH / 2.0 - BOARD:.3f}, "
        f"sides at y = +-{WIDTH / 2.0 - BOARD:.3f}",
        f"upper sides of the shelves at z = {SHELVES[0]} and {SHELVES[1]}; {free[0]:.3f} and {free[1]:.3f} free above",
        "the thin panel behind is visual only; the rails stop what slides there",
    )
    return Model("cupboard", "objects/cupboard", "bottom centre", (link,), notes=notes)


@dataclass(frozen=True)
class Carton:
    """A box with a band and a label on its broad sides."""

    name: str
    size: Vec3
    mass: float
    color: Vec3
    label: Vec3
    accent: Vec3
    emblem: Vec3
    """Colour of what is printed on the label."""


CARTONS = (
    Carton("crackers", (0.12, 0.045, 0.15), 0.15, (0.80, 0.10, 0.10), (0.97, 0.85, 0.35), (0.98, 0.96, 0.90), (0.74, 0.42, 0.12)),
    Carton(
        "chocolate_jello",
        (0.07, 0.03, 0.06),
        0.08,
        (0.35, 0.18, 0.09),
        (0.96, 0.93, 0.86),
        (0.60, 0.36, 0.20),
        (0.35, 0.18, 0.09),
    ),
    Carton(
        "strawberry_jello",
        (0.07, 0.03, 0.06),
        0.08,
        (0.93, 0.35, 0.48),
        (0.98, 0.95, 0.95),
        (0.85, 0.08, 0.14),
        (0.85, 0.08, 0.14),
    ),
    Carton("sugar", (0.08, 0.04, 0.15), 0.25, (0.97, 0.93, 0.62), (0.98, 0.97, 0.94), (0.15, 0.35, 0.75), (0.15, 0.35, 0.75)),
)
SPAM = Carton("spam", (0.09, 0.055, 0.08), 0.25, (0.12, 0.25, 0.58), (0.98, 0.80, 0.15), METAL, (0.75, 0.12, 0.12))


@dataclass(frozen=True)
class Tin:
    """A cylinder with a label around it."""

    name: str
    diameter: float
    height: float
    mass: float
    color: Vec3
    band: Vec3
    lid: Vec3


TINS = (
    Tin("soup", 0.065, 0.09, 0.25, (0.82, 0.10, 0.10), (0.98, 0.96, 0.92), METAL),
    Tin("tuna", 0.07, 0.035, 0.15, (0.10, 0.45, 0.65), (0.85, 0.93, 0.97), METAL),
    Tin("coffee", 0.07, 0.12, 0.25, (0.22, 0.12, 0.07), (0.85, 0.55, 0.15), (0.10, 0.10, 0.10)),
)
MUSTARD_SIZE = (0.06, 0.05, 0.15)


def _model(name: str, height: float, mass: float, visuals: tuple[Visual, ...], solid: tuple[Shape, ...], note: str) -> Model:
    link = Link(name, mass, visuals, solid, friction=0.9, rolling=0.0005 if solid[0].kind == "cylinder" else 0.0)
    notes = (f"rests with its origin at {height / 2.0} m; {note}",)
    return Model(name, f"objects/{name}", "centre", (link,), notes=notes)


def _panels(size: Vec3, width: float, height: float, z: float, out: float) -> Mesh:
    """Return two flat panels on the broad sides of a box."""
    return merge(box((width, 0.001, height), (0.0, s * (size[1] / 2.0 + out), z)) for s in (-1.0, 1.0))


def _emblem(size: Vec3, middle: float, radius: float) -> Mesh:
    """Return what is printed on the labels of both broad sides: a disc at height `middle`, and two lines below it."""
    parts = []
    for side in (-1.0, 1.0):
        bars = [
            rectangle(size[0] * share, 0.07 * size[2]) + (0.0, middle - radius - (0.09 + 0.11 * k) * size[2])
            for k, share in enumerate((0.5, 0.34))
        ]
        outlines = (regular_polygon(radius, 14) + (0.0, middle), *bars)
        printed = merge(mark(outline, size[1] / 2.0 + 0.0014, "x") for outline in outlines)
        parts.append(printed.moved(rpy=(0.0, 0.0, side * 1.57079633)))
    return merge(parts)


def _carton(spec: Carton) -> Model:
    x, y, z = spec.size
    body = bevelled_box(spec.size, 0.002).moved((0.0, 0.0, -z / 2.0))
    stripe = merge(
        [_panels(spec.size, x * 0.98, z * 0.12, -z * 0.33, 0.0004), box((x * 0.5, y * 0.6, 0.001), (0.0, 0.0, z / 2.0 + 0.0002))]
    )
    visuals = (
        Visual(mesh_shape("box", body), spec.color),
        Visual(mesh_shape("label", _panels(spec.size, x * 0.78, z * 0.56, z * 0.12, 0.0004)), spec.label),
        Visual(mesh_shape("stripe", stripe), spec.accent),
        Visual(mesh_shape("emblem", _emblem(spec.size, 0.2 * z, 0.16 * z)), spec.emblem),
    )
    return _model(spec.name, z, spec.mass, visuals, (box_shape(spec.size),), f"{spec.size}; grasp it across y")


def _spam() -> Model:
    x, y, z = SPAM.size
    lid = merge(bevelled_box((x * 0.97, y * 0.95, 0.004), 0.001).moved((0.0, 0.0, h)) for h in (z / 2.0 - 0.004, -z / 2.0))
    body = box((x, y, z - 0.006))
    label = merge([_panels(SPAM.size, x * 0.75, z * 0.35, 0.005, 0.0004), box((x + 0.001, y * 0.6, z * 0.25), (0.0, 0.0, 0.005))])
    visuals = (
        Visual(mesh_shape("tin", body), SPAM.color),
        Visual(mesh_shape("label", label), SPAM.label),
        Visual(mesh_shape("lids", lid), SPAM.accent),
        Visual(mesh_shape("emblem", _panels(SPAM.size, x * 0.42, z * 0.16, 0.005, 0.0010)), SPAM.emblem),
    )
    return _model("spam", z, SPAM.mass, visuals, (box_shape(SPAM.size),), f"{SPAM.size}; grasp it across y")


def _badges(radius: float, half: float) -> Mesh:
    """Return four round badges on the band of a tin."""
    badge = mark(regular_polygon(min(0.28 * half, 0.012), 10), radius + 0.0005, "x")
    return merge(badge.moved(rpy=(0.0, 0.0, quarter * 1.57079633)) for quarter in range(4))


def _tin(spec: Tin) -> Model:
    r, h = spec.diameter / 2.0, spec.height / 2.0
    body = lathe([(0.0, -h), (r - 0.001, -h), (r - 0.001, h), (0.0, h)], 24)
    band = lathe([(r - 0.002, -h * 0.45), (r - 0.0003, -h * 0.45), (r - 0.0003, h * 0.45), (r - 0.002, h * 0.45)], 24)
    rims = merge(
        lathe([(0.0, z), (r, z), (r, z + 0.004), (r - 0.003, z + 0.004), (0.0, z + 0.0035)], 24) for z in (-h, h - 0.004)
    )
    visuals = (
        Visual(mesh_shape("tin", body), spec.color),
        Visual(mesh_shape("band", band), spec.band),
        Visual(mesh_shape("rims", rims), spec.lid),
        Visual(mesh_shape("badges", _badges(r, h)), spec.color),
    )
    note = f"diameter {spec.diameter}, {spec.height} high"
    return _model(spec.name, spec.height, spec.mass, visuals, (cylinder_shape(r, spec.height),), note)


def _mustard() -> Model:
    x, y, z = MUSTARD_SIZE
    outline = [(0.0, -z / 2.0), (0.93, -z / 2.0), (1.0, -z / 2.0 + 0.004), (1.0, 0.025), (0.45, 0.045), (0.0, 0.045)]
    bottle = lathe(outline, 20).scaled((x / 2.0, y / 2.0, 1.0))
    label = lathe([(0.98, -0.055), (1.015, -0.055), (1.015, 0.0), (0.98, 0.0)], 20).scaled((x / 2.0, y / 2.0, 1.0))
    cap = lathe([(0.0, 0.042), (0.014, 0.042), (0.013, 0.055), (0.004, 0.058), (0.003, z / 2.0), (0.0, z / 2.0)], 14)
    visuals = (
        Visual(mesh_shape("bottle", bottle), (0.96, 0.77, 0.08)),
        Visual(mesh_shape("label", label), (0.80, 0.12, 0.10)),
        Visual(mesh_shape("cap", cap), (0.90, 0.15, 0.10)),
    )
    solid = (box_shape((x * 0.85, y, 0.105), (0.0, 0.0, -0.0225)), cylinder_shape(0.013, 0.045, (0.0, 0.0, z / 2.0 - 0.0225)))
    return _model("mustard", z, 0.2, visuals, solid, f"{MUSTARD_SIZE}; body up to z = 0.025, grasp it across y")


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_cupboard(), *(_carton(spec) for spec in CARTONS), _spam(), *(_tin(spec) for spec in TINS), _mustard())
