"""Parts of RLBench's action modes: frames, poses, planned motions, and base classes of arm and gripper modes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pyrep.errors import ConfigurationPathError
from pyrep.robots.arms import Panda
from pyrep.robots.configuration_paths import ArmConfigurationPath, ConfigurationPath
from rlbench_pin.compat.simulator import SceneLike, runtime_of
from rlbench_pin.environment.actions import RelativeFrame as NativeFrame
from rlbench_pin.environment.actions import calculate_delta_pose as native_delta_pose
from rlbench_pin.environment.actions.modes import Mode, as_action
from rlbench_pin.environment.runtime import Runtime, follow
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import FloatArray, compose

Action = Sequence[float] | FloatArray
OnStep = Callable[[Observation], object]
_WORDS = ("world", "end effector")


class RelativeFrame(IntEnum):
    """Frame of a Cartesian action; each value is also equal to the string that older programs use."""

    WORLD = 0
    EE = 1

    def __eq__(self, other: object) -> bool:
        return other == _WORDS[self.value] if isinstance(other, str) else int(self) == other

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return hash(int(self))


def assert_action_shape(action: ArrayLike, expected_shape: tuple[int, ...]) -> None:
    """Raise InvalidActionError when an action does not have the expected shape."""
    shape = np.shape(action)
    if shape != tuple(expected_shape):
        raise InvalidActionError(f"The action has shape {shape}; it has to be {tuple(expected_shape)}.")


def calculate_delta_pose(robot: Any, action: Sequence[float] | FloatArray) -> FloatArray:
    """Apply a delta in world axes to the tip pose: add the position, multiply the rotation from the left.

    Args:
        robot: The robot.
        action: Delta pose (7,): x, y, z [m], qx, qy, qz, qw.

    Returns:
        The new pose (7,) in the world.
    """
    return native_delta_pose(tip_pose(robot), np.asarray(action, dtype=float), NativeFrame.WORLD)


def pose_in_end_effector_frame(robot: Any, action: Sequence[float] | FloatArray) -> FloatArray:
    """Return the world pose (7,) of a pose that is given in the frame of the tip."""
    return compose(tip_pose(robot), np.asarray(action, dtype=float))


def tip_pose(robot: Any) -> FloatArray:
    """Return the pose (7,) of the tip in the world."""
    return np.asarray(robot.arm.get_tip().get_pose(), dtype=float)


class UserMode:
    """Base of action modes of users; each method that a user does not write raises an error with its name."""

    def action(self, scene: SceneLike, action: Action) -> None:
        """Execute one action to its end."""
        raise self._missing("action(scene, action)")

    def action_pre_step(self, scene: SceneLike, action: Action) -> None:
        """Command the motors, before the simulation is stepped."""
        raise self._missing("action_pre_step(scene, action)")

    def action_step(self, scene: SceneLike, action: Action) -> None:
        """Step the simulation."""
        raise self._missing("action_step(scene, action)")

    def action_post_step(self, scene: SceneLike, action: Action) -> None:
        """Stop the motion, after the simulation steps."""
        raise self._missing("action_post_step(scene, action)")

    def action_shape(self, scene: SceneLike | None = None) -> tuple[int, ...]:
        """Return the shape of an action."""
        raise self._missing("action_shape(scene)", " that returns a tuple")

    def action_bounds(self, scene: SceneLike | None = None) -> tuple[FloatArray, FloatArray]:
        """Return lower and upper bounds of an action, each of shape (n,)."""
        raise self._missing("action_bounds()", " for this use, such as gymnasium")

    def _missing(self, method: str, purpose: str = "") -> NotImplementedError:
        return NotImplementedError(f"{type(self).__name__} needs a method `{method}`{purpose}.")


_SEARCH = {"trials": 100, "max_configs": 10, "max_time_ms": 10, "trials_per_goal": 5}
"""Additional planning arguments for arms that programs define; the arm of this package ignores them."""


def plan_motion(scene: SceneLike, target: FloatArray, ignore_collisions: bool, second_try: bool) -> ConfigurationPath:
    """Return a path of the arm that moves the tip to a world pose (7,).

    Args:
        scene: The scene of the arm.
        target: Target pose of the tip (7,).
        ignore_collisions: Plan without collision checks.
        second_try: If planning with collision checks fails, plan without them.

    Raises:
        InvalidActionError: The target is outside the workspace, or no motion was found.
    """
    runtime_of(scene).check_target_in_workspace(target[:3])
    arm: Any = Panda() if isinstance(scene, Runtime) else scene.robot.arm
    try:
        path: ConfigurationPath = arm.get_path(target[:3], quaternion=target[3:], ignore_collisions=ignore_collisions, **_SEARCH)
    except ConfigurationPathError as error:
        if second_try and not ignore_collisions:
            return plan_motion(scene, target, True, False)
        raise InvalidActionError(f"No motion to the target pose: {error.__cause__ or error}") from error
    return path


def run(scene: SceneLike, path: ConfigurationPath, on_step: OnStep | None) -> None:
    """Follow a path to its end, or until the episode is over; with a callback always to its end.

    Args:
        scene: The scene of the arm.
        path: The path.
        on_step: Function that is called with an observation after each step.
    """
    runtime = runtime_of(scene)

    def show() -> None:
        """Call `on_step` with a new observation."""
        if on_step is not None:
            on_step(scene.get_observation())

    if isinstance(path, ArmConfigurationPath):
        follow(runtime, path.trajectory, on_tick=lambda target: show(), whole=on_step is not None)
        return
    done = False
    while not done:
        done = bool(path.step())
        scene.step()
        show()
        done = done or (runtime.over and on_step is None)


def setting(name: str) -> property:
    """Return a property that is an alias of the attribute `name`."""

    def read(self: Any) -> Any:
        return getattr(self, name)

    def write(self: Any, value: Any) -> None:
        setattr(self, name, value)

    return property(read, write)


class ScenePart(Mode):
    """Mixin that adds the interface of RLBench to a native action mode; it comes before the mode in the bases of a class."""

    def action(self, scene: SceneLike, action: object) -> None:
        """Check one action, then execute it to its end, by the next three methods.

        Raises:
            InvalidActionError: The action is invalid; the robot has not moved.
        """
        self.action_pre_step(scene, action)
        self.action_step(scene, action)
        self.action_post_step(scene, action)

    def action_pre_step(self, scene: SceneLike, action: object) -> None:
        """Check the action and command it."""
        self.values(scene, action)

    def action_step(self, scene: SceneLike, action: object) -> None:
        """Step the simulation until the action is complete."""
        self.steps(runtime_of(scene), self.values(scene, action))

    def action_post_step(self, scene: SceneLike, action: object) -> None:
        """Stop the motion."""

    def action_shape(self, scene: SceneLike | None = None) -> tuple[int]:
        """Return the shape of an action."""
        return (self.spec(runtime_of(scene)).size,)

    def action_bounds(self, scene: SceneLike | None = None) -> tuple[FloatArray, FloatArray]:
        """Return lower and upper bounds of an action, each of shape (n,)."""
        spec = self.spec(runtime_of(scene))
        return spec.low.copy(), spec.high.copy()

    def values(self, scene: SceneLike, action: object) -> FloatArray:
        """Return the values (n,) of an action, or raise InvalidActionError if it is invalid."""
        runtime = runtime_of(scene)
        numbers = as_action(action, self.spec(runtime).size, type(self).__name__)
        return self.check(runtime, numbers)


class OneStepPart(ScenePart):
    """A mode that sets commands and steps the simulation once, through the scene."""

    def action_pre_step(self, scene: SceneLike, action: object) -> None:
        self.pre_step(runtime_of(scene), self.values(scene, action))

    def action_step(self, scene: SceneLike, action: object) -> None:
        scene.step()

    def action_post_step(self, scene: SceneLike, action: object) -> None:
        self.post_step(runtime_of(scene), self.values(scene, action))
