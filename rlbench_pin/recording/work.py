"""What a worker does: one piece of work in, one encoded episode out. It writes nothing and keeps nothing but its environment."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rlbench_pin.datasets import EpisodeEntry, encode_demo, episode_entry, read_demo
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import ResetError, RlbenchPinError, TaskError
from rlbench_pin.observation import LOW_DIM, Demo
from rlbench_pin.recording.config import PictureConfig, WorkItem
from rlbench_pin.recording.replay import replay_demo
from rlbench_pin.sim import give_back_memory
from rlbench_pin.tasks import Task, find_task, task_digest

_FREE_EVERY = 5_000_000
"""So many bytes of episodes are made before memory is given back."""


@dataclass(frozen=True)
class ItemResult:
    """What became of one piece of work."""

    item: WorkItem
    """What was to be made."""
    failures: tuple[str, ...]
    """Why tries failed, each as `kind: message`."""
    data: bytes | None = None
    """The bytes of the episode file, None when every try failed."""
    entry: EpisodeEntry | None = None
    """Its line of the manifest."""


class Recorder:
    """Makes episodes, one after the other, in one environment.

    Args:
        config: Which pictures they hold.
    """

    def __init__(self, config: PictureConfig) -> None:
        self.config = config
        self._environment: Environment | None = None
        self._task: TaskEnvironment | None = None
        self._loaded = ""
        self._speed: tuple[float, float] | None = None
        self._made = 0

    def make(self, item: WorkItem) -> ItemResult:
        """Make one episode; the result says what goes wrong in a try."""
        failures: list[str] = []
        for attempt in item.attempts:
            try:
                demo = self._try(item, attempt, failures)
            except RlbenchPinError as error:
                failures.append(f"{type(error).__name__}: {error}")
                if not isinstance(error, ResetError):
                    break
                continue
            except Exception as error:  # a fault of one task must not cost the others
                failures.append(f"fault: {type(error).__name__}: {error}")
                self.close()
                continue
            if demo is not None:
                data = encode_demo(demo, self.config.compression)
                self._free_memory(len(data), after_failures=bool(failures))
                return ItemResult(item, tuple(failures), data, episode_entry(demo, data, item.index, failures))
        return ItemResult(item, tuple(failures))

    def close(self) -> None:
        """Free the environment; the next item makes another."""
        if self._environment is not None:
            self._environment.shutdown()
        self._environment, self._task, self._loaded = None, None, ""

    def _free_memory(self, made: int, *, after_failures: bool) -> None:
        """Give memory back after an episode with pictures, whose raw frames take tens of megabytes, or after many without.

        Only what failed leaves frames in cycles, by its traceback; to look for them everywhere takes 70 ms.
        """
        self._made += made
        if self._made > _FREE_EVERY:
            self._made = 0
            give_back_memory(collect=after_failures)

    def _try(self, item: WorkItem, attempt: int, failures: list[str]) -> Demo | None:
        task = self._load(item)
        outcome = task.try_demo(seed=item.seed, variation=item.variation, attempt=attempt)
        if not item.source:
            failures += [outcome.cause] if outcome.cause else []
            return outcome.demo
        stored = read_demo(Path(item.source), (*LOW_DIM, "gripper_matrix"), sha256=item.sha256 or None)
        if outcome.demo is not None and same_motion(outcome.demo, stored):
            return outcome.demo
        return replay_demo(task, stored)

    def _load(self, item: WorkItem) -> TaskEnvironment:
        if self._speed != item.speed:
            self.close()
        if self._task is None or self._loaded != item.task:
            if self._environment is None:
                self._environment, self._speed = self.config.environment(*item.speed), item.speed
            self._task, self._loaded = self._environment.get_task(_task_of(item)), item.task
        return self._task


def _task_of(item: WorkItem) -> type[Task]:
    """Return the class of the task, unless its files have changed since the work was planned.

    Raises:
        TaskError: They have.
    """
    task = find_task(item.task)
    if item.task_digest and task_digest(task) != item.task_digest:
        raise TaskError(
            f"The files of the task '{item.name}' changed while it was recorded. Record it again into another folder."
        )
    return task


def same_motion(demo: Demo, other: Demo) -> bool:
    """Whether two demonstrations show the same joints at every instant, bit for bit."""
    joints, others = ([np.asarray(obs.joint_positions) for obs in d] for d in (demo, other))
    return len(joints) == len(others) and all(np.array_equal(a, b) for a, b in zip(joints, others))
