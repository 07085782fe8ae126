"""Descriptions of arms as data: files, names in a fixed order, home, and the numbers that are not in their URDF.

Everything that is true of one arm only stands here: another arm is another record.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import RobotModelError, UnknownName
from rlbench_pin.spatial import TABLE_HEIGHT

# In front of the gripper, pitched 0.4 rad towards the fingers; at home the top of the image is away from the base.
HAND_CAMERA = (0.08, 0.0, 0.03, 0.1404802, -0.1404802, -0.6930117, 0.6930117)
"""Wrist camera (7,) in a hand whose z points out and along whose y the fingers move."""


@dataclass(frozen=True, kw_only=True)
class RobotDescription:
    """One arm with its gripper. Joint names are in the order of every public joint vector."""

    name: str
    """Catalogue name, lower case."""
    urdf: Path
    """Model file with visual and collision geometry; feeds PyBullet and Pinocchio alike."""
    srdf: Path
    """Pairs of links whose collisions are ignored."""
    arm_joints: tuple[str, ...]
    """Arm joints from base to wrist."""
    gripper_joints: tuple[str, ...]
    """Drive joints of the fingers, first and second; for planning and control there may be none. Joints that follow them are
    marked `<mimic>` in the URDF."""
    tip_frame: str
    """Frame between the finger pads, z out of the gripper, y from the first finger to the second."""
    hand_link: str
    """Link that carries the fingers; grasped bodies are fixed to it."""
    finger_links: tuple[str, ...]
    """Links of the pads, first and second."""
    camera_pose: tuple[float, float, float, float, float, float, float]
    """Wrist camera in the frame of `hand_link`, camera z forward, x left, y up."""
    home: tuple[float, ...]
    """Arm configuration at the start of an episode [rad]."""
    base_pose: tuple[float, float, float, float, float, float, float]
    """Pose of the base link in the world."""
    gripper_open: float
    """Distance of each pad from the middle when the gripper is open [m]; 0 is shut."""
    gripper_force: float
    """Largest force of one finger [N]."""
    finger_speed: float
    """Finger speed of gripper actions [m/s]."""
    grip_speed: float
    """Finger speed of closing on something [m/s]: fast fingers knock light objects away."""
    pad_friction: float = 1.0
    """Friction coefficient of the pads; that of a contact is its product with the coefficient of the object."""
    pad_size: tuple[float, float]
    """Size of the box between the pads, along tip x and z, in which a body counts as between the fingers [m]."""
    acceleration: tuple[float, ...]
    """Acceleration limit of each arm joint [rad/s^2]."""
    reach: float
    """Nothing that the arm carries gets farther from its base than this [m]."""
    linear_speed: float
    """Largest speed of the tip that an action may ask for [m/s]."""
    angular_speed: float
    """Largest speed of turning of the tip that an action may ask for [rad/s]."""
    loaded_joints: int
    """Joints at the base that carry the arm's weight; their motors may reach a commanded velocity only after a tick."""
    loaded_share: float
    """Share of the acceleration limit of `loaded_joints` that is left while their torque holds the arm up."""
    joint_stiffness: tuple[float, ...]
    """Springs with which joint impedance control follows motions [N m/rad]: softer than the motors' position control."""

    def __post_init__(self) -> None:
        """Refuse vectors that have not one number per arm joint."""
        for name in ("home", "acceleration", "joint_stiffness"):
            count = len(getattr(self, name))
            if count != len(self.arm_joints):
                raise RobotModelError(f"'{self.name}' has {len(self.arm_joints)} arm joints, but {count} numbers in '{name}'.")


class UnknownRobot(UnknownName, ValueError):
    """A robot name is not in the catalogue."""


def _panda() -> RobotDescription:
    """Franka Emika Panda with its parallel gripper, standing on the table behind the workspace."""
    return RobotDescription(
        name="panda",
        urdf=asset_path("robots/panda/panda.urdf"),
        srdf=asset_path("robots/panda/panda.srdf"),
        arm_joints=tuple(f"panda_joint{i}" for i in range(1, 8)),
        gripper_joints=("panda_finger_joint1", "panda_finger_joint2"),
        tip_frame="panda_hand_tcp",
        hand_link="panda_hand",
        finger_links=("panda_leftfinger", "panda_rightfinger"),
        camera_pose=HAND_CAMERA,
        home=(0.0, 0.175, 0.0, -0.873, 0.0, 1.222, 0.785),
        base_pose=(-0.273, 0.0, TABLE_HEIGHT, 0.0, 0.0, 0.0, 1.0),
        gripper_open=0.04,
        gripper_force=40.0,
        finger_speed=0.2,
        grip_speed=0.04,
        pad_size=(0.012, 0.012),
        acceleration=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
        reach=1.6,  # 1.2 m, and what the gripper holds
        linear_speed=1.7,
        angular_speed=2.5,
        loaded_joints=2,
        loaded_share=0.65,
        joint_stiffness=(600.0, 600.0, 600.0, 600.0, 250.0, 150.0, 50.0),
    )


