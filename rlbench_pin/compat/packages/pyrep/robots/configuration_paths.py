"""Paths of configurations, played step by step: `step()` commands the motion, and the caller steps the simulation.

Programs import `configuration_path` and `arm_configuration_path` of this name; both are aliases of this module.
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
"""Distance of a joint from the end of the path that the coming tick covers [rad]."""
SETTLING = 10
"""Maximum number of repetitions of the last command for an arm that lags."""


class ConfigurationPath:
    """A path that a robot follows step by step."""

    def step(self) -> bool:
        """Command the next part of the motion; True when it is the last."""
        raise NotImplementedError

    def set_to_start(self, disable_dynamics: bool = False) -> None:
        """Put the robot at the beginning of the path."""
        raise NotImplementedError

    def set_to_end(self, disable_dynamics: bool = False) -> None:
        """Put the robot at the end of the path."""
        raise NotImplementedError

    def visualize(self) -> None:
        """Draw the path."""
        raise NotImplementedError

    def clear_visualization(self) -> None:
        """Remove the drawing."""
        raise NotImplementedError


class ArmConfigurationPath(ConfigurationPath):
    """Configurations of an arm, one after the other; `path[i]` is one of them, (n,) [rad].

    Follow it by `done = path.step()` and a step of the scene in turn, until `done`. Motions are timed within the arm's
    `max_velocity`, `max_acceleration` and `max_jerk`, and at rest at both ends.

    Args:
        arm: The arm that follows it.
        path_points: Joint positions of one configuration after the other, in one list (m * n,), [rad].
        trajectory: Their timing; None computes it at the first step.
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
        """Timing of the path; computed again after points were replaced.

        Raises:
            ConfigurationPathError: No timing keeps the limits of the arm.
        """
        if self._trajectory is None or self._timed_points is not self._path_points:
            try:
                self._trajectory = arm_planning.timed(Simulator.current().runtime, self._configurations(), self._arm.pace)
            except RetimingError as error:
                raise ConfigurationPathError(f"The path cannot be followed: {error}") from error
            self._timed_points = self._path_points
        return self._trajectory

    def step(self) -> bool:
        """Command the next configuration; the simulation is stepped by the caller.

        Returns:
            Whether this was the last command: after one more step of the simulation the arm is at the end of the path.

        Raises:
            RuntimeError: The path is done already.
            ConfigurationPathError: No timing keeps the limits of the arm.
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
        """Put the arm at the first configuration, at rest, so that the path can be followed (again)."""
        self._arm.set_joint_positions(self[0], disable_dynamics)
        self._begin_again()

    def set_to_end(self, disable_dynamics: bool = False) -> None:
        """Put the arm at the last configuration, at rest."""
        self._arm.set_joint_positions(self[-1], disable_dynamics)

    def get_executed_joint_position_action(self) -> FloatArray | None:
        """Return the joint positions (n,) [rad] that `step` commanded last; None before the first step."""
        return None if self._joint_position_action is None else self._joint_position_action.copy()

    def visualize(self) -> None:
        """No effect: there is no window. `path[:]` returns the configurations, for your own plot."""

    def clear_visualization(self) -> None:
        """No effect, because nothing is drawn."""

    def _begin_again(self) -> None:
        self._tracker = self._joint_position_action = None
        self._path_done, self._settling = False, 0

    def _configurations(self) -> FloatArray:
        return np.reshape(np.asarray(self._path_points, dtype=float), (-1, self._num_joints))

    def _arrives(self) -> bool:
        """Whether the coming tick brings the arm to the last command."""
        lag = np.asarray(self._arm.get_joint_positions()) - self._joint_position_action
        return bool(np.abs(lag).max() < ARRIVED)


add_aliases(__name__, ("configuration_path", "arm_configuration_path"))
