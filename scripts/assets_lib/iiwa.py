"""The KUKA LBR iiwa 7 R800, modelled from the dimensions in its data sheet, with the gripper of `gripper.py`.

From "LBR iiwa 7 R800, LBR iiwa 14 R820: Specification" (KUKA Roboter GmbH, Spez LBR iiwa), none of whose drawings is used:

* axes 2, 4 and 6 are 340, 740 and 1140 mm above the foot, the flange is 126 mm above axis 6;
* ranges +-170, 120, 170, 120, 170, 120, 175 degrees; speeds 98, 98, 100, 130, 140, 180, 180 degrees/s;
* torques 176, 176, 110, 110, 110, 40, 40 N m; mass 23.9 kg.

The data sheet has no masses of links: the 23.9 kg are distributed evenly over the modelled volume.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from assets_lib.arm_appearance import light_appearances
from assets_lib.arms import ARM_DAMPING, Arm, ArmJoint, ArmLink, drawn, hull_shape, write_arm
from assets_lib.dae import Rgb
from assets_lib.gripper import COLORS as GRIPPER_COLORS
from assets_lib.gripper import FLANGE_RADIUS, gripper
from assets_lib.licences import mit
from assets_lib.mesh import FloatArray, Mesh, box, cylinder, lathe, mass_properties, merge
from assets_lib.urdf import Vec3

COLORS: dict[str, Rgb] = {**GRIPPER_COLORS, "white": (0.90, 0.905, 0.91), "orange": (0.96, 0.42, 0.06)}
MASS = 23.9
HEIGHTS = (0.15, 0.19, 0.21, 0.19, 0.21, 0.19, 0.081)
"""Of each joint over the one before; the flange is 45 mm over the last one [m]."""
FLANGE = 0.045
AXES: tuple[Vec3, ...] = ((0, 0, 1), (0, 1, 0), (0, 0, 1), (0, -1, 0), (0, 0, 1), (0, 1, 0), (0, 0, 1))
RANGES = (170, 120, 170, 120, 170, 120, 175)
SPEEDS = (98, 98, 100, 130, 140, 180, 180)
TORQUES = (176, 176, 110, 110, 110, 40, 40)
TRIANGLES = 4000
WEIGHTS = {"link_0": 0.7, "link_7": 2.0}
SIDES = 64
"""Of what is round, before the meshes are made light."""
ORANGE_SIDES = 24
"""Of what is orange and round, which stays as it is drawn."""
GAP = 0.0015
"""Half of the joint between two links [m]."""
Pieces = list[tuple[Rgb, Mesh]]


def build_iiwa(assets: Path) -> None:
    """Write the robot's URDF, SRDF, meshes and licence below `assets`."""
    parts = _parts()
    solids = {part: merge([mesh for _, mesh in pieces]) for part, pieces in parts.items()}
    total = sum(mass_properties(solid)[0] for solid in solids.values())
    links = [_link(part, solid, MASS / total) for part, solid in solids.items()]
    joints = [_joint(i) for i in range(1, 8)]
    hand = gripper("iiwa", "iiwa_link_7", (0.0, 0.0, FLANGE), (0.0, 0.0, math.pi))
    orange = COLORS["orange"]
    looks = light_appearances({part: [p for p in pieces if p[0] != orange] for part, pieces in parts.items()}, WEIGHTS, TRIANGLES)
    looks += [look for part, pieces in parts.items() for look in drawn(part, [p for p in pieces if p[0] == orange])]
    write_arm(
        Arm(
            "iiwa",
            "shapes of ours (MIT) after the data sheet of the KUKA LBR iiwa 7 R800, gripper of ours.",
            mit(),
            (*links, *hand.links),
            (*joints, *hand.joints),
            (*looks, *hand.looks),
            COLORS,
            {part: solid.vertices for part, solid in solids.items()} | hand.hulls,
        ),
        assets,
    )


def _link(part: str, solid: Mesh, density: float) -> ArmLink:
    volume, center, moments = mass_properties(solid)
    x, y, z = np.round(center, 5).tolist()
    return ArmLink(f"iiwa_{part}", volume * density, (x, y, z), moments * density, part, collisions=(hull_shape(part),))


