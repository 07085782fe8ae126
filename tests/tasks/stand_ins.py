"""Small stand-ins for bodies, joints, frames, sensors, arm and gripper."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass
class FakeJoint:
    """A joint with a value."""

    position: float = 0.0


@dataclass
class FakeBody:
    """A body: a name, a pose, a colour, a box."""

    name: str = "body"
    pose: np.ndarray = field(default_factory=lambda: np.array([0.0, 0, 0, 0, 0, 0, 1]))
    color: tuple[float, ...] = (1.0, 0.0, 0.0, 1.0)
    box: tuple[float, float, float] = (0.1, 0.1, 0.1)

    @property
    def position(self) -> np.ndarray:
        """Origin."""
        return np.array(self.pose[:3])

    def bounds(self) -> np.ndarray:
        """Box around the origin."""
        half = np.array(self.box) / 2.0
        return np.stack([-half, half])

    def set_pose(self, pose: np.ndarray) -> None:
        """Move."""
        self.pose = np.array(pose, dtype=float)


@dataclass
class FakeFrame:
    """A frame; a region when it has a size."""

    name: str = "frame"
    pose: np.ndarray = field(default_factory=lambda: np.array([0.0, 0, 0, 0, 0, 0, 1]))
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def position(self) -> np.ndarray:
        """Origin."""
        return np.array(self.pose[:3])

    def set_pose(self, pose: np.ndarray) -> None:
        """Move."""
        self.pose = np.array(pose, dtype=float)

    def move_to(self, target: FakeFrame) -> None:
        """Move to another frame; only frames can."""
        self.set_pose(target.pose)


@dataclass
class FakeSensor:
    """Detects the bodies in `seen`, and points within a decimetre of the origin."""

    seen: set[str] = field(default_factory=set)

    def detects(self, name: str) -> bool:
        """Whether the body is one of them."""
        return name in self.seen

    def contains(self, point: np.ndarray) -> bool:
        """Whether the point is near the origin."""
        return bool(np.linalg.norm(point) < 0.1)


@dataclass
class FakeGripper:
    """Holds the bodies in `held`."""

    held: tuple[str, ...] = ()


@dataclass
class FakeRobot:
    """An arm whose tip is somewhere."""

    tip: np.ndarray = field(default_factory=lambda: np.array([0.0, 0, 0, 0, 0, 0, 1]))

    def tip_pose(self) -> np.ndarray:
        """Tip pose."""
        return self.tip
