"""Few-shot learners: they practise meta-training tasks, then adapt to demonstrations of an unseen task."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol

from rlbench_pin.datasets.storage import storing, write_whole
from rlbench_pin.environment.actions.modes import ActionMode
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.evaluation.challenge.config import ChallengeConflict
from rlbench_pin.evaluation.policies.policy import Policy
from rlbench_pin.evaluation.policies.policy_server import WireError, pack, unpack
from rlbench_pin.evaluation.run.config import expert_settings
from rlbench_pin.observation import Demo, Observation

ImageFrames = Literal["all", "first"]
"""Frames of a demonstration that contain images."""


@dataclass(frozen=True)
class Demonstration:
    """A demonstration of an unseen task: what was said and what was seen, and nothing else."""

    instructions: tuple[str, ...]
    """Sentences that say the same: what is done."""
    observations: tuple[Observation, ...]
    """One per control tick, the first before any motion, with what the learner's `obs_config` asks for."""


@dataclass(frozen=True)
class TrainingTask:
    """A meta-training task. It is open: the name is known, and all of the package may be used on it."""

    name: str
    robot: str = "panda"
    """Name of the arm of the test."""

    def demonstrations(self, count: int, obs_config: ObservationConfig, seed: int = 0) -> Iterator[Demo]:
        """Plan demonstrations, and yield each as it is made; their variations are drawn.

        Args:
            count: How many.
            obs_config: What they hold.
            seed: Demonstration i begins from `seed + i`.

        Raises:
            DemoError: One could not be made in ten tries.
        """
        with self.environment(expert_settings().make_action_mode(), obs_config) as task:
            for i in range(count):
                task.set_variation((seed + i) % task.variation_count())
                yield from task.get_demos(1, live_demos=True, seed=seed + i)

    @contextmanager
    def environment(self, action_mode: ActionMode, obs_config: ObservationConfig) -> Iterator[TaskEnvironment]:
        """Open the task for the duration of a block, to practise in."""
        with Environment(action_mode, obs_config=obs_config, robot_setup=self.robot) as environment:
            yield environment.get_task(self.name)


class FewShotLearner(Protocol):
    """Something that makes a policy from a few demonstrations.

    An attribute `max_steps` suggests how many actions an episode should have. An attribute `pictures = "first"` says that of each
    demonstration only the first frame needs images, which saves gigabytes; otherwise all frames have them.

    Attributes:
        action_mode: What the actions of its policies mean; one of this package.
        obs_config: What demonstrations hold and what its policies observe: neither masks, nor states of tasks, nor distances.
    """

    action_mode: ActionMode
    obs_config: ObservationConfig

    def meta_train(self, tasks: Sequence[TrainingTask]) -> Mapping[str, Any] | None:
        """Practise, once, in a process of its own, and return what was learned: arrays, numbers, texts, lists and maps.

        It goes to every process that adapts, by `recall`; None is nothing.
        """
        ...

    def recall(self, learned: Mapping[str, Any]) -> None:
        """Take over what `meta_train` returned, before `adapt`; not called when that was None."""
        ...

    def adapt(self, demonstrations: Sequence[Demonstration]) -> Policy:
        """Return a policy for the task that is shown, with the action mode and the observations of the learner.

        A new process is started for each task and number of demonstrations, so that nothing of the others is remembered.
        """
        ...


def write_learned(path: Path, learned: Mapping[str, Any] | None) -> Path:
    """Write what `meta_train` returned: a msgpack file with arrays, numbers and texts, nothing that can be run.

    Raises:
        WireError: It is not plain data, or more than 256 MB.
        StorageError: The disk cannot be written to.
    """
    return write_whole(path, pack({"learned": learned}))


def read_learned(path: Path) -> Mapping[str, Any] | None:
    """Return what `meta_train` returned; None is nothing.

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
