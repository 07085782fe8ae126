"""A pair of children's shoes and their box, whose lid hangs on a hinge."""

from __future__ import annotations

import numpy as np

from assets_lib.cabinets import bevelled, bevelled_box
from assets_lib.mesh import FloatArray, Mesh, box, hull_of, merge
from assets_lib.prisms import hull_prism
from assets_lib.urdf import Joint, Link, Model, Visual, box_shape, mesh_shape, plastic

LENGTH, WIDTH, HEIGHT, SOLE = 0.14, 0.055, 0.06, 0.011
TOE = 0.004
"""How far the toes are turned to the inner side [m]."""
BOX, WALL = (0.18, 0.26, 0.09), 0.005
OVERHANG, GAP = 0.015, 0.001
"""How far the lid reaches over the front wall, and the gap between walls and shut lid [m]."""
LID = (BOX[0] + OVERHANG, BOX[1], 0.006)
HINGE = (BOX[0] / 2.0, 0.0, BOX[2])
CANVAS, RUBBER, LACE, LINING = (0.25, 0.36, 0.48), plastic((0.92, 0.91, 0.88)), (0.93, 0.92, 0.90), (0.13, 0.15, 0.18)
CARD, CARD_LID, CARD_INSIDE, PAPER, INK = (
    (0.72, 0.36, 0.24),
    (0.78, 0.42, 0.28),
    (0.70, 0.66, 0.60),
    (0.95, 0.94, 0.90),
    (0.2, 0.2, 0.2),
)
STATIONS = (  # x, half width, height of the upper side: from the heel to the toes
    (-0.067, 0.017, 0.054),
    (-0.062, 0.0235, 0.058),
    (-0.050, 0.0268, 0.060),
    (-0.030, 0.0272, 0.058),
    (-0.006, 0.0272, 0.056),
    (0.006, 0.0270, 0.052),
    (0.024, 0.0268, 0.042),
    (0.040, 0.0262, 0.034),
    (0.054, 0.0235, 0.029),
    (0.063, 0.0180, 0.024),
    (0.067, 0.0120, 0.020),
    (0.0692, 0.0060, 0.0155),
)

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _bend(x: float, side: int) -> float:
    """Return y of the middle line of a shoe; `side` is 1 for the right one, whose inner side is +y."""
    return side * TOE * max(0.0, x / 0.07) ** 2


def _section(x: float, half: float, top: float, side: int) -> FloatArray:
    """Return a cross-section: sides upright, the upper edge round; as the shoe falls off, it gets rounder."""
    power = 6.0 if x < 0.0 else 6.0 - 50.0 * x
    angles = np.linspace(0.0, np.pi, 13)
    y = half * np.sign(np.cos(angles)) * np.abs(np.cos(angles)) ** (2.0 / power)
    z = SOLE - 0.002 + (top - SOLE + 0.002) * np.sin(angles) ** (2.0 / power)
    return np.column_stack([np.full(len(y), x), y + _bend(x, side), z])


def _loft(rings: list[FloatArray]) -> Mesh:
    """Return the closed skin over cross-sections along x."""
    count, vertices = len(rings[0]), np.concatenate([*rings, [rings[0].mean(axis=0)], [rings[-1].mean(axis=0)]])
    first, last = len(vertices) - 2, len(vertices) - 1
    faces = []
    for i in range(count):
        j = (i + 1) % count
        for k in range(len(rings) - 1):
            a, b, c, d = k * count + i, k * count + j, (k + 1) * count + j, (k + 1) * count + i
            faces += [(a, b, c), (a, c, d)]
        end = (len(rings) - 1) * count
        faces += [(first, j, i), (last, end + i, end + j)]
    return Mesh(vertices, np.array(faces))


def _outline(grow: float, side: int) -> FloatArray:
    """Return the outline of the sole, shape (n, 2)."""
    points = [(x, _bend(x, side) + s * (half + grow)) for x, half, _ in STATIONS for s in (-1, 1)]
    return np.array(
        [
            *points,
            (-LENGTH / 2.0, -0.006),
            (-LENGTH / 2.0, 0.006),
            *((LENGTH / 2.0, _bend(0.07, side) + y) for y in (-0.004, 0.004)),
        ]
    )


