"""The default low-dimensional state of a task: where its objects are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from rlbench_pin.scene.reader import resolve_asset
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.spatial import FloatArray
from rlbench_pin.urdf import read_urdf

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, World


@dataclass(frozen=True)
class LowDimPart:
    """Some of the numbers of a state."""

    name: str
    """`<body>`, or `<body>/<joint>`."""
    kind: Literal["pose", "slider", "hinge"]
    """Pose of a body (7 numbers, [m] and unit quaternion), or value of a joint that slides [m] or turns [rad]."""

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return 7 if self.kind == "pose" else 1


def low_dim_layout(spec: SceneSpec) -> tuple[LowDimPart, ...]:
    """Return what the default state of a scene holds, in order: the bodies by name, then their movable joints by name."""
    bodies = sorted(body.name for body in spec.body)
    joints = sorted(
        (f"{body.name}/{joint.name}", joint.kind)
        for body in spec.body
        for joint in read_urdf(resolve_asset(spec, body.asset)).joints
        if joint.kind != "fixed"
    )
    poses = [LowDimPart(name, "pose") for name in bodies]
    return (*poses, *(LowDimPart(name, "slider" if kind == "prismatic" else "hinge") for name, kind in joints))


class LowDimState:
    """Reads the pose of every body of a world and the value of every joint, in the order of their names.

    The layout is fixed by the scene file: a body that was removed gives zeros, one that an episode adds is left out.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._layout = low_dim_layout(world.spec)

    def read(self) -> FloatArray:
        """Return poses (7 each, [m] and unit quaternion), then joint values [m] or [rad]."""
        present = self._world.bodies
        parts = [self._value(part, present.get(part.name.split("/")[0])) for part in self._layout]
        return np.concatenate(parts) if parts else np.zeros(0)

    def _value(self, part: LowDimPart, body: Body | None) -> FloatArray:
        if body is None:
            return np.zeros(part.size)
        return body.pose if part.kind == "pose" else np.array([float(self._world.joint(part.name).position)])
