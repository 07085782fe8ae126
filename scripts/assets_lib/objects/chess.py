"""A chess board and men of two colours: six kinds, each with a top of its own shape and colour."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from assets_lib.mesh import Mesh, box, hull_of, icosphere, lathe, merge
from assets_lib.objects.draughts import board
from assets_lib.prisms import Point, grown, prism, regular_polygon
from assets_lib.urdf import Link, Model, Vec3, Visual, box_shape, mesh_shape, plastic

SQUARE = 0.0479
FOOT, WAIST, NECK, HEAD = 0.015, 0.0075, 0.006, 0.0095
"""Radii of the foot, of the narrowest place, below the head and of the head [m]."""
HEIGHTS = {"pawn": 0.052, "rook": 0.056, "knight": 0.060, "bishop": 0.064, "queen": 0.070, "king": 0.076}
KNIGHT_FOOT = 0.014
"""Height of the foot of a knight, below the neck of the horse [m]."""
TOP = 0.018
"""Height of the part that the fingers hold [m]."""
COLUMN = 0.009
"""Half the width of what collides above the foot [m]."""
COLORS: dict[str, Vec3] = {"white": (0.95, 0.93, 0.86), "black": (0.34, 0.20, 0.12)}
ACCENTS: dict[str, Vec3] = {"white": (0.80, 0.66, 0.40), "black": (0.62, 0.47, 0.28)}
"""Colour of crowns, mitres, battlements and manes, by that of the man."""
SEGMENTS = 14
CREASE = 0.6


def _body(kind: str) -> Mesh:
    """Return the turned part up to the head; that of a knight is a foot."""
    neck = HEIGHTS[kind] - TOP
    if kind == "knight":
        neck = KNIGHT_FOOT
        foot = [(0.0, 0.0), (FOOT, 0.0), (FOOT, 0.004), (FOOT - 0.003, 0.007), (FOOT - 0.004, neck - 0.002)]
        return lathe([*foot, (0.0105, neck), (0.0, neck)], SEGMENTS)
    outline = [
        (0.0, 0.0), (FOOT, 0.0), (FOOT, 0.004), (FOOT - 0.003, 0.007), (FOOT - 0.004, 0.010), (WAIST, 0.018),
        (NECK, neck - 0.003), (HEAD, neck - 0.001), (HEAD, neck + 0.001), (NECK, neck + 0.003), (0.0, neck + 0.003),
    ]  # fmt: skip
    return lathe(outline, SEGMENTS)


def _pawn(z: float) -> tuple[Mesh, Mesh | None]:
    return icosphere(HEAD, 1).moved((0.0, 0.0, z + TOP - HEAD)), None


def _rook(z: float) -> tuple[Mesh, Mesh | None]:
    wall = lathe([(0.0, z), (HEAD - 0.001, z + 0.002), (HEAD, z + 0.013), (0.0, z + 0.013)], SEGMENTS)
    teeth = [box((0.005, 0.005, 0.005), (0.0072 * np.cos(a), 0.0072 * np.sin(a), z + 0.0155)) for a in 0.5 * np.pi * np.arange(4)]
    return wall, merge(teeth)


def _knight(z: float) -> tuple[Mesh, Mesh | None]:
    """The head and neck of a horse, seen from the side: chest, muzzle, ears, and a mane behind."""
    low, high = KNIGHT_FOOT - 0.001, z + TOP
    neck = [
        (-0.0085, low),
        (0.0085, low),
        (0.0075, low + 0.010),
        (0.0025, high - 0.016),
        (-0.0005, high - 0.006),
        (-0.0085, high - 0.012),
    ]
    head = [
        (0.0025, high - 0.017),
        (0.0115, high - 0.0185),
        (0.0130, high - 0.0145),
        (0.0050, high - 0.0045),
        (-0.0035, high - 0.003),
    ]
    head += [(-0.0070, high - 0.009), (-0.0030, high - 0.013)]
    parts = [_rounded(neck, 0.0068), _rounded(head, 0.0064)]
    ears = ((-0.0045, high - 0.005), (0.0005, high - 0.0045), (-0.0030, high))
    parts += [_sideways(ears, 0.0012, 0.0003).moved((0.0, side * 0.0028, 0.0)) for side in (-1.0, 1.0)]
    crest = [
        (-0.0115, low + 0.008),
        (-0.0080, low + 0.006),
        (-0.0080, high - 0.012),
        (-0.0040, high - 0.003),
        (-0.0065, high - 0.002),
    ]
    crest += [(-0.0110, high - 0.011)]
    return merge(parts), _sideways(crest, 0.0018, 0.0004)


def _sideways(outline: Sequence[Point], half: float, bevel: float) -> Mesh:
    """Return a plate with an outline (x, z), its edges on both sides bevelled."""
    points = np.array(outline)
    flat = [(x, z, side * half) for x, z in grown(points, -bevel) for side in (-1.0, 1.0)]
    edge = [(x, z, side * (half - bevel)) for x, z in points for side in (-1.0, 1.0)]
    return hull_of(np.round(np.array(flat + edge), 6)).moved(rpy=(np.pi / 2.0, 0.0, 0.0))


def _rounded(outline: Sequence[Point], half: float) -> Mesh:
    """Return a cushion with an outline (x, z), in the middle `half` thick to both sides."""
    points = np.array(outline)
    middle = points.mean(axis=0)
    levels = ((1.0, 0.30), (0.93, 0.62), (0.78, 0.86), (0.52, 1.0))
    found = [(x, z, s * half * y) for share, y in levels for x, z in middle + (points - middle) * share for s in (-1.0, 1.0)]
    return hull_of(np.round(np.array(found), 6)).moved(rpy=(np.pi / 2.0, 0.0, 0.0))


def _bishop(z: float) -> tuple[Mesh, Mesh | None]:
    mitre = lathe([(0.0, z), (0.006, z), (HEAD - 0.001, z + 0.006), (0.004, z + 0.014), (0.0, z + 0.015)], SEGMENTS)
    return mitre, icosphere(0.0032, 1).moved((0.0, 0.0, z + 0.0165))


def _queen(z: float) -> tuple[Mesh, Mesh | None]:
    crown = lathe([(0.0, z), (0.005, z), (HEAD, z + 0.013), (0.006, z + 0.011), (0.0, z + 0.011)], SEGMENTS)
    angles = 2.0 * np.pi * np.arange(6) / 6.0
    pearls = [icosphere(0.0026, 1).moved((0.008 * np.cos(a), 0.008 * np.sin(a), z + 0.014)) for a in angles]
    return crown, merge([*pearls, icosphere(0.0036, 1).moved((0.0, 0.0, z + 0.0145))])


def _king(z: float) -> tuple[Mesh, Mesh | None]:
    crown = lathe([(0.0, z), (0.005, z), (HEAD, z + 0.009), (0.006, z + 0.012), (0.0, z + 0.012)], SEGMENTS)
    cross = merge([box((0.0035, 0.0035, 0.010), (0.0, 0.0, z + 0.015)), box((0.0035, 0.011, 0.0035), (0.0, 0.0, z + 0.0155))])
    return crown, cross


TOPS: dict[str, Callable[[float], tuple[Mesh, Mesh | None]]] = {
    "pawn": _pawn, "rook": _rook, "knight": _knight, "bishop": _bishop, "queen": _queen, "king": _king,
}  # fmt: skip


def man(color: str, kind: str) -> Model:
    """Return one man."""
    height, name = HEIGHTS[kind], f"chess_{color}_{kind}"
    top, accent = TOPS[kind](height - TOP)
    paint = plastic(COLORS[color])
    visuals = [
        Visual(mesh_shape("body", _body(kind)), paint, crease=CREASE),
        Visual(mesh_shape("top", top), paint, crease=CREASE),
    ]
    if accent is not None:
        visuals.append(Visual(mesh_shape("accent", accent), plastic(ACCENTS[color]), crease=CREASE))
    foot = (2.0 * FOOT, 0.8 * FOOT)
    lifted = 0.0002
    column = prism(regular_polygon(COLUMN / np.cos(np.pi / 8.0), 8, np.pi / 8.0), 0.007, height)
    solids = (
        box_shape((*foot, 0.008), (0.0, 0.0, 0.004)),
        box_shape((foot[1], foot[0], 0.008 - lifted), (0.0, 0.0, 0.004 + lifted / 2.0)),
        mesh_shape("column", column),
    )
    link = Link(name, 0.04, tuple(visuals), solids, friction=0.9, center=(0.0, 0.0, 0.012))
    notes = (
        f"foot {2.0 * FOOT} across, {height} high; the fingers hold its uppermost {TOP}, an octagon {2.0 * COLUMN} wide",
        "two crossed boxes are its foot for contact, so that it does not rock",
    )
    return Model(name, f"objects/{name}", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (board("chess_board", SQUARE), *(man(color, kind) for color in COLORS for kind in HEIGHTS))