def _laces(side: int) -> Mesh:
    """Return four laces across the instep."""
    bars = []
    for x, z, wide in ((0.010, 0.0505, 0.030), (0.0195, 0.0452, 0.030), (0.029, 0.0402, 0.029), (0.038, 0.0358, 0.027)):
        bars.append(bevelled_box((0.0042, wide, 0.0026), bevel=0.001).moved((x, _bend(x, side), z), (0.0, 0.5, 0.0)))
    return merge(bars)


def _opening(grow: float, low: float, high: float) -> Mesh:
    """Return a flat rounded patch over the heel, where the foot goes in."""
    angles = 2.0 * np.pi * np.arange(20) / 20
    points = [(x + (0.017 + grow) * np.cos(a), (0.0175 + grow) * np.sin(a)) for x in (-0.043, -0.012) for a in angles]
    return hull_prism(np.array(points), low, high)


def _stripes() -> Mesh:
    """Return two stripes on either flank and a patch on the heel."""
    flank = [
        bevelled_box((0.005, 0.0554, 0.026), bevel=0.0005).moved((x, 0.0, 0.031), (0.0, 0.35, 0.0)) for x in (-0.012, -0.001)
    ]
    return merge([*flank, bevelled_box((0.003, 0.013, 0.03), (-0.0675, 0.0, 0.036), 0.001)])


def _shoe(name: str, side: int) -> Model:
    """Return a shoe; its toes point to +x."""
    upper = _loft([_section(*station, side) for station in STATIONS])
    visuals = (
        Visual(mesh_shape("upper", upper), CANVAS),
        Visual(mesh_shape("sole", hull_prism(_outline(0.0005, side), 0.0, SOLE)), RUBBER, crease=0.4),
        Visual(mesh_shape("cap", _toe_cap(side)), RUBBER),
        Visual(mesh_shape("laces", _laces(side)), LACE, crease=0.4),
        Visual(mesh_shape("collar", _opening(0.004, 0.055, 0.0605)), RUBBER, crease=0.4),
        Visual(mesh_shape("opening", _opening(0.0, 0.058, 0.061)), LINING, crease=0.4),
        Visual(mesh_shape("stripes", _stripes()), LACE, crease=0.4),
    )
    half = WIDTH / 2.0
    heel = hull_prism(
        np.array([(x, s * y) for x, y in ((-0.07, 0.012), (-0.06, half), (0.006, half)) for s in (-1, 1)]), 0.0, HEIGHT
    )
    low = [(x, _bend(x, side) + s * y, 0.0) for x, y in ((0.0, half), (0.05, 0.025), (0.07, 0.008)) for s in (-1, 1)]
    high = [
        (x, _bend(x, side) + s * y, z)
        for x, y, z in ((0.0, half, 0.052), (0.04, 0.022, 0.034), (0.068, 0.007, 0.02))
        for s in (-1, 1)
    ]
    shapes = (mesh_shape("heel_hull", heel), mesh_shape("toe_hull", hull_of(np.array([*low, *high]))))
    notes = (f"{LENGTH} x {WIDTH} x {HEIGHT}, toes towards +x; heel and instep, x -0.06..0.006, have upright sides",)
    return Model(name, f"objects/{name}", "bottom centre", (Link("shoe", 0.15, visuals, shapes, friction=1.0),), notes=notes)


def _toe_cap(side: int) -> Mesh:
    """Return the rubber over the toes: the upper, a little thicker."""
    rings = []
    for x, half, top in STATIONS[-5:]:
        rings.append(_section(x + 0.0012, half + 0.0008, top + 0.0008, side))
    return _loft(rings)


def _walls() -> tuple[Box, ...]:
    """Return the boxes (size, centre) of bottom and walls."""
    depth, width, height = BOX
    x, y, z, tall = (depth - WALL) / 2.0, (width - WALL) / 2.0, (height + WALL) / 2.0, height - WALL
    return (
        ((depth, width, WALL), (0.0, 0.0, WALL / 2.0)),
        *(((WALL, width, tall), (side * x, 0.0, z)) for side in (-1, 1)),
        *(((depth - 2 * WALL, WALL, tall), (0.0, side * y, z)) for side in (-1, 1)),
    )


