"""The arms of this package."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import UnknownName
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.spatial import TABLE_HEIGHT


class UnknownRobot(UnknownName, ValueError):
    """A robot name is not in the catalogue."""


def _panda() -> RobotDescription:
    """Franka Emika Panda with its parallel hand, standing on the table behind the workspace."""
    return RobotDescription(
        name="panda",
        urdf=asset_path("robots/panda/panda.urdf"),
        srdf=asset_path("robots/panda/panda.srdf"),
        arm_joints=tuple(f"panda_joint{i}" for i in range(1, 8)),
        gripper_joints=("panda_finger_joint1", "panda_finger_joint2"),
        tip_frame="panda_hand_tcp",
        hand_link="panda_hand",
        finger_links=("panda_leftfinger", "panda_rightfinger"),
        # In front of the hand, pitched 0.4 rad towards the fingers; at home the top of the picture is away from the base.
        camera_pose=(0.08, 0.0, 0.03, 0.1404802, -0.1404802, -0.6930117, 0.6930117),
        home=(0.0, 0.175, 0.0, -0.873, 0.0, 1.222, 0.785),
        base_pose=(-0.273, 0.0, TABLE_HEIGHT, 0.0, 0.0, 0.0, 1.0),
        gripper_open=0.04,
        gripper_force=40.0,
        finger_speed=0.2,
        grip_speed=0.04,
        pad_size=(0.012, 0.012),
        acceleration=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
        reach=1.6,  # 1.2 m, and what the hand holds
        linear_speed=1.7,
        angular_speed=2.5,
        loaded_joints=2,
        loaded_share=0.65,
        joint_stiffness=(600.0, 600.0, 600.0, 600.0, 250.0, 150.0, 50.0),
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


SUPPORTED_ROBOTS: Mapping[str, RobotDescription] = _Catalogue({"panda": _panda})
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
