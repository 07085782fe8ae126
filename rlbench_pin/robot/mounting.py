"""Mounting of a gripper on an arm, and detection of finger joints and links, from URDF files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import RobotModelError
from rlbench_pin.robot.description import HAND_CAMERA
from rlbench_pin.robot.fingers import way_of
from rlbench_pin.robot.geometry import extent_along, link_geometry, to_placement
from rlbench_pin.spatial import FloatArray, pose_to_se3, se3_to_pose
from rlbench_pin.urdf import Follows, Urdf, UrdfJoint, kinematic_urdf, read_urdf

_TIP_BEHIND_END = 0.01
"""Distance of the tip from the end of the pads, as in the Panda's gripper [m]."""
_SHUT = 0.005
"""Distance of pads from the middle at which the gripper is closed [m]."""
_SAMPLES = 33


@dataclass(frozen=True, eq=False)
class Mount:
    """Pose of the gripper base in the flange of an arm."""

    xyz: FloatArray
    """Position (3,) [m]."""
    rpy: FloatArray
    """Roll, pitch, yaw (3,) [rad]."""

    def turned(self, angle: float) -> Mount:
        """Return the mount with the gripper rotated about its z axis [rad]."""
        return Mount(self.xyz, _rpy(pin.rpy.rpyToMatrix(self.rpy) @ pin.rpy.rpyToMatrix(0.0, 0.0, angle)))


@dataclass(frozen=True)
class Slide:
    """Motion of a prismatic finger."""

    joint: str
    shut: float
    """Value of the joint at which the pad is at the middle [m]."""
    sign: float
    """1 if larger values open the finger, -1 if smaller values do."""
    travel: float
    """Largest distance of the pad from the middle [m]."""


@dataclass(frozen=True, eq=False)
class FingerLayout:
    """The two fingers of a gripper."""

    drives: tuple[str, str]
    """Joints that move the first and the second finger."""
    pads: tuple[str, str]
    """Links of the pads."""
    tip: Mount
    """Tip frame in the base link of the gripper."""
    camera: FloatArray
    """Pose (7,) of the wrist camera in the base link."""
    opening: float
    """Distance of each pad from the middle when the gripper is open [m]."""
    slides: tuple[Slide, ...]
    """Motions of prismatic drives; empty for revolute drives."""
    follows: Mapping[str, Follows]
    """Drive, ratio and offset of each other moving joint."""


def flange_mount(urdf: Path, flange: str) -> Mount:
    """Return the mount of a gripper: its z axis along the axis of the last joint, away from the arm, at the end of the flange.

    The frame of a flange without shapes is used unchanged if its z axis is along that axis.

    Raises:
        RobotModelError: No joint moves the flange.
    """
    chain = joints_to(read_urdf(urdf), flange)
    last = max((k for k, joint in enumerate(chain) if joint.kind != "fixed"), default=None)
    if last is None:
        raise RobotModelError(
            f"No joint of '{urdf.name}' moves '{flange}'. Pass the link that carries the gripper with --flange."
        )
    T_joint_flange = pin.SE3.Identity()
    for joint in chain[last + 1 :]:
        T_joint_flange = T_joint_flange * to_placement(joint.origin)
    axis = T_joint_flange.rotation.T @ np.array(chain[last].axis) / np.linalg.norm(chain[last].axis)
    # The way from the joints before it to the flange leads outwards.
    T_flange_before = T_joint_flange.inverse()
    for joint in reversed(chain[: last + 1]):
        T_flange_before = T_flange_before * to_placement(joint.origin).inverse()
        along = float(-axis @ T_flange_before.translation)
        if abs(along) > 1e-3:
            axis *= np.sign(along)
            break
    parts = link_geometry(urdf).get(flange, ())
    end = max(0.0, float(extent_along(parts, pin.SE3.Identity(), axis[None])[1, 0])) if parts else 0.0
    rotation = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis).toRotationMatrix()
    return Mount(end * axis, _rpy(rotation))