def _lining() -> Mesh:
    """Return thin sheets that show the plain card inside."""
    t, x, y = 0.0006, BOX[0] / 2.0 - WALL, BOX[1] / 2.0 - WALL
    tall, z = BOX[2] - WALL - 0.002, WALL + (BOX[2] - WALL - 0.002) / 2.0
    sides = [box((t, 2 * y, tall), (side * (x - t / 2.0), 0.0, z)) for side in (-1, 1)]
    sides += [box((2 * x, t, tall), (0.0, side * (y - t / 2.0), z)) for side in (-1, 1)]
    return merge([box((2 * x, 2 * y, t), (0.0, 0.0, WALL + t / 2.0)), *sides])


def _sign() -> tuple[Mesh, Mesh]:
    """Return the side view of a shoe, flat, with its sole towards -x and its toes towards -y; and its sole with three laces."""
    heel = ((-0.021, 0.034), (0.024, 0.036), (0.021, 0.006), (-0.021, 0.004))
    toes = ((-0.021, 0.006), (0.021, 0.006), (0.006, -0.018), (-0.002, -0.040), (-0.012, -0.046), (-0.021, -0.046))
    sole = ((-0.030, 0.037), (-0.030, -0.048), (-0.023, -0.050), (-0.023, 0.037))
    upper = merge(hull_prism(np.array(part), 0.0, 0.0008) for part in (heel, toes))
    slope = np.array([(0.0135, -0.0035), (0.0085, -0.0125), (0.0045, -0.0215)])
    laces = [
        hull_prism(np.array([(x + a, y + b) for a in (-0.010, 0.002) for b in (-0.0012, 0.0012)]), 0.0, 0.0014) for x, y in slope
    ]
    return upper, merge([hull_prism(np.array(sole), 0.0, 0.0008), *laces])


def _box_model() -> Model:
    depth, width, height = BOX
    end = width / 2.0 + 0.0004
    paper = merge([box((0.07, 0.0008, 0.045), (0.0, side * end, 0.045)) for side in (-1, 1)])
    text = [
        box((w, 0.0008, 0.004), (0.0, side * (end + 0.0004), z))
        for side in (-1, 1)
        for w, z in ((0.05, 0.057), (0.05, 0.048), (0.03, 0.036))
    ]
    body = Link(
        "shoe_box",
        1.0,
        (
            Visual(mesh_shape("walls", bevelled(_walls(), 0.0015)), CARD, crease=0.3),
            Visual(mesh_shape("lining", _lining()), CARD_INSIDE),
            Visual(mesh_shape("papers", paper), PAPER),
            Visual(mesh_shape("text", merge(text)), INK),
        ),
        tuple(box_shape(size, center) for size, center in _walls()),
    )
    x, z = -LID[0] / 2.0, GAP + LID[2] / 2.0
    sign, dark = (part.moved((x, 0.0, GAP + LID[2])) for part in _sign())
    lid = Link(
        "lid",
        0.06,
        (
            Visual(mesh_shape("lid", bevelled_box(LID, (x, 0.0, z), 0.002)), CARD_LID, crease=0.3),
            Visual(mesh_shape("sign", sign), PAPER),
            Visual(mesh_shape("sign_sole", dark), INK),
            Visual(mesh_shape("lid_inside", box((LID[0] - 0.01, width - 0.012, 0.0006), (x, 0.0, GAP - 0.0003))), CARD_INSIDE),
        ),
        (box_shape(LID, (x, 0.0, z)),),
        friction=1.0,
    )
    joint = Joint("lid_hinge", "revolute", "shoe_box", "lid", HINGE, (0.0, 1.0, 0.0), 0.0, 2.85, damping=0.01)
    notes = (
        f"front faces -x, long side along y; hollow; inside x -+{depth / 2.0 - WALL:.3f}, y -+{width / 2.0 - WALL:.3f}, "
        f"floor at z = {WALL}, rim at z = {height}",
        f"link `lid` has its origin on the hinge at the middle of the back edge {HINGE}; at 0 it is closed and "
        f"spans x -{LID[0]}..0, z {GAP}..{GAP + LID[2]:.3f} there, {OVERHANG} beyond the front wall; "
        "it opens upwards and backwards",
    )
    return Model("shoe_box", "objects/shoe_box", "bottom centre", (body, lid), (joint,), notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_box_model(), _shoe("shoe_left", -1), _shoe("shoe_right", 1))