def _joint(i: int) -> ArmJoint:
    span = math.radians(RANGES[i - 1])
    return ArmJoint(
        f"iiwa_joint_{i}",
        "revolute",
        f"iiwa_link_{i - 1}",
        f"iiwa_link_{i}",
        (0.0, 0.0, HEIGHTS[i - 1]),
        axis=AXES[i - 1],
        lower=-span,
        upper=span,
        effort=TORQUES[i - 1],
        velocity=math.radians(SPEEDS[i - 1]),
        damping=ARM_DAMPING,
    )


# Shapes -----------------------------------------------------------------------------------------------------------


def _parts() -> dict[str, Pieces]:
    """Draw all links: a foot, three pairs of links that meet at a pivot, and the flange."""
    return {
        "link_0": _foot(),
        "link_1": _lower(0.068, 0.074, HEIGHTS[1], -1.0),
        "link_2": _upper(0.074, 0.064, HEIGHTS[2], 1.0),
        "link_3": _lower(0.064, 0.068, HEIGHTS[3], 1.0),
        "link_4": _upper(0.068, 0.058, HEIGHTS[4], -1.0),
        "link_5": _lower(0.058, 0.062, HEIGHTS[5], -1.0),
        "link_6": _upper(0.062, 0.047, HEIGHTS[6], 1.0),
        "link_7": _flange(),
    }


def _foot() -> Pieces:
    """Draw the foot: a plate, a column that narrows, and the box of the plugs behind it."""
    plate = cylinder(0.096, 0.014, SIDES, bevel=0.003).moved((0.0, 0.0, 0.007))
    outline = [(0.0, 0.013), (0.088, 0.013), (0.078, 0.03), (0.07, 0.06), (0.068, 0.1), (0.068, 0.15 - GAP), (0.0, 0.15 - GAP)]
    plugs = _loft([(0.014, 0.0, 0.056, 0.09, 4.0), (0.052, 0.0, 0.05, 0.085, 4.0), (0.068, 0.0, 0.044, 0.06, 4.0)])
    plugs = plugs.moved((-0.055, 0.0, 0.0))
    sockets = [box((0.004, 0.024, 0.02), (-0.1125, y, 0.034)) for y in (-0.022, 0.022)]
    return [(COLORS["metal"], merge([plate, plugs])), (COLORS["white"], lathe(outline, SIDES)), (COLORS["dark"], merge(sockets))]


def _lower(bottom: float, pivot: float, height: float, side: float) -> Pieces:
    """Draw a link that stands on a joint and carries a pivot along y.

    Args:
        bottom: Radius of its lower end [m].
        pivot: Radius of the pivot [m].
        height: Of the pivot [m].
        side: -1 where its half of the pivot is at -y, 1 where it is at y.
    """
    ring = lathe([(0.0, GAP), (bottom - 0.003, GAP), (bottom - 0.003, 0.011), (0.0, 0.011)], SIDES)
    return [(COLORS["metal"], ring), *_half(bottom, pivot, height, side, 0.010)]


def _upper(pivot: float, top: float, height: float, side: float) -> Pieces:
    """Draw a link that hangs on a pivot along y and carries a joint above; as `_lower`, upside down."""
    return [(color, _upside_down(mesh, height)) for color, mesh in _half(top, pivot, height, side, GAP)]


