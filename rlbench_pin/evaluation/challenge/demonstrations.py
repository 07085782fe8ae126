"""Demonstrations of test tasks: workers make them when they are needed, and a folder keeps them with their seeds."""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np

from rlbench_pin.datasets import encode_demo, read_demo
from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.task_environment import MAX_DEMO_ATTEMPTS, TaskEnvironment
from rlbench_pin.errors import RlbenchPinError, storing
from rlbench_pin.evaluation.challenge.client import IMAGES
from rlbench_pin.evaluation.challenge.config import ChallengeConfig, NoDemonstrations, demonstration_seed
from rlbench_pin.evaluation.challenge.learner import ImageFrames
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.run.config import expert_settings
from rlbench_pin.observation import FIELDS, Demo, Observation
from rlbench_pin.processes import Engine, WorkerDeath, run_jobs


@dataclass(frozen=True)
class ShownItem:
    """A demonstration to make."""

    task: str
    index: int
    """Number of the demonstration of its task."""
    seed: int


@dataclass(frozen=True)
class MadeDemonstration:
    """A demonstration, or the cause of its failure."""

    item: ShownItem
    variation: int = 0
    attempt: int = 0
    data: bytes = b""
    """The bytes of its file; empty when all attempts failed."""
    cause: str = ""
    """Cause of the failure of the last attempt."""


class DemonstrationMaker:
    """Makes demonstrations, one after the other, in one environment.

    Args:
        config: The run.
        settings: Settings of the learner; the demonstrations contain its observations.
        image_frames: Frames that contain images.
    """

    def __init__(self, config: ChallengeConfig, settings: PolicySettings, image_frames: ImageFrames) -> None:
        self._config, self._settings, self._image_frames = config, settings, image_frames
        self._environment: Environment | None = None
        self._task: TaskEnvironment | None = None

    def make(self, item: ShownItem) -> MadeDemonstration:
        """Make one demonstration, with as many attempts as for live demonstrations."""
        cause = ""
        for attempt in range(MAX_DEMO_ATTEMPTS):
            try:
                task = self._load(item.task)
                variation = shown_variation(self._config.drawing_seed, task.variation_count(), item.index)
                outcome = task.try_demo(seed=item.seed, variation=variation, attempt=attempt)
            except RlbenchPinError as error:
                cause = str(error)
                continue
            if outcome.demo is not None:
                for seen in outcome.demo[1:] if self._image_frames == "first" else ():
                    remove_images(seen)
                return MadeDemonstration(item, variation, attempt, encode_demo(outcome.demo, "lzf"))
            cause = outcome.cause
        return MadeDemonstration(item, cause=cause)

    def close(self) -> None:
        """Free the environment."""
        if self._environment is not None:
            self._environment.shutdown()
        self._environment, self._task = None, None

    def _load(self, name: str) -> TaskEnvironment:
        if self._environment is None:
            mode = expert_settings().make_action_mode()
            robot, seen = self._config.robot, self._settings.make_obs_config()
            self._environment = Environment(mode, obs_config=seen, robot_setup=robot, seed=0)
        if self._task is None or self._task.get_name() != name:
            self._task = self._environment.get_task(name)
        return self._task


def remove_images(observation: Observation) -> None:
    """Remove the images from an observation."""
    for name in [name for name in vars(observation) if name.endswith(IMAGES)]:
        if name in FIELDS:
            setattr(observation, name, None)
        else:
            delattr(observation, name)


def shown_variation(seed: int, count: int, index: int) -> int:
    """Return the variation of demonstration `index`, in a random order of the seed, each once before any is repeated."""
    order = np.random.default_rng((seed, index // count)).permutation(count)
    return int(order[index % count])


class ShownDemonstrations:
    """The demonstrations of a run on disk: one file for each, and for each task a list of seeds and checksums.

    Args:
        folder: Folder of the demonstrations.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def missing(self, config: ChallengeConfig) -> list[ShownItem]:
        """Return the demonstrations that are still missing."""
        found: list[ShownItem] = []
        for task in config.tasks().test:
            kept = self._entries(task)
            wanted = [ShownItem(task, i, demonstration_seed(config.drawing_seed, task, i)) for i in range(max(config.shots))]
            found += [item for item in wanted if item.index not in kept or not self._path(task, item.index).is_file()]
        return found

    def make(
        self,
        config: ChallengeConfig,
        wanted: tuple[PolicySettings, ImageFrames],
        engine: Engine,
        on_done: Callable[[ShownItem], None],
        stop: threading.Event,
    ) -> int:
        """Make the missing demonstrations, and return how many are still missing: 0, unless `stop` was set.

        Raises:
            NoDemonstrations: The planner could not demonstrate a task.
            StorageError: The disk cannot be written to.
        """
        events = run_jobs(
            self.missing(config), partial(DemonstrationMaker, config, *wanted), store=self._keep,
            lost=lambda given_up: MadeDemonstration(given_up.item, cause=given_up.cause), engine=engine, stop=stop,
        )  # fmt: skip
        for event in events:
            if not isinstance(event, WorkerDeath):
                on_done(event.item)
        return len(self.missing(config))

    def read(self, task: str, count: int) -> Iterator[Demo]:
        """Yield the first `count` demonstrations of a task.

        Raises:
            DatasetError: A demonstration is missing or damaged.
        """
        entries = self._entries(task)
        for index in range(count):
            yield read_demo(self._path(task, index), sha256=str(entries[index]["sha256"]))

    def _keep(self, made: MadeDemonstration) -> None:
        if not made.data:
            raise NoDemonstrations(made.item.task, made.item.seed, made.cause)
        item, path = made.item, self._path(made.item.task, made.item.index)
        with storing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, made.data)
        entry = {**asdict(item), "variation": made.variation, "attempt": made.attempt}
        entries = {**self._entries(item.task), item.index: {**entry, "sha256": hashlib.sha256(made.data).hexdigest()}}
        lines = (json.dumps(entries[index]) + "\n" for index in sorted(entries))
        write_whole(self._list(item.task), "".join(lines).encode())

    def _entries(self, task: str) -> Mapping[int, Mapping[str, object]]:
        path = self._list(task)
        if not path.is_file():
            return {}
        with storing(path):
            lines: Sequence[str] = path.read_text(encoding="utf-8").splitlines()
        return {entry["index"]: entry for entry in map(json.loads, lines)}

    def _path(self, task: str, index: int) -> Path:
        return self.folder / task / f"{index}.hdf5"

    def _list(self, task: str) -> Path:
        return self.folder / task / "demonstrations.jsonl"
