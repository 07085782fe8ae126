"""Waypoints: the poses that the gripper tip visits in a demonstration, with hooks and gripper actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

import numpy as np

from rlbench_pin.scene.spec import WaypointSpec
from rlbench_pin.spatial import FloatArray, compose, swept

if TYPE_CHECKING:
    from rlbench_pin.sim import Frame, World

ARC_STEP = 0.1
"""Angle between two poses of a sweep [rad]."""

WaypointHook = Callable[["Waypoint"], None]


class Waypoint:
    """One waypoint of a demonstration.

    Args:
        index: Index of the waypoint.
        frame: Frame of its pose; follows its parent.
        spec: Its entry in the scene file.
        amount_before: Opening fraction of the gripper after the previous waypoints.

    Attributes:
        skip: Omit this waypoint; a start hook may set it. Reset to False in each episode.
        gripper_amount: Opening fraction of the gripper after this waypoint.
    """

    def __init__(self, index: int, frame: Frame, spec: WaypointSpec, amount_before: float = 1.0) -> None:
        self.index, self.frame, self.spec = index, frame, spec
        self.skip = False
        self.gripper_amount = _amount(spec.gripper, amount_before)
        self._opens = self.gripper_amount > amount_before
        self._start: WaypointHook | None = None
        self._end: WaypointHook | None = None

    @property
    def pose(self) -> FloatArray:
        """Present tip pose in the world, shape (7,); for a curve of points, the last point."""
        if self.spec.points:
            return compose(self.frame.pose, self.spec.points[-1])
        return np.array(self.frame.pose)

    @property
    def path(self) -> Literal["plan", "straight", "curve"]:
        """Kind of path to the waypoint; compliant approaches are straight."""
        return "straight" if self.compliant else self.spec.path

    @property
    def compliant(self) -> bool:
        """Whether to approach slowly and yield to contact."""
        return self.spec.compliant

    @property
    def ignore_collisions(self) -> bool:
        """Whether to plan without collision checks; always true for curves and compliant approaches."""
        return self.spec.ignore_collisions or self.compliant or self.spec.path == "curve"

    @property
    def gripper(self) -> Literal["open", "close"] | float | None:
        """Action of the gripper on arrival; None for no action."""
        return self.spec.gripper

    @property
    def releases(self) -> bool:
        """Whether the gripper opens on arrival and releases held bodies."""
        if isinstance(self.spec.gripper, float):
            return self._opens
        return self.spec.gripper == "open"

    @property
    def lets_go(self) -> bool:
        """Whether the gripper, closed by the waypoints before, opens on arrival."""
        return self.releases and self._opens

    @property
    def symmetry(self) -> int:
        """Rotational symmetry of the grasp: the gripper may be rotated about its z axis by multiples of 2 pi / symmetry."""
        return self.spec.symmetry

    def curve_poses(self, previous: FloatArray) -> list[FloatArray]:
        """Return the tip poses (7,) of a curve, in the world.

        Args:
            previous: Tip pose at the start of the curve, shape (7,); an arc rotates it, points do not use it.
        """
        if self.spec.arc is None:
            return [compose(self.frame.pose, point) for point in self.spec.points]
        arc = self.spec.arc
        count = max(2, int(np.ceil(abs(arc.angle) / ARC_STEP)))
        angles = arc.angle * np.arange(1, count + 1) / count
        return swept(previous, self.frame.pose, arc.axis, angles, twist=arc.twist)

    def set_hooks(self, start: WaypointHook | None, end: WaypointHook | None) -> None:
        """Set the functions that run before the segment is planned and after it has ended."""
        self._start, self._end = start, end

    def state(self) -> bool:
        """Return the state that changes during an episode: whether the waypoint is omitted."""
        return self.skip

    def set_state(self, state: bool) -> None:
        """Restore a state that `state()` returned."""
        self.skip = state

    def run_start_hook(self) -> None:
        """Call the start hook, if there is one."""
        if self._start is not None:
            self._start(self)

    def run_end_hook(self) -> None:
        """Call the end hook, if there is one."""
        if self._end is not None:
            self._end(self)


def waypoints_of(world: World) -> list[Waypoint]:
    """Return the waypoints of a world in the order of their indices."""
    specs = sorted(world.spec.waypoint, key=lambda spec: int(spec.name.removeprefix("waypoint")))
    result: list[Waypoint] = []
    for index, spec in enumerate(specs):
        before = result[-1].gripper_amount if result else 1.0
        result.append(Waypoint(index, world.frame(spec.name), spec, before))
    return result


def _amount(gripper: Literal["open", "close"] | float | None, before: float) -> float:
    if gripper is None:
        return before
    if isinstance(gripper, float):
        return gripper
    return 1.0 if gripper == "open" else 0.0