def _with_our_gripper(name: str, arm_joints: tuple[str, ...], **numbers: Any) -> RobotDescription:
    """An arm whose model has no gripper of its own: it carries a parallel gripper with the measures of the Panda's."""
    return replace(
        _panda(),
        name=name,
        urdf=asset_path(f"robots/{name}/{name}.urdf"),
        srdf=asset_path(f"robots/{name}/{name}.srdf"),
        arm_joints=arm_joints,
        gripper_joints=(f"{name}_finger_joint1", f"{name}_finger_joint2"),
        tip_frame=f"{name}_tip",
        hand_link=f"{name}_hand",
        finger_links=(f"{name}_leftfinger", f"{name}_rightfinger"),
        camera_pose=HAND_CAMERA,
        **numbers,
    )


def _ur5e() -> RobotDescription:
    """Universal Robots UR5e with a Robotiq 2F-85; limits of its data sheet, acceleration as its drives reach with 5 kg.

    The pads are of silicone rubber. MuJoCo Menagerie's model of the 2F-85 has a friction of 0.7 at their ends, where objects are
    gripped, and 0.6 behind; the maker's manuals calculate with 0.3 for silicone on steel with cutting oil.
    """
    joints = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    return replace(
        _panda(),
        name="ur5e",
        urdf=asset_path("robots/ur5e/ur5e.urdf"),
        srdf=asset_path("robots/ur5e/ur5e.srdf"),
        arm_joints=tuple(f"ur5e_{joint}_joint" for joint in joints),
        gripper_joints=("ur5e_finger_joint", "ur5e_right_outer_knuckle_joint"),
        tip_frame="ur5e_tip",
        hand_link="ur5e_hand",
        finger_links=("ur5e_left_inner_finger", "ur5e_right_inner_finger"),
        camera_pose=HAND_CAMERA,
        home=(-0.274, -1.565, 1.245, -1.251, -1.571, -0.274),
        gripper_open=0.042,
        gripper_force=60.0,
        pad_friction=0.7,
        pad_size=(0.014, 0.014),
        acceleration=(10.0, 10.0, 12.0, 15.0, 15.0, 15.0),
        joint_stiffness=(600.0, 600.0, 600.0, 250.0, 150.0, 50.0),
    )


def _xarm7() -> RobotDescription:
    """UFACTORY xArm7; the maker allows 20 rad/s^2."""
    return _with_our_gripper(
        "xarm7",
        tuple(f"xarm7_joint{i}" for i in range(1, 8)),
        home=(0.0, 0.09, 0.0, 1.711, 0.0, 1.62, 0.0),
        acceleration=(10.0, 10.0, 12.0, 12.0, 15.0, 15.0, 20.0),
    )


def _iiwa() -> RobotDescription:
    """KUKA LBR iiwa 7 R800."""
    return _with_our_gripper(
        "iiwa",
        tuple(f"iiwa_joint_{i}" for i in range(1, 8)),
        home=(0.0, 0.243, 0.0, -1.455, 0.0, 1.443, 0.0),
        acceleration=(10.0, 7.5, 10.0, 10.0, 15.0, 20.0, 20.0),
    )


def _jaco() -> RobotDescription:
    """Kinova Jaco j2s6s200, a slow arm of six joints."""
    return _with_our_gripper(
        "jaco",
        tuple(f"jaco_joint_{i}" for i in range(1, 7)),
        home=(0.02, 3.607, 2.149, 3.142, 1.457, -3.122),
        acceleration=(4.0, 4.0, 4.0, 6.0, 6.0, 6.0),
        joint_stiffness=(600.0, 600.0, 600.0, 250.0, 150.0, 50.0),
    )


class _Catalogue(Mapping[str, RobotDescription]):
    """Names of arms -> descriptions, each built when first asked for."""

    def __init__(self, builders: Mapping[str, Callable[[], RobotDescription]]) -> None:
        self._builders = dict(builders)
        self._built: dict[str, RobotDescription] = {}

    def __getitem__(self, name: str) -> RobotDescription:
        if name not in self._built:
            self._built[name] = self._builders[name]()
        return self._built[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._builders)

    def __len__(self) -> int:
        return len(self._builders)


_ARMS = {"panda": _panda, "ur5e": _ur5e, "xarm7": _xarm7, "iiwa": _iiwa, "jaco": _jaco}
SUPPORTED_ROBOTS: Mapping[str, RobotDescription] = _Catalogue(_ARMS)
DEFAULT_ROBOT = "panda"
"""The arm where none is named."""


def robot_description(name: str) -> RobotDescription:
    """Return the description of an arm; case does not matter.

    Raises:
        UnknownRobot: The catalogue has no such arm; a ValueError as well.
    """
    key = name.lower() if isinstance(name, str) else ""
    if key not in SUPPORTED_ROBOTS:
        raise UnknownRobot("robot", name, tuple(SUPPORTED_ROBOTS))
    return SUPPORTED_ROBOTS[key]
