"""Settings of an evaluation, and its episodes. The seeds of the episodes are published and have no other use."""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from rlbench_pin.datasets.layout import ALL_VARIATIONS
from rlbench_pin.environment.actions import Discrete, JointPosition, MoveArmThenGripper
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.episode import EVALUATION_SEEDS, drawn_variations
from rlbench_pin.environment.factors import FactorSetting
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.errors import InvalidArgument, RlbenchPinError, TaskEnvironmentError
from rlbench_pin.evaluation.policies.settings import ARM_MODES, GRIPPER_MODES, PolicySettings
from rlbench_pin.evaluation.protocols.plan import Place, split_places
from rlbench_pin.evaluation.protocols.protocol import Protocol
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.tasks import Task, find_task, is_task_file, task_digest, task_reference
from rlbench_pin.values import as_choice, as_flag, as_names, as_number, as_record, as_text, as_whole

EXPERT = "expert"
"""The policy that plays demonstrations of the planner. It is not a policy object: the runner plays the demonstration."""
MAX_EPISODES = 100_000
"""Maximum number of episodes of one task."""
LARGEST_START = 2**48
"""Largest seed of an evaluation."""
LONGEST_KEY = 64
"""Maximum length of a key of the seeds of policies [bytes]."""
LIMITS = ("episodes", "seed", "max_steps", "max_seconds", "variations", "time_limit", "robot", "tell_task")
"""Settings that results files record as `limits`."""
SECONDS = 120.0
"""Default maximum of the simulated time of an episode [s]; the longest demonstrations take about 110 s."""


@dataclass(frozen=True, kw_only=True)
class EvaluationConfig:
    """Policy, episodes and limits of an evaluation. The same settings give the same results with any number of workers.

    Raises:
        InvalidArgument: A number, a text or a switch cannot be used (also an InvalidValue).
    """

    policy: str
    """The policy: `noop`, `random`, `expert`, or a reference to your own policy; `docs/policies.md` lists all forms."""
    tasks: tuple[str, ...]
    """Task names, or paths of task files."""
    task_set: str = ""
    """Names of tasks or sets as the user gave them, for the results file; the task names when empty."""
    episodes: int = 25
    """Number of episodes of each task, spread evenly over its variations."""
    seed: int = 0
    """Seed of the evaluation; see `evaluation_seed` for the seeds of its episodes."""
    max_steps: int | None = None
    """Maximum number of actions of an episode; None uses the number of the policy or of its action mode."""
    max_seconds: float = SECONDS
    """Maximum simulated time of an episode with the Panda [s]. Arms with slower joints have a longer limit, see
    `RobotModel.slowness`. An action that begins within the limit is played to its end."""
    variations: int = ALL_VARIATIONS
    """Maximum number of variations of a task; -1 is all."""
    time_limit: float = 30.0
    """Wall-clock time limit of a policy for one answer [s]. If the policy takes longer, the episode fails."""
    start_limit: float = 300.0
    """Time limit for the start of a policy [s]."""
    robot: str = DEFAULT_ROBOT
    """Name of the arm, or path of its TOML file."""
    tell_task: bool = True
    """Whether policies get the name of the task in addition to the instruction."""
    policy_seed_key: str | None = None
    """Key of the hash that gives the seeds of the policy, a text of at most 64 bytes. None draws a random key. The results file
    contains the key, so that the run can be repeated."""
    protocol: Protocol | None = None
    """Protocol of the evaluation, or None. `of_protocol` returns the settings of a protocol."""
    factors: tuple[str, ...] = ()
    """Settings of factors, such as `light_color:2` or `light_color:2+friction:1`. The same episodes are played without factors,
    and once with each setting that can change the task."""
    trained_on: str = ""
    """Factors in the training data, for the results file."""

    def __post_init__(self) -> None:
        checked = {
            "policy": as_text(self.policy, "policy", InvalidArgument),
            "tasks": tuple(as_names(self.tasks, "tasks", InvalidArgument)),
            "task_set": as_text(self.task_set, "task_set", InvalidArgument),
            "episodes": as_whole(self.episodes, "episodes", InvalidArgument, least=1, most=MAX_EPISODES),
            "seed": as_whole(self.seed, "seed", InvalidArgument, least=0, most=LARGEST_START),
            "variations": as_whole(self.variations, "variations", InvalidArgument, least=ALL_VARIATIONS),
            "robot": robot_description(self.robot).reference,
            "tell_task": as_flag(self.tell_task, "tell_task", InvalidArgument),
            "factors": _checked_factors(self.factors),
            "trained_on": as_text(self.trained_on, "trained_on", InvalidArgument),
        }
        for name in ("max_seconds", "time_limit", "start_limit"):
            checked[name] = as_number(getattr(self, name), name, InvalidArgument, above=0.0)
        if self.max_steps is not None:
            checked["max_steps"] = as_whole(self.max_steps, "max_steps", InvalidArgument, least=1)
        if self.policy_seed_key is not None:
            checked["policy_seed_key"] = _checked_key(self.policy_seed_key)
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        if self.variations == 0:
            raise InvalidArgument("variations", 0, "has to be -1 or at least 1", "Write -1 for all variations.")
        if not self.policy:
            raise InvalidArgument("policy", "", "names no policy", "Use `noop`, `random`, `expert` or a reference.")
        if not self.tasks:
            raise TaskEnvironmentError("No task was named. `rlbench-pin list` prints them.")
        if self.protocol is not None:
            self._check_protocol(as_record(self.protocol, Protocol, "protocol", InvalidArgument))

    def _check_protocol(self, protocol: Protocol) -> None:
        """Raise ProtocolConflict for a setting that contradicts the protocol, ProtocolTasksMissing for missing tasks."""
        as_choice(protocol.arm, "arm action mode", ARM_MODES)
        as_choice(protocol.gripper, "gripper action mode", GRIPPER_MODES)
        protocol.check_tasks_exist()
        fixed = protocol_settings(protocol)
        protocol.check_agrees({name: getattr(self, name) for name in fixed}, fixed)

    @classmethod
    def of_protocol(cls, policy: str, protocol: Protocol) -> EvaluationConfig:
        """Return the settings of an evaluation with a protocol.

        Args:
            policy: The policy.
            protocol: The protocol, from `load_protocol`.

        Raises:
            ProtocolTasksMissing: The protocol names tasks that are not installed.
        """
        protocol = as_record(protocol, Protocol, "protocol", InvalidArgument)
        return cls(policy=policy, protocol=protocol, **protocol_settings(protocol))

    def with_key(self) -> EvaluationConfig:
        """Return these settings with a key of the policy's seeds; a random key is drawn if there is none."""
        return self if self.policy_seed_key is not None else replace(self, policy_seed_key=secrets.token_hex(16))

    def seeds(self) -> tuple[int, ...]:
        """Return the seeds of the episodes of each task, in order."""
        if self.protocol is not None:
            test = self.protocol.split("test")
            return tuple(evaluation_seed(seed, index) for seed in test.seeds for index in range(test.episodes))
        return tuple(evaluation_seed(self.seed, index) for index in range(self.episodes))


