"""The two fingers of a gripper: how far each pad is from the middle, and the joint values that bring it there.

A finger position is the distance [m] of a pad from the plane between the fingers; 0 is shut. A drive joint that slides has it
as its value. For one that turns it follows from the forward kinematics of the URDF. Joints with `<mimic>` follow a drive joint.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import RobotModelError
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.robot.geometry import extent_along, link_geometry
from rlbench_pin.spatial import FloatArray
from rlbench_pin.urdf import Follows, UrdfJoint, kinematic_urdf, read_urdf

_SAMPLES = 65
"""Values of a turning drive joint at which positions are computed; between them they are interpolated."""
_STEP = 1e-4
"""Difference of positions from which the lever of a turning finger follows [m]."""


@dataclass(frozen=True, eq=False)
class Travel:
    """The way of a turning finger, from shut to open."""

    values: FloatArray
    """Of the drive joint (m,) [rad]."""
    positions: FloatArray
    """Of the pad (m,), increasing [m]."""

    def position(self, value: float) -> float:
        """Return the position of the pad [m] for a value of the drive joint."""
        sign = np.sign(self.values[-1] - self.values[0])
        return float(np.interp(sign * value, sign * self.values, self.positions))

    def value(self, position: float) -> float:
        """Return the value of the drive joint for a position of the pad [m]."""
        return float(np.interp(position, self.positions, self.values))


@dataclass(frozen=True, eq=False)
class Fingers:
    """Joints and links of a gripper by their role."""

    drives: tuple[str, ...]
    """Joints that a motor moves, one for each finger that moves."""
    followers: tuple[str, ...]
    """Joints that follow one of the drives."""
    follows: tuple[Follows, ...]
    """For each follower its drive, and how it follows it."""
    links: tuple[str, ...]
    """The hand, the pads, then all other links with shapes that the hand carries."""
    travels: tuple[Travel, ...] = ()
    """Ways of turning fingers; empty where positions are the values of the drives."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Drives, then followers."""
        return (*self.drives, *self.followers)

    def positions(self, drives: FloatArray) -> FloatArray:
        """Return finger positions (k,) [m] for values of the drives (k,)."""
        if not self.travels:
            return drives
        return np.array([way.position(value) for way, value in zip(self.travels, drives, strict=True)])

    def drive_values(self, positions: FloatArray) -> FloatArray:
        """Return values of the drives (k,) for finger positions (k,) [m]."""
        if not self.travels:
            return positions
        return np.array([way.value(position) for way, position in zip(self.travels, positions, strict=True)])

    def lever(self, positions: FloatArray) -> FloatArray:
        """Return how fast the drives move when the fingers do (k,) [rad/m]; 1 for joints that slide."""
        if not self.travels:
            return np.ones(len(positions))
        inside = [np.clip(p, way.positions[0] + _STEP, way.positions[-1] - _STEP) for p, way in zip(positions, self.travels)]
        return (self.drive_values(np.add(inside, _STEP)) - self.drive_values(np.subtract(inside, _STEP))) / (2.0 * _STEP)

    def joint_values(self, positions: FloatArray) -> FloatArray:
        """Return values of `joints` for finger positions (k,) [m]."""
        values = self.drive_values(positions)
        return np.concatenate([values, self.follower_values(values)]) if self.followers else values

    def follower_speeds(self, drives: FloatArray) -> FloatArray:
        """Return velocities of the followers for velocities of the drives (k,)."""
        of = dict(zip(self.drives, drives.tolist(), strict=True))
        return np.array([way.ratio * of[way.joint] for way in self.follows])

    def follower_values(self, drives: FloatArray) -> FloatArray:
        """Return values of the followers for values of the drives (k,)."""
        of = dict(zip(self.drives, drives.tolist(), strict=True))
        return np.array([way.ratio * of[way.joint] + way.offset for way in self.follows])


