"""The two fingers of a gripper: conversions between the positions of the pads and the values of the finger joints.

A finger position is the distance [m] of a pad from the plane between the fingers; 0 is closed. It is the value of a prismatic
drive joint. For a revolute drive joint it follows from the forward kinematics of the URDF. Joints with `<mimic>` follow a drive
joint.
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
"""Number of values of a revolute drive joint at which positions are computed, for interpolation."""
_STEP = 1e-4
"""Difference of positions for the numerical derivative of a revolute finger [m]."""


@dataclass(frozen=True, eq=False)
class Travel:
    """The motion of a revolute finger, from closed to open."""

    values: FloatArray
    """Values of the drive joint (m,) [rad]."""
    positions: FloatArray
    """Positions of the pad (m,), increasing [m]."""

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
    """Driven joints, one for each moving finger."""
    followers: tuple[str, ...]
    """Joints that follow a drive."""
    follows: tuple[Follows, ...]
    """Drive, ratio and offset of each follower."""
    links: tuple[str, ...]
    """The hand link, the pads, then all other links with shapes on the hand link."""
    travels: tuple[Travel, ...] = ()
    """Motions of revolute fingers; empty if positions are the values of the drives."""

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
        """Return the derivative of the drive values by the finger positions (k,) [rad/m]; 1 for prismatic joints."""
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
        RobotModelError: A gripper joint is not in the URDF, or the pad of a revolute finger does not reach `gripper_open`.
    """
    urdf = read_urdf(description.urdf)
    joints = {joint.name: joint for joint in urdf.joints}
    drives = description.gripper_joints
    for name in drives:
        if name not in joints:
            raise RobotModelError(
                f"The URDF of '{description.name}' has no joint '{name}' of the gripper joints {drives}. "
                "Correct `gripper_joints`."
            )
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
    """Return how a joint follows one of the drives, directly or through other joints; None if it does not.

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
    """Return the links below a link."""
    below = {joint.child for joint in joints if joint.parent == link}
    return below.union(*(_carried(child, joints) for child in below))


def _travels(fingers: Fingers, description: RobotDescription, joints: Mapping[str, UrdfJoint]) -> tuple[Travel, ...]:
    """Return the motions of revolute fingers: positions of their pads for values of their drives."""
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
    """Return the part of a motion between closed and open."""
    if positions[0] > positions[-1]:
        values, positions = values[::-1], positions[::-1]
    if (np.diff(positions) <= 0.0).any() or positions[-1] < description.gripper_open or positions[0] > 0.005:
        raise RobotModelError(
            f"The finger positions of '{description.name}' range from {positions[0]:.4f} to {positions[-1]:.4f} m; they have to "
            f"include 0 m (closed) and `gripper_open` = {description.gripper_open} m. Correct `gripper_open` or the joint limits."
        )
    ends = [0.0, description.gripper_open]
    low, high = np.interp(ends, positions, values)
    inside = (positions > ends[0]) & (positions < ends[1]) & (values != low)  # some pads stop just short of the middle
    return Travel(np.array([low, *values[inside], high]), np.array([ends[0], *positions[inside], ends[1]]))
