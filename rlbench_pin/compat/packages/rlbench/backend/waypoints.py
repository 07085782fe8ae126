"""Waypoints under their known names: what the tip visits in a demonstration, and paths to it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from pyrep.errors import ConfigurationPathError
from pyrep.objects.dummy import Dummy
from pyrep.objects.object import Object
from pyrep.robots.configuration_paths.arm_configuration_path import ArmConfigurationPath
from rlbench_pin.compat.arm_planning import plan_along
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment.turns import poses_of, turned
from rlbench_pin.errors import PlanningError
from rlbench_pin.tasks import Waypoint as NativeWaypoint

if TYPE_CHECKING:
    from rlbench.backend.robot import Robot

WaypointFunction = Callable[["Waypoint"], Any]
SAMPLED = {"trials": 100, "max_configs": 10, "trials_per_goal": 10}
"""Settings of the search for a path."""


class Waypoint:
    """One stop of a demonstration. `waypoint_of` makes one from a waypoint of a scene.

    Args:
        waypoint: Object that marks the place.
        robot: Arm and hand.
        ignore_collisions: Plan without looking at collisions.
        start_of_path_func: Called with the waypoint before its path is planned.
        end_of_path_func: Called with the waypoint when it was reached.
        native: The waypoint of the scene; what it says holds then.
    """

    def __init__(
        self,
        waypoint: Object,
        robot: Robot,
        ignore_collisions: bool = False,
        start_of_path_func: WaypointFunction | None = None,
        end_of_path_func: WaypointFunction | None = None,
        native: NativeWaypoint | None = None,
    ) -> None:
        self._waypoint, self._robot, self.native = waypoint, robot, native
        self._start, self._end, self._skip = start_of_path_func, end_of_path_func, False
        self.name = waypoint.get_name()
        self._ext = _extension(waypoint, native)
        self._ignore_collisions = ignore_collisions or "ignore_collision" in self._ext
        self._linear_only = "linear" in self._ext

    @property
    def skip(self) -> bool:
        """Whether the waypoint is left out; a start function may set it. False again in every episode."""
        return self._skip if self.native is None else self.native.skip

    @skip.setter
    def skip(self, skip: bool) -> None:
        self._skip = bool(skip)
        if self.native is not None:
            self.native.skip = bool(skip)

    def get_path(self, ignore_collisions: bool = False) -> ArmConfigurationPath:
        """Return a path of the arm from where it is to the waypoint.

        Raises:
            ConfigurationPathError: There is none.
        """
        raise NotImplementedError(f"{type(self).__name__} must define get_path(self, ignore_collisions).")

    def get_ext(self) -> str:
        """Return what happens besides: `ignore_collision`, `linear`, `open_gripper(x)`, `close_gripper(x)`."""
        return self._ext

    def get_waypoint_object(self) -> Object:
        """Return the object that marks the place."""
        return self._waypoint

    def remove(self) -> None:
        """Remove the object that marks the place."""
        self._waypoint.remove()

    def start_of_path(self) -> None:
        """Run what was registered for the start of the path."""
        if self.native is not None:
            self.native.run_start_hook()
        elif self._start is not None:
            self._start(self)

    def end_of_path(self) -> None:
        """Run what was registered for the end of the path."""
        if self.native is not None:
            self.native.run_end_hook()
        elif self._end is not None:
            self._end(self)


class Point(Waypoint):
    """One pose of the tip."""

    def get_path(self, ignore_collisions: bool = False) -> ArmConfigurationPath:
        """Return a path to the pose; a hand that may arrive turned tries the turns one after the other.

        Raises:
            ConfigurationPathError: There is none.
        """
        arm, ignore = self._robot.arm, ignore_collisions or self._ignore_collisions
        poses = [np.asarray(self._waypoint.get_pose(), dtype=float)]
        symmetry = 1 if self.native is None else self.native.symmetry
        poses += [turned(poses[0], 2.0 * np.pi * k / symmetry) for k in range(1, symmetry)]
        first: Exception | None = None
        for pose in poses:
            try:
                if self._linear_only:
                    return arm.get_linear_path(pose[:3], quaternion=pose[3:], ignore_collisions=ignore)
                return arm.get_path(pose[:3], quaternion=pose[3:], ignore_collisions=ignore, **SAMPLED)
            except ConfigurationPathError as error:
                first = first or error
        assert first is not None
        raise first


class PredefinedPath(Waypoint):
    """A curve that the tip follows."""

    def get_path(self, ignore_collisions: bool = False) -> ArmConfigurationPath:
        """Return a path along the curve; it never looks at collisions.

        Raises:
            ConfigurationPathError: The arm cannot follow the curve.
        """
        if self.native is None:
            return self._robot.arm.get_path_from_cartesian_path(self._waypoint)
        runtime = Simulator.current().runtime
        first: PlanningError | None = None
        for k in range(self.native.symmetry):
            poses = poses_of(self.native, 2.0 * np.pi * k / self.native.symmetry, runtime.robot.tip_pose())
            try:
                return ArmConfigurationPath(self._robot.arm, plan_along(runtime, poses).path.flatten())
            except PlanningError as error:
                first = first or error
        raise ConfigurationPathError(f"The arm cannot follow the curve of {self.name}: {first}") from first


def waypoint_of(native: NativeWaypoint, robot: Robot) -> Waypoint:
    """Return a waypoint of a scene under its known name."""
    kind = PredefinedPath if native.path == "curve" else Point
    return kind(Dummy(native.frame.name), robot, native=native)


def _extension(waypoint: Object, native: NativeWaypoint | None) -> str:
    """Return the words of a waypoint; opening to a fraction from further open is called closing."""
    text = str(waypoint.get_extension_string())
    closes = native is not None and isinstance(native.gripper, float) and not native.releases
    return text.replace("open_gripper(", "close_gripper(") if closes else text