def finger_layout(file: Path) -> FingerLayout:
    """Return the fingers of a gripper whose z points out of the flange.

    The pads are the two links with collision shapes, at the ends of moving joints, that reach farthest along z.

    Raises:
        RobotModelError: There are not two such links, one joint moves both, or another joint moves freely.
    """
    hand = _Hand(file)
    pads = hand.pads()
    drives = [next(joint for joint in joints_to(hand.urdf, pad) if joint.kind != "fixed") for pad in pads]
    if drives[0].name == drives[1].name:
        raise RobotModelError(
            f"One joint, '{drives[0].name}', moves both fingers of '{file.name}': {pads[0]} and {pads[1]}. "
            "Use a gripper with one joint per finger; one of them may be a <mimic> of the other."
        )
    if drives[0].follows is not None:
        drives, pads = drives[::-1], pads[::-1]
    first, second = drives
    if first.follows is not None or (second.follows is not None and second.follows.joint != first.name):
        raise RobotModelError(
            f"Both finger joints of '{file.name}' follow other joints. Remove <mimic> from {first.name} or {second.name}."
        )
    ways = {first.name: Follows(first.name), second.name: second.follows or Follows(second.name)}
    T_base_tip = hand.tip(pads, ways)
    follows = hand.follows(first, second, T_base_tip)
    one = second.follows or Follows(second.name)
    spans = [first.limits, second.limits]
    if second.follows is not None:
        ends = sorted(one.ratio * value + one.offset for value in first.limits)
        spans[1] = ends[0], ends[1]
    table = [hand.positions(drive.name, pad, T_base_tip, span, first=k == 0, follows=follows)
             for k, (drive, pad, span) in enumerate(zip(drives, pads, spans, strict=True))]  # fmt: skip
    slides = tuple(_slide(file, drive, *way) for drive, way in zip(drives, table, strict=True) if drive.kind == "prismatic")
    opening = min(slide.travel for slide in slides) if slides else 0.98 * min(float(positions.max()) for _, positions in table)
    hand_frame = T_base_tip * pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, np.pi), np.array([0.0, 0.0, -0.1034]))
    return FingerLayout(
        (first.name, second.name),
        (pads[0], pads[1]),
        Mount(T_base_tip.translation, _rpy(T_base_tip.rotation)),
        se3_to_pose(hand_frame * pose_to_se3(HAND_CAMERA)),
        float(np.floor(1e4 * opening + 1e-3) / 1e4),
        slides,
        {name: way for name, way in follows.items() if name not in (first.name, second.name)},
    )


def _rpy(rotation: FloatArray) -> FloatArray:
    """Return roll, pitch, yaw (3,) of a rotation (3, 3); where pitch is a right angle, roll is 0."""
    if abs(rotation[2, 0]) < 1.0 - 1e-9:
        return np.array(pin.rpy.matrixToRpy(rotation))
    return np.array([0.0, -np.sign(rotation[2, 0]) * 0.5 * np.pi, np.arctan2(-rotation[0, 1], rotation[1, 1])])


def joints_to(urdf: Urdf, link: str) -> list[UrdfJoint]:
    """Return the joints from the base to a link."""
    into, chain = {joint.child: joint for joint in urdf.joints}, list[UrdfJoint]()
    while link in into:
        chain.insert(0, into[link])
        link = into[link].parent
    return chain


def _slide(file: Path, drive: UrdfJoint, values: FloatArray, positions: FloatArray) -> Slide:
    slope = float((positions[-1] - positions[0]) / (values[-1] - values[0]))
    if abs(abs(slope) - 1.0) > 0.02:
        raise RobotModelError(
            f"The finger of '{drive.name}' of '{file.name}' moves {slope:.2f} m across per metre of its joint; it has to be 1. "
            "Correct the axis of this joint."
        )
    sign, travel = float(np.sign(slope)), float(positions.max())
    if abs(positions.min()) > _SHUT:
        raise RobotModelError(
            f"The pad of '{drive.name}' of '{file.name}' stops {1000 * positions.min():.1f} mm from the middle, not at 0. "
            "Correct the limits of this joint."
        )
    return Slide(drive.name, float(values[0] - sign * positions[0]), sign, travel)


