"""A parallel gripper with the dimensions of the Panda's fingers, for arms without a gripper.

Two fingers slide on rails, 40 mm each. Their collision shapes, masses, limits and friction are those of the Panda, and so
are the poses of fingers and tip on the hand link. This module defines the visual shapes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assets_lib.arm_appearance import Appearance
from assets_lib.arms import ArmJoint, ArmLink, drawn, frame, hull_shape, symmetric
from assets_lib.dae import Rgb
from assets_lib.mesh import FloatArray, Mesh, box, cylinder, hull_of, mass_properties, merge
from assets_lib.urdf import ZERO, Shape, Vec3, box_shape

COLORS: dict[str, Rgb] = {"shell": (0.80, 0.81, 0.82), "metal": (0.56, 0.57, 0.59), "dark": (0.14, 0.14, 0.155)}
HAND_MASS, FINGER_MASS = 0.7, 0.015
FINGER_INERTIA = symmetric(2.375e-6, 2.375e-6, 7.5e-7)
FINGERS_AT, TIP_AT = 0.0584, 0.1034
"""Heights of the frames of the fingers and of the tip over the flange [m]."""
TRAVEL, SPEED, FORCE, DAMPING = 0.04, 0.2, 100.0, 0.3
"""Of a finger, in the URDF [m], [m/s], [N], [N s/m]."""
FLANGE_RADIUS, FLANGE_HEIGHT = 0.0315, 0.012


@dataclass(frozen=True)
class Gripper:
    """The gripper of one arm."""

    links: tuple[ArmLink, ...]
    joints: tuple[ArmJoint, ...]
    looks: tuple[Appearance, ...]
    hulls: dict[str, FloatArray]


def gripper(arm: str, parent: str, xyz: Vec3 = ZERO, rpy: Vec3 = ZERO) -> Gripper:
    """Return the gripper on the flange of an arm.

    Args:
        arm: Name of the arm, put before all names.
        parent: Its last link.
        xyz: Middle of the flange in the frame of that link [m].
        rpy: The hand's frame there, z out of the flange, the first finger towards y [rad].
    """
    hand, left, right = (f"{arm}_{name}" for name in ("hand", "leftfinger", "rightfinger"))
    body = _body()
    solid = merge([mesh for _, mesh in body])
    volume, center, moments = mass_properties(hull_of(solid.vertices))
    x, y, z = np.round(center, 4).tolist()
    finger = (FINGER_MASS, ZERO, FINGER_INERTIA, "finger")
    links = (
        ArmLink(hand, HAND_MASS, (x, y, z), moments * HAND_MASS / volume, "hand", collisions=(hull_shape("hand"),)),
        frame(f"{arm}_tip"),
        ArmLink(left, *finger, collisions=_finger_boxes(1.0), finger=True),
        ArmLink(right, *finger, (0.0, 0.0, math.pi), _finger_boxes(-1.0), finger=True),
    )
    slide = {"lower": 0.0, "upper": TRAVEL, "effort": FORCE, "velocity": SPEED, "damping": DAMPING}
    at = (0.0, 0.0, FINGERS_AT)
    joints = (
        ArmJoint(f"{hand}_joint", "fixed", parent, hand, xyz, rpy),
        ArmJoint(f"{arm}_tip_joint", "fixed", hand, f"{arm}_tip", (0.0, 0.0, TIP_AT), (0.0, 0.0, math.pi)),
        ArmJoint(f"{arm}_finger_joint1", "prismatic", hand, left, at, axis=(0.0, 1.0, 0.0), **slide),
        ArmJoint(f"{arm}_finger_joint2", "prismatic", hand, right, at, axis=(0.0, -1.0, 0.0), **slide),
    )
    looks = (*drawn("hand", body, 0.5), *drawn("finger", _finger(), 0.5))
    return Gripper(links, joints, looks, {"hand": solid.vertices})


def _finger_boxes(side: float) -> tuple[Shape, ...]:
    """Return the Panda's boxes of a finger that lies towards y times `side`: carriage, its ledge, a slanted part, the pad."""
    return (
        box_shape((0.022, 0.015, 0.02), (0.0, side * 0.0185, 0.011)),
        box_shape((0.022, 0.0088, 0.0038), (0.0, side * 0.0068, 0.0022)),
        box_shape((0.0175, 0.007, 0.0235), (0.0, side * 0.0159, 0.02835), (side * math.pi / 6.0, 0.0, 0.0)),
        box_shape((0.0175, 0.0152, 0.0185), (0.0, side * 0.00758, 0.04525)),
    )


