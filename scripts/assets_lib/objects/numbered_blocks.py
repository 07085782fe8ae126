"""White cubes with a digit on every face, bold enough to be readable in small images."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, merge
from assets_lib.prisms import bevelled_box, mark
from assets_lib.urdf import Link, Model, Vec3, Visual, box_shape, mesh_shape

SIDE, MASS = 0.065, 0.12
"""Side of a block [m] and its mass [kg]."""
WHITE, INK = (0.97, 0.97, 0.96), (0.02, 0.02, 0.05)
STROKE, WIDTH, HEIGHT = 0.011, 0.042, 0.053
"""Breadth of a stroke, and size of a digit [m]; a stroke is wider than a pixel of a picture of 128."""
INLAY = 0.0004
"""How far the digits stand out, for the eye only [m]."""
TURNS: tuple[Vec3, ...] = (
    *((0.0, 0.0, quarter * np.pi / 2.0) for quarter in range(4)),
    (0.0, -np.pi / 2.0, 0.0),
    (0.0, np.pi / 2.0, 0.0),
)
"""How the front face is turned to each of the six [rad]."""

Stroke = tuple[tuple[float, float], ...]
"""Corners of a convex part of a digit, from (0, 0) at its lower left to (1, 1) at its upper right."""
S, T = STROKE / WIDTH, STROKE / HEIGHT
"""Breadth of an upright and of a level stroke, in these units."""


def _bar(left: float, low: float, right: float, high: float) -> Stroke:
    return ((left, low), (right, low), (right, high), (left, high))


def _mirrored(stroke: Stroke) -> Stroke:
    """Return a part upside down."""
    return tuple((x, 1.0 - y) for x, y in stroke)


CUT, WAIST = (0.2, 0.13), 0.07
"""How far a round corner is cut, and half the height of the notch on the right of a three, in units of the digit."""
TOP: Stroke = ((0.0, 1.0 - T), (1.0, 1.0 - T), (1.0, 1.0 - CUT[1]), (1.0 - CUT[0], 1.0), (0.0, 1.0))
BASE = _bar(0.0, 0.0, 1.0, T)
BOW: Stroke = ((1.0 - S, 0.5), (1.0 - 0.5 * S, 0.5), (1.0, 0.5 + WAIST), (1.0, 1.0 - T), (1.0 - S, 1.0 - T))
STEM, FLAG = _bar(0.36, 0.0, 0.36 + 1.15 * S, 1.0), ((0.36, 1.0), (0.36, 1.0 - 1.5 * T), (0.08, 0.62), (0.08, 0.62 + 1.2 * T))
SLOPE: Stroke = ((0.0, T), (1.3 * S, T), (1.0, 0.56), (1.0 - S, 0.56))
DIGITS: dict[int, tuple[Stroke, ...]] = {
    1: (STEM, FLAG),
    2: (TOP, BASE, _bar(0.0, 0.7, S, 1.0 - T), _bar(1.0 - S, 0.56, 1.0, 1.0 - T), SLOPE),
    3: (TOP, _mirrored(TOP), BOW, _mirrored(BOW), _bar(0.3, 0.5 - T / 2.0, 1.0 - S, 0.5 + T / 2.0)),
}
"""The parts of each digit."""


def _front(digit: int) -> Mesh:
    """Return a digit on the face towards +x, read with z up."""
    size, start = np.array([WIDTH, HEIGHT]), np.array([-WIDTH, -HEIGHT]) / 2.0
    parts: list[FloatArray] = [np.array(stroke) * size + start for stroke in DIGITS[digit]]
    return merge(mark(part, SIDE / 2.0 + INLAY, "x") for part in parts)


def _block(digit: int) -> Model:
    name = f"numbered_block_{digit}"
    cube = bevelled_box((SIDE, SIDE, SIDE), 0.002).moved((0.0, 0.0, -SIDE / 2.0))
    front = _front(digit)
    visuals = (
        Visual(mesh_shape("block", cube), WHITE),
        Visual(mesh_shape(f"digits_{digit}", merge(front.moved(rpy=turn) for turn in TURNS)), INK),
    )
    link = Link(name, MASS, visuals, (box_shape((SIDE, SIDE, SIDE)),), friction=0.8)
    notes = (
        f"side {SIDE}; rests with its origin at {SIDE / 2.0} m; the digit {digit} on all six faces, upright on the four sides",
    )
    return Model(name, f"objects/{name}", "centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return tuple(_block(digit) for digit in DIGITS)
