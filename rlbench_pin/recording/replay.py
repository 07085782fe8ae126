"""A stored demonstration played again from its own start and its own actions, for other cameras."""

from __future__ import annotations

import numpy as np

from rlbench_pin.environment.demos import library_versions
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DemoError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.values import as_record

JOINT_TOLERANCE = 1e-3
"""How far a joint may be from where it was recorded, in replay [rad]."""


def replay_demo(task: TaskEnvironment, stored: Demo) -> Demo:
    """Restore the start of a demonstration, repeat its joint-position actions, and observe again.

    Args:
        task: The environment of its task, with the cameras that are wanted and joint-position actions.
        stored: The demonstration, with joint positions.

    Raises:
        DemoError: It has no actions, or the motion comes out otherwise than it was recorded.
    """
    as_record(task, TaskEnvironment, "task")
    _, first = task.reset_to_demo(stored)
    _keep_flag(first, stored[0])
    frames = [first]
    for index, recorded in enumerate(stored[1:], start=1):
        action = recorded.misc.get("joint_position_action")
        if action is None:
            raise DemoError(
                "The stored demonstration holds no `joint_position_action`, so it cannot be replayed. Record it again."
            )
        observation, _, _ = task.step(action)
        observation.misc["joint_position_action"] = np.array(action)
        _keep_flag(observation, recorded)
        _compare(observation.joint_positions, recorded.joint_positions, index, stored)
        frames.append(observation)
    return Demo(
        frames,
        random_seed=stored.random_seed,
        num_reset_attempts=stored.num_reset_attempts,
        variation_number=stored.variation_number,
        instructions=stored.instructions,
        state=stored.state,
        versions=library_versions(),
        attempt=stored.attempt,
        task_name=stored.task_name,
    )


def _keep_flag(observation: Observation, recorded: Observation) -> None:
    if recorded.ignore_collisions is not None:
        observation.ignore_collisions = recorded.ignore_collisions


def _compare(now: np.ndarray | None, then: np.ndarray | None, index: int, stored: Demo) -> None:
    if now is None or then is None:
        raise DemoError("The stored demonstration holds no joint positions, so its replay cannot be judged. Record it again.")
    error = float(np.max(np.abs(now - then)))
    if error > JOINT_TOLERANCE:
        made = ", ".join(f"{name} {version}" for name, version in stored.versions.items())
        raise DemoError(
            f"Neither its seed nor its actions give the demonstration again: at frame {index} a joint is {error:.4f} rad away. "
            f"It was made with {made}. Use those versions, or record it again."
        )
