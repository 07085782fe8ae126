"""Replay of recorded actions through `step`, either each tick or only the key frames."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from rlbench_pin.datasets import key_frame_actions
from rlbench_pin.environment.demos import EXTRA_TICKS
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DemoError, InvalidActionError
from rlbench_pin.observation import Demo


def reaches_goal(task: TaskEnvironment, actions: Iterable[np.ndarray]) -> bool:
    """Execute actions until the episode ends, and return whether the goal was reached."""
    for action in actions:
        _, reward, terminate = task.step(action)
        if reward > 0.0 or terminate:
            return reward > 0.0
    return False


def replay_succeeds(task: TaskEnvironment, demo: Demo) -> bool:
    """Return whether the joint-position actions of a demonstration reach the goal through `step`.

    Args:
        task: The environment of its task with joint-position actions, at the start of the demonstration.
        demo: The demonstration.

    Raises:
        DemoError: The demonstration has no actions.
    """
    actions = [obs.misc["joint_position_action"] for obs in demo[1:] if "joint_position_action" in obs.misc]
    if not actions or len(actions) < len(demo) - 1:
        raise DemoError(
            "The demonstration contains no `joint_position_action`, so it cannot be replayed. Record it with `live_demos=True`."
        )
    return reaches_goal(task, [*actions, *[actions[-1]] * EXTRA_TICKS])


def key_frames_succeed(task: TaskEnvironment, demo: Demo) -> bool:
    """Return whether the key frames of a demonstration, planned again, reach the goal through `step`.

    Args:
        task: The environment of its task, at the start of the demonstration, with tip poses by planning as actions. With
            `EndEffectorPoseViaPlanning(retry_without_checks=True)` a segment that cannot be planned is planned again without
            collision checks.
        demo: The demonstration.

    Raises:
        DemoError: A key frame lacks a field that the action needs.
    """
    try:
        return reaches_goal(task, key_frame_actions(demo))
    except InvalidActionError:
        return False
