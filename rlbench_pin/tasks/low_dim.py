"""The default low-dimensional state of a task: where its objects are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rlbench_pin.scene.model_files import resolve_asset
from rlbench_pin.spatial import FloatArray
from rlbench_pin.urdf import read_urdf

if TYPE_CHECKING:
    from rlbench_pin.sim import World


class LowDimState:
    """Reads the pose of every body of a world and the value of every joint, in the order of their names.

    The layout is fixed by the scene file; a body that was removed gives zeros.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._bodies = sorted(body.name for body in world.spec.body)
        self._joints = sorted(
            f"{body.name}/{joint}"
            for body in world.spec.body
            for joint in read_urdf(resolve_asset(world.spec, body.asset)).joint_limits
        )

    @property
    def size(self) -> int:
        """How many numbers `read` returns."""
        return 7 * len(self._bodies) + len(self._joints)

    def read(self) -> FloatArray:
        """Return poses (7 each, [m] and unit quaternion), then joint values [m] or [rad]."""
        present = self._world.bodies
        poses = [present[name].pose if name in present else np.zeros(7) for name in self._bodies]
        joints = [float(self._world.joint(name).position) if name.split("/")[0] in present else 0.0 for name in self._joints]
        return np.concatenate([*poses, joints]) if poses else np.zeros(0)
