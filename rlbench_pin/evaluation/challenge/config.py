"""What a run of the challenge is: which learner, on which split, with how many demonstrations."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

from rlbench_pin.errors import InvalidArgument
from rlbench_pin.evaluation.challenge.references import find_learner
from rlbench_pin.evaluation.challenge.splits import MetaSplit, meta_split
from rlbench_pin.evaluation.run.config import LARGEST_START, MOST_EPISODES, SECONDS, EvaluationConfig
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.values import as_choice, as_flag, as_names, as_number, as_several, as_text, as_whole

SHOTS = (1, 5, 20)
"""Demonstrations of each task, as the challenge v1 has them."""
MOST_SHOTS = 1000
"""Demonstrations of a task at most."""


@dataclass(frozen=True, kw_only=True)
class ChallengeConfig:
    """Which learner, on which split, with how many demonstrations. The same settings give the same results.

    Raises:
        InvalidArgument: A number, a text or a switch cannot be used (also an InvalidValue).
        UnknownName: There is no such learner or split.
        PolicyReferenceError: The reference leads to no learner.
    """

    learner: str
    """`nearest`, or a reference to a learner of your own: `module:factory`, `file.py:factory`."""
    split: str = "V1"
    """Which tasks are trained and tested on."""
    shots: tuple[int, ...] = SHOTS
    """Numbers of demonstrations of each test task; the fewer are the first of the more."""
    only: tuple[str, ...] = ()
    """Test tasks to keep to; all of the split when none is named."""
    available: bool = False
    """Leave out the tasks that are not built."""
    episodes: int = 25
    """Episodes of each test task, for each number of demonstrations; always the same ones."""
    seed: int = 0
    """Seed of the episodes of the test, and of the demonstrations."""
    max_steps: int | None = None
    """Actions of an episode at most; None leaves it to the learner and its action mode."""
    max_seconds: float = SECONDS
    """Simulated time of an episode at most [s]."""
    time_limit: float = 30.0
    """Time that a policy has for one answer [s], of a clock on the wall."""
    start_limit: float = 300.0
    """Time that a learner has to start [s]."""
    adapt_limit: float = 3600.0
    """Time that a learner has to adapt to a task [s]."""
    train_limit: float = 1e6
    """Time that a learner has to practise the meta-training tasks [s]."""
    robot: str = DEFAULT_ROBOT
    """Name of the arm."""

    def __post_init__(self) -> None:
        """Check every value, and keep it as plain Python has it."""
        shots = (as_whole(k, "shots", InvalidArgument, least=1, most=MOST_SHOTS) for k in as_several(self.shots, "shots"))
        checked = {
            "learner": as_text(self.learner, "learner", InvalidArgument),
            "split": meta_split(self.split).name,
            "shots": tuple(sorted(set(shots))),
            "only": tuple(dict.fromkeys(as_names(self.only, "only", InvalidArgument))),
            "available": as_flag(self.available, "available", InvalidArgument),
            "episodes": as_whole(self.episodes, "episodes", InvalidArgument, least=1, most=MOST_EPISODES),
            "seed": as_whole(self.seed, "seed", InvalidArgument, least=0, most=LARGEST_START),
            "robot": robot_description(self.robot).name,
        }
        for name in ("max_seconds", "time_limit", "start_limit", "adapt_limit", "train_limit"):
            checked[name] = as_number(getattr(self, name), name, InvalidArgument, above=0.0, most=1e7)
        if self.max_steps is not None:
            checked["max_steps"] = as_whole(self.max_steps, "max_steps", InvalidArgument, least=1)
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        if not self.shots:
            raise InvalidArgument("shots", (), "leaves nothing to test", "The challenge v1 has 1, 5 and 20.")
        for task in self.only:
            as_choice(task, f"test task of {self.split}", meta_split(self.split).test)
        find_learner(self.learner)

    def tasks(self) -> MetaSplit:
        """Return the tasks of the run.

        Raises:
            MissingTasks: Some are not built, and are not to be left out.
        """
        return meta_split(self.split).chosen(self.available, self.only)

    def evaluation(self, shots: int) -> EvaluationConfig:
        """Return the evaluation with so many demonstrations."""
        return EvaluationConfig(
            policy=f"{self.learner}, {shots} shot{'s' if shots > 1 else ''}",
            tasks=self.tasks().test,
            task_set=f"challenge {self.split}",
            episodes=self.episodes,
            seed=self.seed,
            max_steps=self.max_steps,
            max_seconds=self.max_seconds,
            time_limit=self.time_limit,
            start_limit=self.start_limit,
            robot=self.robot,
            tell_task=False,
        )


def demonstration_seed(seed: int, task: str, index: int) -> int:
    """Return the seed of demonstration `index` of a test task, 0 <= seed < 2^53: a hash. Evaluations begin at 2^53.

    Args:
        seed: Seed of the run.
        task: Name of the task.
        index: Number of the demonstration.
    """
    text = f"rlbench_pin challenge demonstration/{seed}/{task}/{index}".encode()
    return int.from_bytes(hashlib.sha256(text).digest()[:8], "big") >> 11