@lru_cache(maxsize=32)
def fingers_of(description: RobotDescription) -> Fingers:
    """Return the fingers of an arm.

    Raises:
        RobotModelError: A gripper joint is not in the URDF, or a turning pad does not open as far as the description says.
    """
    urdf = read_urdf(description.urdf)
    joints = {joint.name: joint for joint in urdf.joints}
    drives = description.gripper_joints
    for name in drives:
        if name not in joints:
            raise RobotModelError(f"The URDF of '{description.name}' has no joint '{name}'; its gripper joints are {drives}.")
    follows = {name: way for name in joints if name not in drives and (way := way_of(name, joints, drives)) is not None}
    links = (description.hand_link, *description.finger_links)
    carried = _carried(description.hand_link, urdf.joints)
    shown = [link.name for link in urdf.links if link.visuals or link.collisions]
    others = (link for link in shown if link in carried and link not in links)
    fingers = Fingers(drives, tuple(follows), tuple(follows.values()), (*links, *others))
    if all(joints[name].kind == "prismatic" for name in drives):
        return fingers
    return replace(fingers, travels=_travels(fingers, description, joints))


def way_of(name: str, joints: Mapping[str, UrdfJoint], drives: tuple[str, ...]) -> Follows | None:
    """Return how a joint follows one of the drives, perhaps by way of others; None when it does not.

    Args:
        name: Name of the joint.
        joints: All joints of the URDF by name.
        drives: Names of the drives.
    """
    ratio, offset, seen = 1.0, 0.0, {name}
    while (way := joints[name].follows) is not None:
        ratio, offset, name = ratio * way.ratio, offset + ratio * way.offset, way.joint
        if name in drives:
            return Follows(name, ratio, offset)
        if name in seen or name not in joints:
            return None
        seen.add(name)
    return None


def _carried(link: str, joints: tuple[UrdfJoint, ...]) -> set[str]:
    """Return the links that a link carries."""
    below = {joint.child for joint in joints if joint.parent == link}
    return below.union(*(_carried(child, joints) for child in below))


def _travels(fingers: Fingers, description: RobotDescription, joints: Mapping[str, UrdfJoint]) -> tuple[Travel, ...]:
    """Return the ways of turning fingers: positions of their pads for values of their drives."""
    model = pin.buildModelFromXML(kinematic_urdf(description.urdf))
    data, shapes = model.createData(), link_geometry(description.urdf)
    frames = [model.getFrameId(name) for name in (description.tip_frame, *description.finger_links)]
    columns = [model.idx_qs[model.getJointId(name)] for name in fingers.joints]
    spans = np.array([joints[name].limits for name in fingers.drives])
    values = np.linspace(spans[:, 0], spans[:, 1], _SAMPLES)
    positions, q = np.empty_like(values), pin.neutral(model)
    for drives, row in zip(values, positions, strict=True):
        q[columns] = np.concatenate([drives, fingers.follower_values(drives)])
        pin.framesForwardKinematics(model, data, q)
        tip, *pads = (data.oMf[frame] for frame in frames)
        for k, (link, pad) in enumerate(zip(description.finger_links, pads, strict=True)):
            side = np.array([0.0, 1.0 if k else -1.0, 0.0])  # the first finger is at negative y of the tip
            row[k] = extent_along(shapes[link], tip.inverse() * pad, side[None])[0, 0]
    return tuple(_travel(*way, description) for way in zip(values.T, positions.T, strict=True))


def _travel(values: FloatArray, positions: FloatArray, description: RobotDescription) -> Travel:
    """Return the part of a way between shut and open."""
    if positions[0] > positions[-1]:
        values, positions = values[::-1], positions[::-1]
    if (np.diff(positions) <= 0.0).any() or positions[-1] < description.gripper_open or positions[0] > 0.005:
        raise RobotModelError(
            f"The fingers of '{description.name}' go from {positions[0]:.4f} to {positions[-1]:.4f} m from the middle when their "
            f"joints turn; they have to go from shut, 0 m, to `gripper_open`, {description.gripper_open} m."
        )
    ends = [0.0, description.gripper_open]
    low, high = np.interp(ends, positions, values)
    inside = (positions > ends[0]) & (positions < ends[1]) & (values != low)  # some pads stop just short of the middle
    return Travel(np.array([low, *values[inside], high]), np.array([ends[0], *positions[inside], ends[1]]))
