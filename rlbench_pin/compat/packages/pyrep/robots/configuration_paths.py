"""Paths in joint space, executed step by step: `step()` commands the motion, and the caller steps the simulation.

Programs import the modules `configuration_path` and `arm_configuration_path`; both are aliases of this module.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pyrep.errors import ConfigurationPathError
from pyrep.robots import Numbers
from rlbench_pin.compat import add_aliases, arm_planning
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.control.following import TrajectoryTracker
from rlbench_pin.errors import RetimingError
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray

if TYPE_CHECKING:
    from pyrep.robots.arms import Arm

ARRIVED = 2e-3
"""Maximum joint distance to the last command at which the path is complete [rad]; the next tick covers it."""
SETTLING = 10
"""Maximum number of repetitions of the last command while the arm lags behind."""


class ConfigurationPath:
    """A path that a robot follows step by step."""

    def step(self) -> bool:
        """Command the next part of the motion, and return whether it is the last."""
        raise NotImplementedError

    def set_to_start(self, disable_dynamics: bool = False) -> None:
        """Set the robot to the start of the path."""
        raise NotImplementedError

    def set_to_end(self, disable_dynamics: bool = False) -> None:
        """Set the robot to the end of the path."""
        raise NotImplementedError

    def visualize(self) -> None:
        """Draw the path."""
        raise NotImplementedError

    def clear_visualization(self) -> None:
        """Remove the drawing."""
        raise NotImplementedError


class ArmConfigurationPath(ConfigurationPath):
    """A sequence of configurations of an arm; `path[i]` is configuration i, (n,) [rad].

    To follow it, alternate `done = path.step()` and a step of the scene until `done`. Motions are timed within `max_velocity`,
    `max_acceleration` and `max_jerk` of the arm, with velocity 0 at both ends.

    Args:
        arm: The arm.
        path_points: Joint positions of all configurations in one list (m * n,) [rad].
        trajectory: Timing of the path; None computes it at the first step.
    """

    def __init__(self, arm: Arm, path_points: Numbers, trajectory: Trajectory | None = None) -> None:
        self._arm, self._num_joints = arm, arm.get_joint_count()
        self._path_points = np.array(path_points, dtype=float).reshape(-1)
        if not len(self._path_points) or len(self._path_points) % self._num_joints:
            raise ValueError(
                f"A path has {self._num_joints} numbers per configuration, in one list, not {len(self._path_points)} numbers."
            )
        self._trajectory, self._timed_points = trajectory, self._path_points
        self._tracker: TrajectoryTracker | None = None
        self._joint_position_action: FloatArray | None = None
        self._path_done, self._settling = False, 0

    def __len__(self) -> int:
        """Return the number of configurations."""
        return len(self._path_points) // self._num_joints

    def __getitem__(self, i: int | slice) -> FloatArray:
        """Return configuration `i`, shape (n,), or several, shape (m, n), [rad]."""
        return self._configurations()[i].copy()

    @property
    def trajectory(self) -> Trajectory:
        """Timing of the path; it is recomputed after a change of the points.

        Raises:
            ConfigurationPathError: No timing meets the limits of the arm.
        """
        if self._trajectory is None or self._timed_points is not self._path_points:
            try:
                self._trajectory = arm_planning.timed(Simulator.current().runtime, self._configurations(), self._arm.pace)
            except RetimingError as error:
                raise ConfigurationPathError(f"The path cannot be followed: {error}") from error
            self._timed_points = self._path_points
        return self._trajectory

    def step(self) -> bool:
        """Command the next configuration; the caller steps the simulation.

        Returns:
            Whether this was the last command: after one more simulation step the arm is at the end of the path.

        Raises:
            RuntimeError: The path has already reached its end.
            ConfigurationPathError: No timing meets the limits of the arm.
        """
        if self._path_done:
            raise RuntimeError("The path has already reached its end. Call `set_to_start()`, or plan another path.")
        if self._tracker is None:
            self._tracker = TrajectoryTracker(self.trajectory, Simulator.current().world.control_dt)
        if self._tracker.done:
            self._settling += 1
        else:
            self._joint_position_action = next(self._tracker)
        assert self._joint_position_action is not None  # a tracker has at least one command
        self._arm.set_joint_target_positions(self._joint_position_action)
        self._path_done = self._tracker.done and (self._settling >= SETTLING or self._arrives())
        return self._path_done

    def set_to_start(self, disable_dynamics: bool = False) -> None:
        """Set the arm to the first configuration with velocity 0, and restart the path."""
        self._arm.set_joint_positions(self[0], disable_dynamics)
        self._begin_again()

    def set_to_end(self, disable_dynamics: bool = False) -> None:
        """Set the arm to the last configuration with velocity 0."""
        self._arm.set_joint_positions(self[-1], disable_dynamics)

    def get_executed_joint_position_action(self) -> FloatArray | None:
        """Return the joint positions (n,) [rad] of the last command of `step`; None before the first step."""
        return None if self._joint_position_action is None else self._joint_position_action.copy()

    def visualize(self) -> None:
        """No effect: there is no window. Plot the configurations `path[:]` instead."""

    def clear_visualization(self) -> None:
        """No effect: there is no drawing."""

    def _begin_again(self) -> None:
        self._tracker = self._joint_position_action = None
        self._path_done, self._settling = False, 0

    def _configurations(self) -> FloatArray:
        """Return all configurations, shape (m, n), [rad]."""
        return np.reshape(np.asarray(self._path_points, dtype=float), (-1, self._num_joints))

    def _arrives(self) -> bool:
        """Return whether the arm reaches the last command in the next tick."""
        lag = np.asarray(self._arm.get_joint_positions()) - self._joint_position_action
        return bool(np.abs(lag).max() < ARRIVED)


add_aliases(__name__, ("configuration_path", "arm_configuration_path"))
