"""A chequered board and draughtsmen of two colours."""

from __future__ import annotations

from assets_lib.mesh import Mesh, box, lathe, merge
from assets_lib.prisms import bevelled_box
from assets_lib.urdf import Link, Model, Visual, box_shape, mesh_shape, patterned

BOARD = (0.40, 0.40, 0.015)
SQUARE = 0.046
INLAY = 0.0004
"""How far the squares stand out, for the eye only [m]."""
RADIUS, THICKNESS = 0.0175, 0.012
BAR = (2.0 * RADIUS, 0.8 * RADIUS)
"""Sides of the two crossed boxes that stand for a disc: a cylinder on a board rocks forever in the physics, boxes rest [m]."""
LIFT = 0.0002
"""How far the second box is off the board, so that a disc rests on four corners, not on eight [m]."""
FRAME, DARK, LIGHT = (patterned(color, "wood") for color in ((0.20, 0.11, 0.06), (0.13, 0.26, 0.20), (0.80, 0.72, 0.54)))
"""Green and sand, so that white and red pieces stand out from both."""
COLORS = {"light": ((0.98, 0.97, 0.94), (0.80, 0.78, 0.72)), "dark": ((0.80, 0.10, 0.08), (0.55, 0.05, 0.04))}


def _squares(odd: int, side: float) -> Mesh:
    """Return the squares whose row and column add up to an even or an odd number."""
    places = [(r, c) for r in range(8) for c in range(8) if (r + c) % 2 == odd]
    size = (side, side, 2.0 * INLAY)
    return merge(box(size, ((r - 3.5) * side, (c - 3.5) * side, BOARD[2])) for r, c in places)


def board(name: str, side: float) -> Model:
    """Return a board with squares of `side` [m]."""
    visuals = (
        Visual(mesh_shape("frame", bevelled_box(BOARD, 0.003)), FRAME),
        Visual(mesh_shape("dark_squares", _squares(0, side)), DARK),
        Visual(mesh_shape("light_squares", _squares(1, side)), LIGHT),
    )
    link = Link(name, 1.0, visuals, (box_shape(BOARD, (0.0, 0.0, BOARD[2] / 2.0)),))
    notes = (
        f"8 x 8 squares of {side}; (row, column), both from 0, is at ((row - 3.5) {side}, (column - 3.5) {side})",
        f"dark where row + column is even; upper side at z = {BOARD[2]}",
    )
    return Model(name, f"objects/{name}", "bottom centre", (link,), notes=notes)


def _disc() -> tuple[Mesh, Mesh]:
    """Return the disc with a raised rim, and the ring in its hollow."""
    h, r = THICKNESS / 2.0, RADIUS
    outline = [
        (0.0, -h),
        (r - 0.001, -h),
        (r, -h + 0.001),
        (r, h - 0.001),
        (r - 0.001, h),
        (r - 0.004, h),
        (r - 0.005, h - 0.002),
    ]
    ring = [(0.0045, h - 0.002), (0.0085, h - 0.002), (0.0085, h - 0.0005), (0.0045, h - 0.0005), (0.0045, h - 0.002)]
    return lathe([*outline, (0.0, h - 0.002)], 24), lathe(ring, 24)


def _piece(color: str) -> Model:
    body, ring = _disc()
    plain, accent = COLORS[color]
    visuals = (Visual(mesh_shape("disc", body), plain, crease=0.5), Visual(mesh_shape("ring", ring), accent, crease=0.5))
    solids = (box_shape((*BAR, THICKNESS)), box_shape((BAR[1], BAR[0], THICKNESS - 2.0 * LIFT)))
    link = Link(f"draught_{color}", 0.02, visuals, solids, friction=0.9)
    notes = (
        f"diameter {2 * RADIUS}, {THICKNESS} thick; rests with its origin at {THICKNESS / 2.0} m",
        "two crossed boxes for contact, so it does not rock on a board",
    )
    return Model(f"draught_{color}", f"objects/draught_{color}", "centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (board("chequered_board", SQUARE), *(_piece(color) for color in COLORS))
