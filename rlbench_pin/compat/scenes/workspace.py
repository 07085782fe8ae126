"""The plane on the table where tasks are placed, as a boundary that programs may change."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from pyrep.objects.object import Object
from pyrep.objects.shape import Shape
from rlbench.backend.spawn_boundary import BoundaryObject, BoundingBox, SpawnBoundary
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.compat.tasks.tree import patch_of
from rlbench_pin.spatial import FloatArray


class WorkspaceArea(BoundaryObject):
    """The plane itself. Of a thing that is placed, only its footprint has to fit.

    Places are drawn just as the native placement draws them, so one seed gives one place with both.

    Attributes:
        rng: What places are drawn from; None is numpy's global generator.
    """

    rng: np.random.Generator | None = None

    def _box(self, obj: Object) -> BoundingBox:
        low, high = patch_of(Simulator.current().runtime.world, obj.element)
        return BoundingBox(float(low[0]), float(high[0]), float(low[1]), float(high[1]), 0.0, 0.0)

    def draw(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return numbers (n,), each drawn between its bounds from `rng`."""
        return super().draw(low, high) if self.rng is None else self.rng.uniform(low, high)

    def _get_position_within_boundary(self, obj: Object, obj_bbox: BoundingBox) -> list[float]:
        """Draw a place for an object, [x, y, z] in the frame of the plane [m]; the middle when it does not fit."""
        low = (self._boundary_bbox.corners[0] - obj_bbox.corners[0])[:2]
        high = (self._boundary_bbox.corners[1] - obj_bbox.corners[1])[:2]
        x, y = self.draw(low, high) if np.all(low <= high) else (low + high) / 2.0
        return [float(x), float(y), float(obj.get_position(relative_to=self._boundary)[2])]


class Workspace(SpawnBoundary):
    """The boundary that every placement of a task goes through.

    Args:
        plane: The workspace of the scene.
    """

    def __init__(self, plane: Shape) -> None:
        super().__init__([plane])
        self._area = WorkspaceArea(plane)
        self._boundaries = [self._area]

    def _choose(self) -> BoundaryObject:
        return self._boundaries[0]

    @contextmanager
    def drawing_from(self, rng: np.random.Generator | None) -> Iterator[None]:
        """Draw from `rng` meanwhile; None is numpy's global generator."""
        before, self._area.rng = self._area.rng, rng
        try:
            yield
        finally:
            self._area.rng = before