@dataclass(frozen=True)
class EpisodeItem:
    """One episode to play."""

    task: str
    """Task name, or path of the task file, for the workers."""
    name: str
    """Task name."""
    index: int
    """Number of the episode among those of its task."""
    variation: int
    """Variation of the task."""
    seed: int
    """Seed of the episode."""
    policy_seed: int
    """Seed for the policy."""
    task_digest: str = ""
    """SHA-256 of the task's files; not compared when empty."""
    factors: str = ""
    """Factors of generalisation and their levels; empty without factors."""

    @property
    def key(self) -> tuple[str, int, int, str]:
        """Key of the record of the episode: task, variation, seed, factors."""
        return self.name, self.variation, self.seed, self.factors


class TaskFilesChanged(RlbenchPinError):
    """The files of a task changed after the evaluation began."""

    def __init__(self, task: str) -> None:
        self.task = task
        super().__init__(f"The files of the task '{task}' changed while it was evaluated. Begin the evaluation again.")


def protocol_settings(protocol: Protocol) -> dict[str, Any]:
    """Return the settings of an evaluation that a protocol fixes, by name."""
    test = protocol.split("test")
    return {
        "tasks": protocol.task_names,
        "task_set": protocol.label,
        "episodes": test.episodes,
        "seed": test.seeds[0],
        "max_steps": protocol.max_steps,
        "max_seconds": protocol.max_seconds,
        "variations": ALL_VARIATIONS,
        "robot": protocol.robot,
        "tell_task": protocol.tell_task,
        **({"factors": protocol.factors} if protocol.factors else {}),
    }


def evaluation_seed(seed: int, index: int) -> int:
    """Return the seed of episode `index` of the evaluation `seed`: 2^53 + 2 (seed + index).

    Seeds of recordings are below 2^53, and resets without a seed draw one below 2^31. Demonstrations therefore have other start
    states than evaluations. JSON readers of all languages can represent even numbers up to 2^54.
    """
    seed = as_whole(seed, "seed", InvalidArgument, least=0, most=LARGEST_START)
    return EVALUATION_SEEDS + 2 * (seed + as_whole(index, "index", InvalidArgument, least=0, most=MAX_EPISODES))


