"""Replays recorded actions through `step`, every tick or the key frames alone, and reports success."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from rlbench_pin.datasets import key_frame_actions
from rlbench_pin.environment.demos import EXTRA_TICKS
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DemoError, InvalidActionError
from rlbench_pin.observation import Demo


def reaches_goal(task: TaskEnvironment, actions: Iterable[np.ndarray]) -> bool:
    """Step through actions until the episode ends; whether the goal was reached."""
    for action in actions:
        _, reward, terminate = task.step(action)
        if reward > 0.0 or terminate:
            return reward > 0.0
    return False


def replay_succeeds(task: TaskEnvironment, demo: Demo) -> bool:
    """Whether the joint-position actions of a demonstration reach the goal through `step`, from the start of the demo.

    Args:
        task: The environment of its task with joint-position actions, at the start of the demonstration.
        demo: The demonstration.

    Raises:
        DemoError: It has no actions.
    """
    actions = [obs.misc["joint_position_action"] for obs in demo[1:] if "joint_position_action" in obs.misc]
    if not actions or len(actions) < len(demo) - 1:
        raise DemoError("The demonstration holds no `joint_position_action`, so it cannot be replayed. Record it live.")
    return reaches_goal(task, [*actions, *[actions[-1]] * EXTRA_TICKS])


def key_frames_succeed(task: TaskEnvironment, demo: Demo) -> bool:
    """Whether the key frames of a demonstration, planned again, reach the goal through `step`, from the start of the demo.

    Args:
        task: The environment of its task, at the start of the demonstration, whose actions are tip poses by planning. With
            `EndEffectorPoseViaPlanning(retry_without_checks=True)` a segment that is refused is planned without collision checks.
        demo: The demonstration.

    Raises:
        DemoError: A key frame lacks what an action needs.
    """
    try:
        return reaches_goal(task, key_frame_actions(demo))
    except InvalidActionError:
        return False
