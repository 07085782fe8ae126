"""What an arm is, as data: files, names in a fixed order, home, limits that its URDF does not say."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


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
    """Finger joints; each opens with a growing value."""
    tip_frame: str
    """Frame between the finger pads, z out of the hand."""
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
    acceleration: tuple[float, ...]
    """Acceleration limit of each arm joint [rad/s^2]."""
