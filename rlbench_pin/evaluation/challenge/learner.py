"""What a few-shot learner is, and what it is given: meta-training tasks to practise, then demonstrations of an unseen one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from rlbench_pin.environment.actions.mode import ActionMode
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.evaluation.policies.policy import Policy
from rlbench_pin.evaluation.run.config import expert_settings
from rlbench_pin.observation import Demo, Observation

Pictures = Literal["all", "first"]
"""Which frames of demonstrations have their pictures."""


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
    demonstration only the first frame needs its pictures, which spares gigabytes; otherwise all frames have them.

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
