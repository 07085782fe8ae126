"""A body visits points in order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

import numpy as np

from rlbench_pin.spatial import FloatArray, pose_to_se3
from rlbench_pin.tasks.conditions.condition import Condition
from rlbench_pin.tasks.conditions.parts import Placed, Posed, as_part
from rlbench_pin.values import as_flag, as_number, as_rows

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, Frame

MAX_STRIKES = 3


class FollowPath(Condition):
    """Holds once a body has visited all points in order, coming within half of `tolerance` of each.

    An evaluation that finds the body farther than `tolerance` from the point it looks at first is a strike, once the
    path has been started. A visited point clears the strikes. Past `MAX_STRIKES` a further miss sets `lost`.

    Args:
        body: What has to travel.
        points: Way points, shape (n, 3), [m], in the coordinates of `frame`.
        frame: Frame of the points; None is the world.
        tolerance: Distance of a miss [m].
        start_after_first: No strikes before the first point was visited.
    """

    def __init__(
        self,
        body: Body,
        points: Sequence[Sequence[float]] | FloatArray,
        frame: Frame | None = None,
        tolerance: float = 0.01,
        start_after_first: bool = True,
    ) -> None:
        self.body = as_part(body, Placed, "body", "a body, such as `self.world.body(name)`")
        self.frame = None if frame is None else as_part(frame, Posed, "frame", "a frame, or None for the world")
        self.points = np.array(as_rows(points, 3, "points"))
        self.tolerance = as_number(tolerance, "tolerance [m]", above=0.0)
        self.start_after_first = as_flag(start_after_first, "start_after_first")
        self.index, self.strikes, self.lost = 0, 0, False

    def met(self) -> bool:
        """Advance over the points that the body is at now, and return whether all were visited."""
        first = True
        while self.index < len(self.points):
            distance = self._distance()
            if distance > self.tolerance / 2.0:
                if distance > self.tolerance and first:
                    self._miss()
                return False
            self.index, self.strikes, first = self.index + 1, 0, False
        return True

    def _miss(self) -> None:
        if self.index == 0 and self.start_after_first:
            return
        self.lost = self.strikes > MAX_STRIKES
        self.strikes += 1

    def _distance(self) -> float:
        point = self.points[self.index]
        if self.frame is not None:
            point = pose_to_se3(self.frame.pose).act(point)
        return float(np.linalg.norm(self.body.position - point))

    def reset(self) -> None:
        """Begin with the first point again, without strikes."""
        self.index, self.strikes, self.lost = 0, 0, False

    def state(self) -> tuple[int, int, bool]:
        """Return the number of points visited, the strikes, and whether the path was lost."""
        return self.index, self.strikes, self.lost

    def set_state(self, state: object) -> None:
        """Set the number of points visited, the strikes, and whether the path was lost."""
        self.index, self.strikes, self.lost = cast(tuple[int, int, bool], state)
