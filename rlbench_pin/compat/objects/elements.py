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
    """Name in the world: `<body>`, `<body>/<link>`, `<body>/<joint>`, ..."""


class UnknownObject(UnknownName, RuntimeError):
    """No object of the scene has that name, or it does not exist any more."""


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
"""Our name -> RLBench's name."""
CAMERA_NAMES = {
    "cam_over_shoulder_left": "left_shoulder",
    "cam_over_shoulder_right": "right_shoulder",
    "cam_overhead": "overhead",
    "cam_wrist": "wrist",
    "cam_front": "front",
}
"""RLBench's name of a camera of observations -> our name."""
GRIP_SENSOR = "_gripper_attachProxSensor"
"""Suffix of the name of the sensor between the fingers."""
MASK_SUFFIX = "_mask"
"""Suffix of the name of a mask camera."""


def robot_prefix(robot: RobotDescription) -> str:
    """Return the prefix of the names of the arm, such as `Panda`."""
    return robot.name[:1].upper() + robot.name[1:]


def robot_elements(robot: RobotDescription, links: tuple[str, ...]) -> list[Element]:
    """Return arm, tip, gripper, joints and links of a robot.

    Args:
        robot: The arm.
        links: Names of its links.
    """
    prefix = robot_prefix(robot)
    joints = [f"{prefix}_joint{k + 1}" for k in range(len(robot.arm_joints))]
    fingers = [f"{prefix}_gripper_joint{k + 1}" for k in range(len(robot.gripper_joints))]
    return [
        Element("robot", prefix),
        Element("tip", f"{prefix}_tip"),
        Element("gripper", f"{prefix}_gripper"),
        *(Element("robot_joint", name) for name in (*joints, *fingers)),
        *(Element("robot_link", link) for link in links),
    ]


def camera_of(name: str) -> tuple[str, bool]:
    """Return our name of a camera of RLBench, and whether it is the mask camera."""
    is_mask = name.endswith(MASK_SUFFIX)
    return CAMERA_NAMES[name.removesuffix(MASK_SUFFIX)], is_mask


def usual_name(frame: str, frames: Mapping[str, Frame]) -> tuple[str, ...]:
    """Return the names in programs of the only sensor of a task, `success`, and its only region, `boundary`; else nothing.

    Args:
        frame: Name of a frame.
        frames: All frames of the scene.
    """
    for kind, usual in ((Sensor, "success"), (Region, "boundary")):
        if [name for name, found in frames.items() if isinstance(found, kind)] == [frame]:
            return (usual,)
    return ()
