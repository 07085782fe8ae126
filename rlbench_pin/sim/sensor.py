"""Volumes that detect bodies, by Coal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
import pinocchio as pin

from rlbench_pin.robot import geometry
from rlbench_pin.sim.bodies.body import Body
from rlbench_pin.sim.checks import finite_vector
from rlbench_pin.sim.frame import Frame, Places
from rlbench_pin.spatial import FloatArray, PoseLike

Shape = Literal["box", "cylinder", "sphere"]


class Sensor(Frame):
    """A box, cylinder or sphere that says which bodies reach into it; touching suffices.

    Args:
        shape: Kind of volume.
        size: box: x, y, z; cylinder: diameter, length along z; sphere: diameter [m].
        find: Looks a body up by name.
    """

    def __init__(
        self,
        name: str,
        parent: str,
        local: PoseLike,
        places: Places,
        *,
        shape: Shape,
        size: Sequence[float],
        find: Callable[[str], Body],
    ) -> None:
        super().__init__(name, parent, local, places)
        self.shape: Shape = shape
        self.size = tuple(float(s) for s in size)
        self._volume = geometry.volume(shape, self.size)
        self._reach = geometry.radius(self._volume)
        self._find = find

    def detects(self, body: str) -> bool:
        """Say whether any solid part of a body lies in the volume; a body that is only seen counts with its visuals.

        Args:
            body: Name of the body.
        """
        return volume_meets(self._volume, self._reach, self.placement(), self._find(body))

    def contains(self, point: Sequence[float] | FloatArray) -> bool:
        """Say whether a world point (3,) [m] lies in the volume."""
        x = finite_vector(point, 3, "point")
        return geometry.volume_contains(self.shape, self.size, self.placement(), np.asarray(x))


def volume_meets(volume: object, reach: float, T_world_volume: pin.SE3, body: Body) -> bool:
    """Say whether a Coal shape at a placement touches any solid part of a body.

    Args:
        volume: The shape.
        reach: Radius of a ball around its origin that holds it [m].
        T_world_volume: Its placement.
        body: What may touch it.
    """
    for index, ball, parts in body.model.solids:
        T_world_link = body.model.placement(index)
        if geometry.is_near(ball, T_world_link, T_world_volume, reach) and geometry.overlaps(
            volume, T_world_volume, parts, T_world_link
        ):
            return True
    return False