class _Hand:
    """A gripper and its kinematics."""

    def __init__(self, file: Path) -> None:
        self.file, self.urdf, self.shapes = file, read_urdf(file), link_geometry(file)
        self.model = pin.buildModelFromXML(kinematic_urdf(file))
        self.data = self.model.createData()

    def placement(self, link: str, values: Mapping[str, float]) -> pin.SE3:
        """Return T_base_link where some joints have values, and all others are at zero."""
        q = pin.neutral(self.model)
        for name, value in values.items():
            q[self.model.idx_qs[self.model.getJointId(name)]] = value
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.model.getFrameId(link)].copy()

    def pads(self) -> list[str]:
        """Return the links of the pads, in file order."""
        parents = {joint.parent for joint in self.urdf.joints}
        moved = [link for link in self.shapes if any(joint.kind != "fixed" for joint in joints_to(self.urdf, link))]
        ends = [
            link
            for link in moved
            if link not in parents or not any(other != link and link in self._above(other) for other in moved)
        ]
        if len(ends) < 2:
            raise RobotModelError(
                f"'{self.file.name}' has {len(ends)} finger links with collision shapes; a gripper needs two. "
                "Add <collision> elements to the finger links."
            )
        up = np.array([[0.0, 0.0, 1.0]])
        ends.sort(key=lambda link: -float(extent_along(self.shapes[link], self.placement(link, {}), up)[1, 0]))
        return [link for link in self.shapes if link in ends[:2]]

    def _above(self, link: str) -> set[str]:
        return {joint.parent for joint in joints_to(self.urdf, link)}

    def tip(self, pads: list[str], ways: Mapping[str, Follows]) -> pin.SE3:
        """Return T_base_tip: between the pads, y from the first to the second, z as the base's."""
        rest = {name: way.offset for name, way in ways.items()}
        places = [self.placement(pad, rest) for pad in pads]
        boxes = [extent_along(self.shapes[pad], place, np.eye(3)) for pad, place in zip(pads, places, strict=True)]
        middles = [box.mean(axis=0) for box in boxes]
        y = (middles[1] - middles[0]) * (1.0, 1.0, 0.0)
        if np.linalg.norm(y) < 1e-3:
            raise RobotModelError(
                f"The fingers {pads[0]} and {pads[1]} of '{self.file.name}' have no distance across z. "
                "The z axis of the gripper base has to point along the fingers."
            )
        y /= np.linalg.norm(y)
        z = np.array([0.0, 0.0, 1.0])
        inner = [extent_along(self.shapes[p], place, y[None])[:, 0] for p, place in zip(pads, places, strict=True)]
        center = 0.5 * (middles[0] + middles[1])
        center += (0.5 * (inner[0][1] + inner[1][0]) - y @ center) * y
        center[2] = min(box[1, 2] for box in boxes) - _TIP_BEHIND_END
        return pin.SE3(np.column_stack([np.cross(y, z), y, z]), center)

    def follows(self, first: UrdfJoint, second: UrdfJoint, T_base_tip: pin.SE3) -> dict[str, Follows]:
        """Return for each moving joint how it follows the drive of its side; drives follow themselves."""
        joints = {joint.name: joint for joint in self.urdf.joints}
        result = {first.name: Follows(first.name), second.name: Follows(second.name)}
        other = second.follows or Follows(second.name)
        for name, joint in joints.items():
            if joint.kind == "fixed" or name in result:
                continue
            way = way_of(name, joints, (first.name, second.name))
            if way is None:
                raise RobotModelError(f"Joint '{name}' of '{self.file.name}' moves freely. Mark it as <mimic> of '{first.name}'.")
            of_second = (T_base_tip.actInv(self.placement(joint.child, {}).translation))[1] > 0.0
            if way.joint == first.name and of_second and second.follows is not None and other.ratio != 0.0:
                share = way.ratio / other.ratio
                way = Follows(second.name, share, way.offset - share * other.offset)
            result[name] = way
        return result

    def positions(
        self, drive: str, pad: str, T_base_tip: pin.SE3, span: tuple[float, float], *, first: bool, follows: Mapping[str, Follows]
    ) -> tuple[FloatArray, FloatArray]:
        """Return values of a drive over its span, and distances of its pad from the middle [m]."""
        side = np.array([[0.0, -1.0 if first else 1.0, 0.0]])
        values = np.linspace(*span, _SAMPLES)
        positions = np.empty(_SAMPLES)
        for k, value in enumerate(values.tolist()):
            joints = {name: way.ratio * value + way.offset for name, way in follows.items() if way.joint == drive}
            placed = T_base_tip.inverse() * self.placement(pad, joints)
            positions[k] = extent_along(self.shapes[pad], placed, side)[0, 0]
        return values, positions