def _half(end: float, pivot: float, height: float, side: float, start: float) -> Pieces:
    """Draw a column that becomes one half of a pivot, which has an orange cap."""
    middle, width = side * 0.5 * (pivot + GAP), 0.5 * (pivot - GAP)
    low = height - pivot - 0.004
    waist = start + 0.45 * (low - start)
    neck = _loft(
        [
            (start, 0.0, end, end, 2.0),
            (waist, 0.0, end, end, 2.0),
            (0.5 * (waist + low), 0.35 * middle, end, 0.5 * (end + width) + 0.004, 2.1),
            (low, 0.85 * middle, 0.97 * end, width + 0.007, 2.4),
            (height - 0.72 * pivot, middle, 0.9 * pivot, width, 3.0),
            (height - 0.3 * pivot, middle, 0.9 * pivot, 0.92 * width, 3.0),
        ]
    )
    quarter = -side * math.pi / 2.0
    at = (0.0, 0.0, height)
    drum = lathe(_drum(pivot), SIDES).moved(at, (quarter, 0.0, 0.0))
    seam = cylinder(pivot - 0.005, 0.004, SIDES).moved((0.0, side * (GAP + 0.001), height), (quarter, 0.0, 0.0))
    cap = lathe(_cap(pivot), ORANGE_SIDES).moved(at, (quarter, 0.0, 0.0))
    return [(COLORS["white"], merge([neck, drum])), (COLORS["metal"], seam), (COLORS["orange"], cap)]


def _drum(radius: float) -> list[tuple[float, float]]:
    """Return the outline of half a pivot along its axis: round at the outer edge."""
    edge, end = 0.35 * radius, radius + 0.004
    turns = np.linspace(0.0, math.pi / 2.0, 5)
    arc = [(radius - edge + edge * math.cos(a), end - edge + edge * math.sin(a)) for a in turns]
    return [(0.0, 2.0 * GAP), (radius, 2.0 * GAP), *arc, (0.0, end)]


def _cap(radius: float) -> list[tuple[float, float]]:
    """Return the outline of the disc on the outer end of a pivot."""
    end = radius + 0.004
    return [(0.0, end - 0.002), (0.62 * radius, end - 0.002), (0.6 * radius, end + 0.003), (0.0, end + 0.003)]


def _flange() -> Pieces:
    """Draw the last link: a ring, a short drum, and the flange of metal."""
    drum = [(0.0, 0.006), (0.047, 0.006), (0.047, 0.024), (0.043, 0.03), (0.0, 0.03)]
    plate = [(0.0, 0.029), (FLANGE_RADIUS + 0.004, 0.029), (FLANGE_RADIUS + 0.004, FLANGE), (0.0, FLANGE)]
    ring = [(0.0, GAP), (0.0445, GAP), (0.0445, 0.007), (0.0, 0.007)]
    metal = [(COLORS["metal"], lathe(outline, SIDES)) for outline in (plate, ring)]
    return [(COLORS["orange"], lathe(drum, ORANGE_SIDES)), *metal]


def _upside_down(mesh: Mesh, height: float) -> Mesh:
    """Return a mesh mirrored in z, its upper end at z = 0 and what was z = 0 at `height`."""
    return Mesh(mesh.vertices * (1.0, 1.0, -1.0) + (0.0, 0.0, height), mesh.faces[:, ::-1])


def _loft(levels: Sequence[tuple[float, float, float, float, float]]) -> Mesh:
    """Return a closed body through upright superellipses.

    Args:
        levels: From below: height, y of the middle, half sizes along x and y [m], and exponent; 2 is an ellipse.
    """
    angles = 2.0 * np.pi * np.arange(SIDES) / SIDES
    rings: list[FloatArray] = []
    for z, middle, x, y, power in levels:
        cos, sin = np.cos(angles), np.sin(angles)
        radius = (np.abs(cos) ** power + np.abs(sin) ** power) ** (-1.0 / power)
        rings.append(np.column_stack([x * radius * cos, middle + y * radius * sin, np.full(SIDES, z)]))
    ends = [np.append(ring[:, :2].mean(axis=0), ring[0, 2])[None] for ring in (rings[0], rings[-1])]
    count, last = len(rings) * SIDES, (len(rings) - 1) * SIDES
    faces = []
    for i in range(SIDES):
        j = (i + 1) % SIDES
        faces += [(count, j, i), (count + 1, last + i, last + j)]
        for low in range(0, last, SIDES):
            high = low + SIDES
            faces += [(low + i, low + j, high + j), (low + i, high + j, high + i)]
    return Mesh(np.concatenate([*rings, *ends]), np.array(faces))
