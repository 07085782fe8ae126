"""The world at one instant, as far as planning needs it: names, model files, poses, joint values."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from rlbench_pin.spatial import FloatArray

NO_FILE = Path()
"""Model file of a body that brings its own shapes."""
ROOM = ("table", "floor", "wall_front", "wall_back", "wall_left", "wall_right", "ceiling")
"""Names of the bodies that every world has, in mask order; no body of a scene may be called so."""


@dataclass(frozen=True)
class Shape:
    """A solid in the frame of its body, as plain numbers."""

    kind: Literal["box", "cylinder", "sphere", "capsule", "convex"]
    """Which solid."""
    size: tuple[float, ...]
    """box: x, y, z; cylinder, capsule: radius, length along z without caps; sphere: radius; convex: x, y, z of corners [m]."""
    pose: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    """Placement (7,) in the frame of the link."""


@dataclass(frozen=True, eq=False)
class BodySnapshot:
    """One object: its model file, or its shapes, and where each of its links is."""

    name: str
    """Name in the scene, or of a part of the room."""
    urdf: Path
    """Model file, or `NO_FILE`."""
    link_names: tuple[str, ...]
    """Links that carry collision geometry, base first."""
    link_poses: FloatArray
    """Pose of each link frame (the URDF frame, not the inertial one) in the world, shape (n, 7)."""
    scale: float = 1.0
    """Factor of all lengths of the model file."""
    collides: bool = True
    """Whether anything can touch it."""
    fixed: bool = False
    """Whether it cannot move."""
    shapes: tuple[Shape, ...] = ()
    """Shapes of the only link, instead of those of a model file."""
    in_room: bool = False
    """Whether it belongs to the room: it stays solid when touching is allowed, and is left out where the arm cannot reach."""

    @property
    def layout(self) -> tuple[object, ...]:
        """Key of the shapes without their poses: equal for bodies that differ in poses only."""
        return self.name, self.urdf, self.scale, self.link_names, self.shapes, self.in_room


@dataclass(frozen=True, eq=False)
class WorldSnapshot:
    """All bodies but the robot, the robot's configuration, and what the gripper holds."""

    bodies: tuple[BodySnapshot, ...]
    """In the order of the world: room first."""
    arm: FloatArray
    """Arm joint positions [rad], shape (n,)."""
    fingers: FloatArray
    """Finger joint positions [m]."""
    attached: tuple[str, ...] = ()
    """Names of the bodies fixed to the gripper."""

    def body(self, name: str) -> BodySnapshot:
        """Return the body called `name`."""
        return next(b for b in self.bodies if b.name == name)

    def configuration(self) -> FloatArray:
        """Return arm and finger positions as one vector."""
        return np.concatenate([self.arm, self.fingers])
