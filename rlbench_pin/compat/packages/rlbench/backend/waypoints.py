"""Waypoints of demonstrations with the API of RLBench, and paths to them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from pyrep.errors import ConfigurationPathError
from pyrep.objects.cartesian_path import CartesianPath
from pyrep.objects.object import Object
from pyrep.robots.configuration_paths import ArmConfigurationPath
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment.waypoint_planning import WaypointPlanner, grasp_groups, rotated
from rlbench_pin.errors import PlanningError, WaypointError
from rlbench_pin.tasks import Task as NativeTask
from rlbench_pin.tasks import Waypoint as NativeWaypoint

if TYPE_CHECKING:
    from rlbench.backend.robot import Robot

WaypointFunction = Callable[["Waypoint"], Any]


class Waypoint:
    """One waypoint of a demonstration. `waypoint_of` creates one from a waypoint of a scene.

    Args:
        waypoint: Object at the pose of the waypoint.
        robot: Arm and gripper.
        ignore_collisions: Plan without collision checks.
        start_of_path_func: Function that is called with the waypoint before its path is planned.
        end_of_path_func: Function that is called with the waypoint after its path was executed.
        native: The waypoint of the scene; its settings take precedence.
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
        """Whether the waypoint is left out; a start function may set it. Each episode starts with False."""
        return self._skip if self.native is None else self.native.skip

    @skip.setter
    def skip(self, skip: bool) -> None:
        self._skip = bool(skip)
        if self.native is not None:
            self.native.skip = bool(skip)

    def get_path(self, ignore_collisions: bool = False) -> ArmConfigurationPath:
        """Return a path of the arm from its current configuration to the waypoint, planned as in demonstrations.

        With grasp symmetry, the gripper gets a rotation with which the arm can also reach the following waypoints.

        Args:
            ignore_collisions: Plan without collision checks, even if the waypoint requires them.

        Raises:
            ConfigurationPathError: There is no path.
        """
        native = self.native
        if native is None:
            return self._asked_path(ignore_collisions or self._ignore_collisions)
        runtime = Simulator.current().runtime
        run, planner = _rest_of_run(native, runtime.task), WaypointPlanner(runtime)
        try:
            turns = planner.rank(run)
            if ignore_collisions and not self._ignore_collisions and native.path != "curve":
                return self._asked_path(True, turns[0])
            plan = planner.plan(native, run[1:], turns)
        except (PlanningError, WaypointError) as error:
            raise ConfigurationPathError(f"There is no path to {self.name}: {error}") from error
        return ArmConfigurationPath(self._robot.arm, plan.path.flatten())

    def _asked_path(self, ignore_collisions: bool, turn: float = 0.0) -> ArmConfigurationPath:
        """Return a path of the arm to the object of the waypoint, with the gripper rotated by `turn` [rad] about its z-axis."""
        raise NotImplementedError(f"{type(self).__name__} must define get_path(self, ignore_collisions).")

    def get_ext(self) -> str:
        """Return the extension string: `ignore_collision`, `linear`, `open_gripper(x)`, `close_gripper(x)`."""
        return self._ext

    def get_waypoint_object(self) -> Object:
        """Return the object at the pose of the waypoint."""
        return self._waypoint

    def remove(self) -> None:
        """Remove the object at the pose of the waypoint."""
        self._waypoint.remove()

    def start_of_path(self) -> None:
        """Call the function that was registered for the start of the path."""
        if self.native is not None:
            self.native.run_start_hook()
        elif self._start is not None:
            self._start(self)

    def end_of_path(self) -> None:
        """Call the function that was registered for the end of the path."""
        if self.native is not None:
            self.native.run_end_hook()
        elif self._end is not None:
            self._end(self)


class Point(Waypoint):
    """One pose of the tip."""

    def _asked_path(self, ignore_collisions: bool, turn: float = 0.0) -> ArmConfigurationPath:
        arm, pose = self._robot.arm, rotated(np.asarray(self._waypoint.get_pose(), dtype=float), turn)
        if self._linear_only:
            return arm.get_linear_path(pose[:3], quaternion=pose[3:], ignore_collisions=ignore_collisions)
        return arm.get_path(pose[:3], quaternion=pose[3:], ignore_collisions=ignore_collisions)


class PredefinedPath(Waypoint):
    """A curve that the tip follows, without collision checks."""

    def _asked_path(self, ignore_collisions: bool, turn: float = 0.0) -> ArmConfigurationPath:
        return self._robot.arm.get_path_from_cartesian_path(cast("CartesianPath", self._waypoint))


def waypoint_of(native: NativeWaypoint, robot: Robot) -> Waypoint:
    """Return a waypoint of a scene as a waypoint of RLBench."""
    kind = PredefinedPath if native.path == "curve" else Point
    return kind(Object.get_object(native.frame.name), robot, native=native)


def _extension(waypoint: Object, native: NativeWaypoint | None) -> str:
    """Return the extension string of a waypoint; a partial opening that does not release objects is `close_gripper`."""
    text = str(waypoint.get_extension_string())
    closes = native is not None and isinstance(native.gripper, float) and not native.releases
    return text.replace("open_gripper(", "close_gripper(") if closes else text


def _rest_of_run(native: NativeWaypoint, task: NativeTask) -> list[NativeWaypoint]:
    """Return a waypoint and the following waypoints of its group with the same grasp symmetry."""
    for run in grasp_groups([w for w in task.get_waypoints() if w is native or not w.skip]):
        if native in run:
            return run[run.index(native) :]
    return [native]
