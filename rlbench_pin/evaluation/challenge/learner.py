"""Few-shot learners: they train on meta-training tasks, then adapt to demonstrations of an unseen task."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol

from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.environment.actions.modes import ActionMode
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import storing
from rlbench_pin.evaluation.challenge.config import ChallengeConflict
from rlbench_pin.evaluation.policies.policy import Policy
from rlbench_pin.evaluation.policies.policy_server import WireError, pack, unpack
from rlbench_pin.evaluation.run.config import expert_settings
from rlbench_pin.observation import Demo, Observation

ImageFrames = Literal["all", "first"]
"""Frames of a demonstration that contain images."""


@dataclass(frozen=True)
class Demonstration:
    """A demonstration of an unseen task: only its instructions and observations."""

    instructions: tuple[str, ...]
    """Sentences with the same meaning that describe the goal."""
    observations: tuple[Observation, ...]
    """One observation per control tick, the first before any motion, with the data of the learner's `obs_config`."""


@dataclass(frozen=True)
class TrainingTask:
    """A meta-training task. The learner gets its name, and may use the whole package on it."""

    name: str
    robot: str = "panda"
    """Name of the arm of the test episodes."""

    def demonstrations(self, count: int, obs_config: ObservationConfig, seed: int = 0) -> Iterator[Demo]:
        """Plan demonstrations of all variations in order, and yield each when it is finished.

        Args:
            count: Number of demonstrations.
            obs_config: Data of the observations.
            seed: Demonstration i has the seed `seed + i` and the variation `seed + i` modulo the number of variations.

        Raises:
            DemoError: A demonstration failed in ten attempts.
        """
        with self.environment(expert_settings().make_action_mode(), obs_config) as task:
            for i in range(count):
                task.set_variation((seed + i) % task.variation_count())
                yield from task.get_demos(1, live_demos=True, seed=seed + i)

    @contextmanager
    def environment(self, action_mode: ActionMode, obs_config: ObservationConfig) -> Iterator[TaskEnvironment]:
        """Return a context with an environment of the task."""
        with Environment(action_mode, obs_config=obs_config, robot_setup=self.robot) as environment:
            yield environment.get_task(self.name)


class FewShotLearner(Protocol):
    """Interface of a learner, which makes a policy from a few demonstrations.

    The optional attribute `max_steps` suggests the maximum number of actions of an episode. With the optional attribute
    `pictures = "first"`, only the first frame of each demonstration has images, which saves gigabytes; otherwise all frames have
    them.

    Attributes:
        action_mode: Action mode of its policies; a mode of this package.
        obs_config: Observations of demonstrations and of its policies. Masks, task states and distances are not allowed.
    """

    action_mode: ActionMode
    obs_config: ObservationConfig

    def meta_train(self, tasks: Sequence[TrainingTask]) -> Mapping[str, Any] | None:
        """Train on the meta-training tasks, and return the result: a map of arrays, numbers, texts, lists and maps, or None.

        It is called once, in its own process. Every process that adapts gets the result by `recall`, unless it is None.
        """
        ...

    def recall(self, learned: Mapping[str, Any]) -> None:
        """Load the result of `meta_train`. It is called before `adapt`, unless the result is None."""
        ...

    def adapt(self, demonstrations: Sequence[Demonstration]) -> Policy:
        """Return a policy for the demonstrated task, with the action mode and the observations of the learner.

        Each task and number of demonstrations has a new process, so that no state of other tasks remains.
        """
        ...


def write_learned(path: Path, learned: Mapping[str, Any] | None) -> Path:
    """Write the result of `meta_train` to a msgpack file with arrays, numbers and texts, but no code, and return the path.

    Raises:
        WireError: The result is not plain data, or is larger than 256 MB.
        StorageError: The disk cannot be written to.
    """
    return write_whole(path, pack({"learned": learned}))


def read_learned(path: Path) -> Mapping[str, Any] | None:
    """Return the result of `meta_train` in a file; None if there is no such file or no result.

    Raises:
        ChallengeConflict: The file is damaged.
        StorageError: It cannot be read.
    """
    if not path.is_file():
        return None
    with storing(path):
        data = path.read_bytes()
    try:
        learned = unpack(data[4:])["learned"]
    except (WireError, KeyError) as error:
        raise ChallengeConflict(f"'{path}' is damaged: {error}. Delete it, and continue with `--resume`.") from error
    return learned if isinstance(learned, Mapping) else None