def policy_seed(key: str, seed: int, name: str, index: int) -> int:
    """Return the seed of a policy for an episode, 0 <= seed < 2^53.

    It is a keyed hash. The key is published after the run; without it, a policy cannot derive the episode from the seed.

    Args:
        key: Key of the run.
        seed: Seed of the evaluation.
        name: Task name.
        index: Number of the episode among those of its task.
    """
    text = f"rlbench_pin policy/{seed}/{name}/{index}".encode()
    return int.from_bytes(hashlib.blake2b(text, digest_size=8, key=key.encode()).digest(), "big") >> 11


def _checked_factors(value: object) -> tuple[str, ...]:
    settings = tuple(str(FactorSetting.of(word)) for word in as_names(value, "factors", InvalidArgument))
    if "" in settings or len(set(settings)) < len(settings):
        raise InvalidArgument("factors", value, "have to be different settings with a level above 0", "For example `friction:1`.")
    return settings


def _checked_key(value: object) -> str:
    key = as_text(value, "policy_seed_key", InvalidArgument)
    if len(key.encode(errors="replace")) > LONGEST_KEY or not key.isprintable():
        hint = "Use the field `policy_seed_key` of a results file."
        raise InvalidArgument("policy_seed_key", key, f"has to be a printable text of at most {LONGEST_KEY} bytes", hint)
    return key


def plan_episodes(config: EvaluationConfig) -> list[EpisodeItem]:
    """Return the episodes of an evaluation, task by task.

    Args:
        config: Settings of the evaluation. Without a key, the seeds of the policy are different in each call.

    Raises:
        UnknownName: A task does not exist.
    """
    config = as_record(config, EvaluationConfig, "config").with_key()
    tasks = [find_task(word) for word in config.tasks]
    names = [task.get_name() for task in tasks]
    if len(set(names)) < len(names):
        raise InvalidArgument("tasks", config.tasks, "have to have different names", "Remove one of the tasks with equal names.")
    items: list[EpisodeItem] = []
    with make_environment(config, expert_settings()) as environment:
        places = None if config.protocol is None else split_places(config.protocol, "test")
        for task in tasks:
            running, found_by, name = environment.get_task(task).task, task_reference(task), task.get_name()
            count = running.variation_count()
            drawn = _spread_places(config, count) if places is None else _protocol_places(name, count, places[name])
            planned = _task_episodes(config, found_by if is_task_file(task) else name, name, drawn)
            applicable = [setting for setting in config.factors if not FactorSetting.of(setting).why_not(running)]
            digest = task_digest(task)
            items += [replace(item, task_digest=digest, factors=s) for s in ("", *applicable) for item in planned]
    for setting in config.factors:
        if all(item.factors != setting for item in items):
            hint = "Leave it out, or name other tasks; `rlbench-pin factors TASK` prints the reason for a task."
            raise InvalidArgument("factors", setting, "cannot change any of the tasks", hint)
    return items


def found_task(item: EpisodeItem) -> type[Task]:
    """Return the class of the task of an item.

    Raises:
        TaskFilesChanged: The files of the task have changed since the episodes were planned.
    """
    task = find_task(item.task)
    if item.task_digest and task_digest(task) != item.task_digest:
        raise TaskFilesChanged(item.name)
    return task


def make_environment(config: EvaluationConfig, settings: PolicySettings) -> Environment:
    """Return an environment with the actions and observations of a policy."""
    mode, seen = settings.make_action_mode(), settings.make_obs_config()
    return Environment(mode, obs_config=seen, robot_setup=config.robot, seed=0)


def expert_settings() -> PolicySettings:
    """Return the settings of the `expert`: joint positions as actions, and low-dimensional observations."""
    return PolicySettings.of(MoveArmThenGripper(JointPosition(), Discrete()), low_dim_config())


def _spread_places(config: EvaluationConfig, count: int) -> list[tuple[int, int]]:
    """Return variation and seed of each episode of a task, spread evenly over its variations."""
    most = config.episodes if config.variations == ALL_VARIATIONS else min(config.variations, config.episodes)
    variations: Sequence[int] = drawn_variations(count, most)
    return [(variations[index % len(variations)], seed) for index, seed in enumerate(config.seeds())]


def _protocol_places(name: str, count: int, places: Sequence[Place]) -> list[tuple[int, int]]:
    """Return variation and seed of each episode of a task of a protocol."""
    if (last := max(variation for variation, _, _ in places)) >= count:
        raise InvalidArgument(f"variations of '{name}' in the protocol", last, f"have to be below {count}", "Correct its file.")
    return [(variation, evaluation_seed(seed, number)) for variation, seed, number in places]


def _task_episodes(config: EvaluationConfig, found_by: str, name: str, places: Sequence[tuple[int, int]]) -> list[EpisodeItem]:
    key = config.policy_seed_key or ""
    return [
        EpisodeItem(found_by, name, index, variation, seed, policy_seed(key, config.seed, name, index))
        for index, (variation, seed) in enumerate(places)
    ]