def _body() -> list[tuple[Rgb, Mesh]]:
    """Draw the hand: a flange, a bevelled body that widens from it, a rail on top, and a dark field on both sides."""
    flange = cylinder(FLANGE_RADIUS, FLANGE_HEIGHT, 28, bevel=0.0015).moved((0.0, 0.0, FLANGE_HEIGHT / 2.0))
    shell = _levels(
        (
            (0.044, 0.060, 0.011, 0.010),
            (0.056, 0.130, 0.022, 0.010),
            (0.058, 0.166, 0.030, 0.010),
            (0.058, 0.166, 0.046, 0.010),
            (0.052, 0.160, 0.0505, 0.008),
        )
    )
    rail = box((0.024, 0.150, 0.006), (0.0, 0.0, 0.0525))
    rods = [box((0.003, 0.146, 0.002), (x, 0.0, 0.0565)) for x in (-0.0075, 0.0075)]
    fields = [_levels(((0.0592, 0.092, 0.0325, 0.0), (0.0592, 0.092, 0.0435, 0.0)))]
    ends = [box((0.026, 0.006, 0.0085), (0.0, side * 0.0765, 0.0535)) for side in (-1.0, 1.0)]
    return [
        (COLORS["metal"], merge([flange, *rods])),
        (COLORS["shell"], shell),
        (COLORS["dark"], merge([rail, *fields, *ends])),
    ]


def _finger() -> list[tuple[Rgb, Mesh]]:
    """Draw the finger towards +y: a carriage on the rail, an arm that leans in, and a dark pad."""
    carriage = hull_of(_corners((-0.011, 0.011), (0.0025, 0.026), (-0.003, 0.016), 0.0015))
    arm = hull_of(
        np.concatenate(
            [
                _corners((-0.0105, 0.0105), (0.009, 0.026), (0.013, 0.020), 0.001),
                _corners((-0.00875, 0.00875), (0.005, 0.0152), (0.0385, 0.0535), 0.001),
            ]
        )
    )
    pad = hull_of(_corners((-0.00875, 0.00875), (0.0, 0.0062), (0.036, 0.0545), 0.0008))
    return [(COLORS["metal"], merge([carriage, arm])), (COLORS["dark"], pad)]


def _corners(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float], bevel: float) -> FloatArray:
    """Return the corners (24, 3) of a box with bevelled edges."""
    points = []
    for i in (0, 1):
        for j in (0, 1):
            for k in (0, 1):
                corner = np.array([x[i], y[j], z[k]])
                inward = bevel * np.array([1 - 2 * i, 1 - 2 * j, 1 - 2 * k])
                points += [corner + inward * keep for keep in ((0, 1, 1), (1, 0, 1), (1, 1, 0))]
    return np.round(np.array(points), 6)


def _levels(levels: Sequence[tuple[float, float, float, float]]) -> Mesh:
    """Return the hull of rectangles (size x, size y, height, cut of the corners) one above the other."""
    points = []
    for x, y, z, cut in levels:
        for sx in (-0.5, 0.5):
            for sy in (-0.5, 0.5):
                points += [(sx * x, sy * (y - 2.0 * cut), z), (sx * (x - 2.0 * cut), sy * y, z)]
    return hull_of(np.unique(np.round(np.array(points), 6), axis=0))
