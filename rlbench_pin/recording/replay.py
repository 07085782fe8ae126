"""Replay the recorded actions of a demonstration in memory, or of stored episodes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rlbench_pin.datasets import counted_demo, counted_files, read_demo, stored_tasks
from rlbench_pin.datasets.trust import Inspector
from rlbench_pin.environment.demos import library_versions
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.environment.replay import replay_succeeds
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DemoError
from rlbench_pin.observation import INTERVENTION, LOW_DIM, PHASE, Demo, Observation
from rlbench_pin.robot.description import DEFAULT_ROBOT
from rlbench_pin.tasks import OwnTasks, stored_task
from rlbench_pin.values import as_flag, as_path, as_record, as_several

JOINT_TOLERANCE = 1e-3
"""Tolerance of a joint position in replay [rad]."""


def replay_demo(task: TaskEnvironment, stored: Demo) -> Demo:
    """Restore the start of a demonstration, repeat its joint-position actions, and return it with new observations.

    Args:
        task: The environment of its task, with joint-position actions and the cameras of the new observations.
        stored: The demonstration, with joint positions.

    Raises:
        DemoError: The demonstration has no actions, or the motion differs from the recorded motion.
    """
    as_record(task, TaskEnvironment, "task")
    _, first = task.reset_to_demo(stored)
    _keep_flags(first, stored[0])
    frames = [first]
    for index, recorded in enumerate(stored[1:], start=1):
        action = recorded.misc.get("joint_position_action")
        if action is None:
            raise DemoError("The stored demonstration has no `joint_position_action`, so it cannot be replayed. Record it again.")
        observation, _, _ = task.step(action)
        observation.misc["joint_position_action"] = np.array(action)
        _keep_flags(observation, recorded)
        _compare(observation.joint_positions, recorded.joint_positions, index, stored)
        frames.append(observation)
    again = stored.with_observations(frames)
    again.versions = library_versions()
    return again


def _keep_flags(observation: Observation, recorded: Observation) -> None:
    if recorded.ignore_collisions is not None:
        observation.ignore_collisions = recorded.ignore_collisions
    observation.misc |= {key: recorded.misc[key] for key in (PHASE, INTERVENTION) if key in recorded.misc}


def _compare(now: np.ndarray | None, then: np.ndarray | None, index: int, stored: Demo) -> None:
    if now is None or then is None:
        raise DemoError("The stored demonstration has no joint positions, so its replay cannot be checked. Record it again.")
    error = float(np.max(np.abs(now - then)))
    if error > JOINT_TOLERANCE:
        made = ", ".join(f"{name} {version}" for name, version in stored.versions.items())
        raise DemoError(
            f"Neither the seed nor the actions reproduce the demonstration: at frame {index} a joint differs by {error:.4f} rad. "
            f"It was made with {made}. Use those versions, or record it again."
        )


@dataclass(frozen=True)
class ReplayResult:
    """Result of the replay of one stored episode."""

    path: Path
    """The episode file."""
    reached: bool
    """Whether its actions reached the goal again."""


def replay_stored(
    paths: Sequence[Path], *, own: OwnTasks | None = None, trust_task_files: bool = False
) -> Iterator[ReplayResult]:
    """Restore the start of stored episodes, repeat their joint-position actions, and yield the result of each.

    Args:
        paths: Episode files, or folders of datasets. All episodes in the manifests of a dataset are replayed.
        own: Task name -> task class of the user; these replace tasks of the same name in the dataset.
        trust_task_files: Whether task files in a dataset may be run.

    Raises:
        UntrustedTaskFile: A task is code in a dataset, and `trust_task_files` is not set.
        DatasetError: A file cannot be read, or a folder contains no demonstrations.
        DemoError: An episode has no joint-position actions.
    """
    chosen = [as_path(path, "an entry of paths") for path in as_several(paths, "paths")]
    tasks = {} if own is None else as_record(own, Mapping, "own")  # type: ignore[type-abstract]
    return _replayed(chosen, tasks, as_flag(trust_task_files, "trust_task_files"))


def _replayed(paths: Sequence[Path], own: OwnTasks, trust_task_files: bool) -> Iterator[ReplayResult]:
    with ExitStack() as stack:
        environments: dict[str, Environment] = {}
        task: TaskEnvironment | None = None
        loaded: tuple[tuple[Path, str], str] | None = None
        for path, demo in _episodes(paths):
            origin, robot = (_root_of(path), demo.task_name), demo.robot or DEFAULT_ROBOT
            if task is None or loaded != (origin, robot):
                if robot not in environments:
                    environments[robot] = stack.enter_context(make_environment(low_dim_config(), robot=robot))
                task = environments[robot].get_task(stored_task(*origin, own, trust_task_files))
                loaded = (origin, robot)
            task.reset_to_demo(demo)
            yield ReplayResult(path, replay_succeeds(task, demo))


def _root_of(episode: Path) -> Path:
    """Return the folder of the dataset of an episode file: `<root>/<task>/variation<k>/episodes/<file>`."""
    return episode.absolute().parents[3] if len(episode.absolute().parents) > 3 else episode.absolute().parent


def _episodes(paths: Sequence[Path]) -> Iterator[tuple[Path, Demo]]:
    """Yield episodes and their paths, each read when it is needed."""
    with Inspector() as inspector:
        for path in paths:
            if not path.is_dir():
                yield path, read_demo(path, LOW_DIM, inspector=inspector)
                continue
            for task in stored_tasks(path, at_least_one=True):
                for file, sha256 in counted_files(path, task).items():
                    yield file, counted_demo(file, sha256, LOW_DIM, inspector=inspector)
