"""Things that exist beside the physics: dummies, cameras and paths that a program made, and the fixed ones."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from rlbench_pin.compat.things.element import Element
from rlbench_pin.compat.things.names import GRIP_SENSOR, robot_prefix
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.sim import look_at
from rlbench_pin.spatial import IDENTITY, TABLE_HEIGHT, FloatArray, relative

PlacedKind = Literal["dummy", "vision_sensor", "path", "shape", "proximity_sensor"]


@dataclass(frozen=True)
class CameraSettings:
    """What a camera sees and how it is used."""

    size: tuple[int, int] = (128, 128)
    """Width and height [px]."""
    angle: float = 60.0
    """Field of view of the longer side [deg]."""
    near: float = 0.01
    """Near plane [m]."""
    far: float = 10.0
    """Far plane [m]."""
    render_mode: str = "OPENGL3"
    """Name of a render mode."""
    explicit_handling: bool = False
    """Whether `handle_explicitly` may be called."""


@dataclass(frozen=True, eq=False)
class Placed:
    """One thing and its place."""

    kind: PlacedKind
    local: FloatArray
    """Pose (7,) in the frame of the parent."""
    parent: Element | None = None
    """None is the world."""
    camera: CameraSettings | None = None
    """Of vision sensors."""
    points: tuple[FloatArray, ...] = ()
    """Control points (7,) of paths, in the path's own frame."""
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Lengths of the box that planes and sensors stand for [m]."""
    extra: dict[str, object] = field(default_factory=dict)
    """Further settings that a program may read back."""


_TASK_KINDS = ("root", "body", "link", "joint", "frame")
_MIDDLE = np.array([0.25, 0.0, TABLE_HEIGHT, 0.0, 0.0, 0.0, 1.0])
_BASE = np.array([0.25, 0.0, TABLE_HEIGHT + 0.25, 0.0, 0.0, 0.0, 1.0])
_PLACEHOLDER = look_at((1.35, -0.95, TABLE_HEIGHT + 0.85), (0.2, 0.0, TABLE_HEIGHT + 0.2))
WORKSPACE_SIZE = (0.648, 0.91, 0.0)
"""The plane that tasks stand on; the tip may leave it by 0.2 m to each side and by 1 m upwards."""


def hangs_in_task(placed: dict[str, Placed], name: str) -> bool:
    """Whether a placed thing hangs, near or far, on something that the task brought."""
    parent = placed[name].parent
    while parent is not None and parent.kind == "placed":
        parent = placed[parent.name].parent if parent.name in placed else None
    return parent is not None and parent.kind in _TASK_KINDS


def fixed_things(robot: RobotDescription) -> dict[str, Placed]:
    """Return what stands in every scene: the workspace, where the camera of films stands and turns about, the sensor of the hand.

    Args:
        robot: The arm; the sensor looks at the space between its fingertips, half as wide as the open hand.
    """
    base, prefix = Element("placed", "cam_cinematic_base"), robot_prefix(robot)
    width, height = robot.pad_size
    return {
        "workspace": Placed("shape", _MIDDLE, size=WORKSPACE_SIZE),
        "cam_cinematic_base": Placed("dummy", _BASE),
        "cam_cinematic_placeholder": Placed("dummy", relative(_PLACEHOLDER, _BASE), parent=base),
        prefix + GRIP_SENSOR: Placed(
            "proximity_sensor", IDENTITY.copy(), Element("tip", f"{prefix}_tip"), size=(width, robot.gripper_open, height)
        ),
    }
