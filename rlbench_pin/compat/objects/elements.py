"""Elements of a scene, and their names in RLBench."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from rlbench_pin.errors import RlbenchPinError, UnknownName
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.sim import Frame, Region, Sensor

Kind = Literal[
    "body", "link", "room", "joint", "root", "frame", "robot", "tip", "gripper", "robot_link", "robot_joint", "camera", "placed"
]
"""Kind of the part of the world that an object is."""
ObjectType = Literal["shape", "joint", "dummy", "proximity_sensor", "force_sensor", "vision_sensor", "path"]
"""Name of an object in programs."""


@dataclass(frozen=True, order=True)
class Element:
    """Identity of one object of a scene; it does not depend on name and pose."""

    kind: Kind
    name: str
    """Name in the world, for example `<body>`, `<body>/<link>` or `<body>/<joint>`."""


class UnknownObject(UnknownName, RuntimeError):
    """No object of the scene has this name or handle, or it no longer exists."""


class UnsupportedCall(RlbenchPinError, NotImplementedError):
    """A call that is not available; the message names an alternative."""

    def __init__(self, call: str, why: str, instead: str) -> None:
        self.call = call
        super().__init__(f"`{call}` is not available: {why} {instead}")


ROOM_NAMES = {
    "table": "diningTable_visible",
    "floor": "Floor",
    "ceiling": "Roof",
    "wall_front": "Wall1",
    "wall_back": "Wall2",
    "wall_left": "Wall3",
    "wall_right": "Wall4",
}
"""Our name of a part of the room -> RLBench's name."""
CAMERA_NAMES = {
    "cam_over_shoulder_left": "left_shoulder",
    "cam_over_shoulder_right": "right_shoulder",
    "cam_overhead": "overhead",
    "cam_wrist": "wrist",
    "cam_front": "front",
}
"""RLBench's name of an observation camera -> our name."""
GRIP_SENSOR = "_attachProxSensor"
"""Suffix of the name of the sensor between the fingers, after the name of the gripper."""
MASK_SUFFIX = "_mask"
"""Suffix of the name of a mask camera."""


@dataclass(frozen=True)
class RobotNames:
    """Names of the parts of an arm in programs."""

    arm: str
    """Name of the arm; its joints are `<arm>_joint1`, ..., its tip is `<arm>_tip`."""
    gripper: str
    """Name of the gripper."""
    finger: str
    """Names of the finger joints without their numbers."""

    def place(self, joint: str) -> tuple[bool, int]:
        """Return whether a joint is a finger joint, and its index in the gripper or in the arm."""
        is_finger = joint.startswith(self.finger)
        return is_finger, int(joint.removeprefix(self.finger if is_finger else f"{self.arm}_joint")) - 1


_ROBOTS = {
    "panda": RobotNames("Panda", "Panda_gripper", "Panda_gripper_joint"),
    "ur5e": RobotNames("UR5", "ROBOTIQ_85", "ROBOTIQ_85_active"),
    "jaco": RobotNames("Jaco", "JacoHand", "JacoHand_joint"),
}


def robot_names(robot: RobotDescription) -> RobotNames:
    """Return the names of the parts of an arm in programs."""
    name = robot.name.capitalize()
    return _ROBOTS.get(robot.name, RobotNames(name, f"{name}_gripper", f"{name}_gripper_joint"))


def robot_elements(robot: RobotDescription, links: tuple[str, ...]) -> list[Element]:
    """Return arm, tip, gripper, joints and links of a robot.

    Args:
        robot: The robot.
        links: Names of its links.
    """
    names = robot_names(robot)
    joints = [f"{names.arm}_joint{k + 1}" for k in range(len(robot.arm_joints))]
    fingers = [f"{names.finger}{k + 1}" for k in range(len(robot.gripper_joints))]
    return [
        Element("robot", names.arm),
        Element("tip", f"{names.arm}_tip"),
        Element("gripper", names.gripper),
        *(Element("robot_joint", name) for name in (*joints, *fingers)),
        *(Element("robot_link", link) for link in links),
    ]


def camera_of(name: str) -> tuple[str, bool]:
    """Return our name of a camera of RLBench, and whether the name is that of its mask camera."""
    is_mask = name.endswith(MASK_SUFFIX)
    return CAMERA_NAMES[name.removesuffix(MASK_SUFFIX)], is_mask


def usual_name(frame: str, frames: Mapping[str, Frame]) -> tuple[str, ...]:
    """Return the usual RLBench name of a frame: `success` for the only sensor, `boundary` for the only region, else none.

    Args:
        frame: Name of the frame.
        frames: All frames of the scene.
    """
    for kind, usual in ((Sensor, "success"), (Region, "boundary")):
        if [name for name, found in frames.items() if isinstance(found, kind)] == [frame]:
            return (usual,)
    return ()
