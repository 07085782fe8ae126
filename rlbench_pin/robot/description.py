"""What an arm is, as data: files, names in a fixed order, home, and the numbers that its URDF does not say.

Everything that is true of one arm only stands here: another arm is another record.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rlbench_pin.errors import RobotModelError


@dataclass(frozen=True, kw_only=True)
class RobotDescription:
    """One arm with its gripper. Joint names stand in the order of every public joint vector."""

    name: str
    """Catalogue name, lower case."""
    urdf: Path
    """Model file with visual and collision geometry; feeds PyBullet and Pinocchio alike."""
    srdf: Path
    """Pairs of links whose collisions are ignored."""
    arm_joints: tuple[str, ...]
    """Arm joints from base to wrist."""
    gripper_joints: tuple[str, ...]
    """Finger joints; each opens with a growing value. Two in the simulation; for planning and control there may be none."""
    tip_frame: str
    """Frame between the finger pads, z out of the hand, y from the first finger to the second."""
    hand_link: str
    """Link that carries the fingers; grasped bodies are fixed to it."""
    finger_links: tuple[str, ...]
    """Links that may touch a grasped body."""
    camera_pose: tuple[float, float, float, float, float, float, float]
    """Wrist camera in the frame of `hand_link`, camera z forward, x left, y up."""
    home: tuple[float, ...]
    """Arm configuration at the start of an episode [rad]."""
    base_pose: tuple[float, float, float, float, float, float, float]
    """Pose of the base link in the world."""
    gripper_open: float
    """Finger joint value of the open hand [m]; 0 is shut."""
    gripper_force: float
    """Largest force of one finger [N]."""
    finger_speed: float
    """Finger speed of gripper actions [m/s]."""
    grip_speed: float
    """Finger speed of closing on something [m/s]: fast fingers knock light things away."""
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
