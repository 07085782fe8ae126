"""An alarm clock on two legs; a winged key at its back turns the long hand, on one axle."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, cylinder, hull_of, lathe, merge, rod
from assets_lib.objects.numbered_blocks import BASE, DIGITS, S, Stroke, T
from assets_lib.prisms import mark
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
    Shape,
    Visual,
    box_shape,
    cylinder_shape,
    mesh_shape,
    metal,
    plastic,
    shining,
    sphere_shape,
)

RADIUS, DEPTH, AXLE_Z = 0.11, 0.04, 0.16
"""Radius and depth of the case, and height of the axle [m]."""
FACE = -DEPTH / 2.0
"""x of the dial [m]; it faces -x."""
HAND_X, HAND, THIN = FACE - 0.006, (0.09, 0.012), 0.003
"""x of the middle of the long hand; how far it reaches from the axle, and how wide it is; its thickness [m]."""
RIM = 0.016
"""How far the rim stands out before the dial [m]; a glass that is not drawn closes it."""
WING, WING_X = (0.02, 0.015, 0.04), 0.055
"""Size of the key along x, y and z at 0, and x of its middle [m]."""
HALF_PI = 1.57079633
RED, PALE, INK, BRASS, PLATE = (
    plastic((0.72, 0.13, 0.11)),
    (0.66, 0.65, 0.62),
    (0.02, 0.02, 0.03),
    metal((0.92, 0.70, 0.20)),
    (0.28, 0.30, 0.34),
)
HOUR_BLUE = (0.10, 0.36, 0.72)
FULL, QUARTER = (0.013, 0.007), (0.019, 0.010)
"""Length and width of the mark of an hour and of a quarter [m]."""
NUMERAL, NUMERAL_AT, GAP = (0.017, 0.026), 0.060, 0.012
"""Width and height of a digit; how far the middle of a numeral is from the axle; the space between two digits [m]."""
_LEFT: Stroke = ((0.0, 0.0), (S, 0.0), (S, 1.0), (0.0, 1.0))
_RIGHT: Stroke = ((1.0 - S, 0.0), (1.0, 0.0), (1.0, 0.56), (1.0 - S, 0.56))
_ACROSS: Stroke = ((0.0, 0.56 - T), (1.0, 0.56 - T), (1.0, 0.56), (0.0, 0.56))
_HEAD: Stroke = ((0.0, 1.0 - T), (1.0, 1.0 - T), (1.0, 1.0), (0.0, 1.0))
SIX = (_LEFT, _RIGHT, _ACROSS, _HEAD, BASE)
NINE: tuple[Stroke, ...] = tuple(tuple((1.0 - x, 1.0 - y) for x, y in stroke) for stroke in SIX)
MARKED = 0.0018
"""How far marks stand out before the case [m]."""
NUMERALS: dict[int, tuple[tuple[Stroke, ...], ...]] = {0: (DIGITS[1], DIGITS[2]), 3: (DIGITS[3],), 6: (SIX,), 9: (NINE,)}
"""Hour of a quarter -> the digits of its numeral."""


def _case() -> Mesh:
    """Return the case with its rim, open towards the dial."""
    back, front, inner = DEPTH / 2.0, FACE - RIM, RADIUS - 0.008
    outline = [
        (0.0, -back),
        (RADIUS - 0.006, -back),
        (RADIUS, -back + 0.006),
        (RADIUS, -front - 0.003),
        (RADIUS - 0.003, -front),
        (inner, -front),
        (inner, -FACE),
    ]
    return lathe(outline, 36).moved((0.0, 0.0, AXLE_Z), (0.0, -HALF_PI, 0.0))


def _dial() -> Mesh:
    """Return the flat dial."""
    return lathe([(RADIUS - 0.006, 0.0), (0.0, 0.0)], 36).moved((FACE - 0.0005, 0.0, AXLE_Z), (0.0, -HALF_PI, 0.0))


def _marks() -> Mesh:
    """Return the marks of the hours and four numerals, flat, for a viewer at +x."""
    pieces = []
    for hour in range(12):
        length, width = QUARTER if hour % 3 == 0 else FULL
        turn, outer = -hour * np.pi / 6.0, RADIUS - 0.011
        along, across = np.array([-np.sin(turn), np.cos(turn)]), np.array([np.cos(turn), np.sin(turn)])
        pieces.append(
            mark([r * along + side * width / 2.0 * across for r in (outer - length, outer) for side in (-1, 1)], MARKED, "x")
        )
        digits = NUMERALS.get(hour, ())
        for i, digit in enumerate(digits):
            shift = (i - (len(digits) - 1) / 2.0) * (NUMERAL[0] + GAP)
            corner = NUMERAL_AT * along + (shift, 0.0) - np.array(NUMERAL) / 2.0
            pieces += [mark(np.array(stroke) * NUMERAL + corner, MARKED, "x") for stroke in digit]
    return merge(pieces)


def _stand() -> Mesh:
    """Return two splayed legs with feet, and the handle over the bells."""
    legs = [rod((0.0, s * 0.045, AXLE_Z - RADIUS + 0.02), (0.0, s * 0.075, 0.008), 0.007, 8) for s in (-1, 1)]
    feet = [box((0.07, 0.026, 0.012), (0.0, s * 0.077, 0.006)) for s in (-1, 1)]
    return merge([*legs, *feet])


def _bells() -> Mesh:
    """Return the two bells on top, each on a stalk."""
    angles = np.linspace(0.0, np.pi / 2.0, 5)[:-1]
    half = [(0.0, 0.0), *((0.028 * float(np.cos(a)), 0.025 * float(np.sin(a))) for a in angles), (0.0, 0.025)]
    parts = []
    for side in (-1, 1):
        turn = -side * 0.55
        place = (0.0, side * float(np.sin(0.55)) * (RADIUS + 0.006), AXLE_Z + float(np.cos(0.55)) * (RADIUS + 0.006))
        parts.append(lathe(half, 16).moved(place, (turn, 0.0, 0.0)))
        parts.append(cylinder(0.005, 0.02, 6).moved(place, (turn, 0.0, 0.0)))
    return merge(parts)


def _short_hand() -> Mesh:
    """Return the hand of the hours at twelve: short, with a broad point."""
    outline = [(-0.005, -0.016), (0.005, -0.016), (0.0085, 0.040), (-0.0085, 0.040), (0.0, 0.060)]
    return hull_of(np.array([(FACE - 0.0012 - t, y, z + AXLE_Z) for y, z in outline for t in (0.0, 0.0015)]))


def _case_shapes() -> tuple[Shape, ...]:
    """Return the case, the glass, the legs with their feet, and the bells."""
    across = (0.0, HALF_PI, 0.0)
    case = cylinder_shape(RADIUS, DEPTH, (0.0, 0.0, AXLE_Z), across)
    glass = cylinder_shape(RADIUS, 0.003, (FACE - RIM + 0.0015, 0.0, AXLE_Z), across)
    legs = (box_shape((0.014, 0.014, 0.06), (0.0, s * 0.063, 0.038), (-s * 0.46, 0.0, 0.0)) for s in (-1, 1))
    feet = (box_shape((0.07, 0.026, 0.012), (0.0, s * 0.077, 0.006)) for s in (-1, 1))
    bell_y, bell_z = float(np.sin(0.55)) * (RADIUS + 0.012), AXLE_Z + float(np.cos(0.55)) * (RADIUS + 0.012)
    bells = (sphere_shape(0.023, (0.0, s * bell_y, bell_z)) for s in (-1, 1))
    return (case, glass, *legs, *feet, *bells)


def _case_link() -> Link:
    marks = _marks().moved((-FACE, 0.0, 0.0)).moved((0.0, 0.0, AXLE_Z), (0.0, 0.0, np.pi))
    visuals = (
        Visual(mesh_shape("case", _case()), RED),
        Visual(mesh_shape("dial", _dial()), shining(PALE)),
        Visual(mesh_shape("marks", marks), INK),
        Visual(mesh_shape("short_hand", _short_hand()), HOUR_BLUE),
        Visual(mesh_shape("stand", _stand()), PLATE),
        Visual(mesh_shape("bells", _bells()), BRASS),
    )
    return Link("case", 1.2, visuals, _case_shapes())


def _movement_link() -> Link:
    """Return the long hand and the key, which turn as one; the origin is on the axle."""
    length, width = HAND
    tail = 0.018
    hand = box((THIN, 0.6 * width, length + tail), (HAND_X, 0.0, (length - tail) / 2.0))
    boss = cylinder(0.010, THIN + 0.002, 12).moved((HAND_X, 0.0, 0.0), (0.0, HALF_PI, 0.0))
    low, high = DEPTH / 2.0, WING_X + WING[0] / 2.0
    axle = rod((low, 0.0, 0.0), (high - 0.004, 0.0, 0.0), 0.007, 10)
    wings = [box(WING, (WING_X, 0.0, 0.0)), cylinder(0.0075, WING[0], 10).moved((WING_X, 0.0, 0.0), (0.0, HALF_PI, 0.0))]
    visuals = (
        Visual(mesh_shape("long_hand", merge([hand, boss])), INK),
        Visual(mesh_shape("key", merge([axle, *wings])), BRASS),
    )
    shapes = (
        box_shape((THIN, width, length + tail), (HAND_X, 0.0, (length - tail) / 2.0)),
        box_shape((WING_X - low - 0.002, 0.012, 0.012), ((WING_X + low + 0.002) / 2.0, 0.0, 0.0)),
        box_shape(WING, (WING_X, 0.0, 0.0)),
    )
    return Link("movement", 0.06, visuals, shapes, friction=1.0)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    turn = Joint("hand", "revolute", "case", "movement", (0.0, 0.0, AXLE_Z), (1.0, 0.0, 0.0), -3.14, 5.0, damping=0.002)
    notes = (
        f"the dial, of diameter {2 * RADIUS}, faces -x; its middle is at z = {AXLE_Z}, and three o'clock at -y",
        f"link `movement` is the long hand, at twelve at 0, {HAND[0]} long from the axle, at x = {HAND_X:.3f}, and the key; "
        "the joint `hand` increases clockwise for a viewer in front",
        f"the key at the back, {WING[0]} x {WING[1]} x {WING[2]}, is upright at 0; its middle is at x = {WING_X}",
        f"a glass that is not drawn closes the rim, {RIM} before the dial; the short hand is fixed at twelve",
    )
    return (
        Model(
            "alarm_clock",
            "objects/alarm_clock",
            "bottom centre, below the middle",
            (_case_link(), _movement_link()),
            (turn,),
            notes,
        ),
    )
