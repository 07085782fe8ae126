"""Episodes for another program that runs the policy. Observations and actions have the format of a mapping."""

from __future__ import annotations

from collections.abc import Sequence

from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import InvalidArgument
from rlbench_pin.evaluation.policies.mapping import MappingError, PolicyMapping
from rlbench_pin.evaluation.policies.policy import PolicyFault
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.policies.wire import validate_action
from rlbench_pin.evaluation.protocols.plan import check_policy
from rlbench_pin.evaluation.protocols.protocol import VARIATION, load_protocol
from rlbench_pin.evaluation.results.records import End
from rlbench_pin.evaluation.run.config import EpisodeItem, EvaluationConfig, found_task, make_environment, plan_episodes
from rlbench_pin.evaluation.run.episode import Episode, Limits
from rlbench_pin.evaluation.sets import resolve_tasks
from rlbench_pin.observation import Observation
from rlbench_pin.robot.description import robot_description
from rlbench_pin.values import as_choice, as_whole


def hosting_config(program: str, protocol: str | None, tasks: Sequence[str] | None, episodes: int | None) -> EvaluationConfig:
    """Return the settings of an evaluation that another program runs, from a protocol or a list of tasks.

    Args:
        program: Name of the program.
        protocol: Name of a protocol, or path of its TOML file; None for a list of tasks.
        tasks: Task names, files or sets; None for a protocol.
        episodes: Episodes of each task of the list; None is 25.

    Raises:
        InvalidArgument: Neither a protocol nor tasks are given, or both are; or `episodes` is given with a protocol.
        UnknownName: There is no such protocol or task.
    """
    if tasks is not None and protocol is None:
        return EvaluationConfig(policy=program, tasks=resolve_tasks(tasks), episodes=25 if episodes is None else episodes)
    if protocol is None or tasks is not None:
        hint = "Pass either a protocol, such as `peract18`, or a list of tasks."
        raise InvalidArgument("tasks", tasks, "are required without a protocol, and not allowed with one", hint)
    if episodes is not None:
        raise InvalidArgument("episodes", episodes, "are not allowed with a protocol, which fixes them", "Leave it out.")
    return EvaluationConfig.of_protocol(program, load_protocol(protocol))


class EpisodeHost:
    """Episodes for another program, with the start states, seeds and limits of `evaluate`.

    Args:
        config: Tasks, episodes and limits.
        mapping: Keys of observations and layout of actions.

    Attributes:
        rows: Name of a row of the results -> its episodes, in order. A row is a task, or a variation of a task, such as
            `open_drawer+2`, where the protocol counts episodes of each variation.

    Raises:
        ProtocolConflict: The mapping has other cameras, image sizes or actions than the protocol.
        MappingError: The mapping is for another number of joints than the arm has.
    """

    def __init__(self, config: EvaluationConfig, mapping: PolicyMapping) -> None:
        self.config, self.mapping = config, mapping
        self._settings = PolicySettings.of(mapping.action.action_mode(), mapping.obs_config(), mapping.max_steps)
        if config.protocol is not None:
            check_policy(config.protocol, f"mapping={mapping.source}", self._settings)
        layout, joints = mapping.action, len(robot_description(config.robot).arm_joints)
        if not layout.is_pose and layout.joints != joints:
            raise MappingError(
                f"{mapping.source}: 'action.joints'",
                layout.joints,
                f"has to be {joints} for '{config.robot}'",
                "Use another one.",
            )
        of_variation = config.protocol is not None and config.protocol.episodes_of == VARIATION
        self.rows: dict[str, list[EpisodeItem]] = {}
        for item in plan_episodes(config):
            self.rows.setdefault(f"{item.name}+{item.variation}" if of_variation else item.name, []).append(item)
        self._environment: Environment | None = None
        self._task: TaskEnvironment | None = None
        self._loaded = ""
        self._episode: Episode | None = None
        self._seen: Observation | None = None
        self._end: End | None = None

    @property
    def max_steps(self) -> int | None:
        """Maximum number of actions of an episode; None if only the simulated time is limited."""
        return self.config.max_steps or self.mapping.max_steps

    @property
    def end(self) -> End | None:
        """Kind of the end of the current episode; None while it continues."""
        return self._end

    def reset(self, row: str, index: int) -> tuple[str, Observation]:
        """Start an episode.

        Args:
            row: A name of `rows`.
            index: Number of the episode in the row.

        Returns:
            The instruction and the first observation.

        Raises:
            UnknownName: There is no such row.
            InvalidArgument: The row has fewer episodes.
            ResetError: The task could not be placed.
        """
        items = self.rows[as_choice(row, "task", tuple(self.rows))]
        if as_whole(index, "episode", InvalidArgument, least=0) >= len(items):
            raise InvalidArgument("episode", index, f"of '{row}' has to be below {len(items)}", "Request fewer episodes.")
        item = items[index]
        self._episode, self._end = None, None
        try:
            task = self._load(item)
            task.set_factors(item.factors)
            instructions, self._seen = task.reset(seed=item.seed, variation=item.variation)
        except Exception:
            self.close()  # the next episode begins in a new environment
            raise
        slowness = task.runtime.model.slowness
        self._limits = Limits.of(self.config, self._settings, task.action_mode, task.world.control_dt, slowness)
        self._episode = Episode(item, task)
        return instructions[0], self._seen

    def step(self, reply: object) -> tuple[Observation, End | None]:
        """Play the action in a reply of the policy.

        A refused action, such as a pose that cannot be reached, moves nothing and counts as an action, as in `evaluate`.

        Args:
            reply: A map with the key of the mapping's actions; under it one action, shape (size,) or (1, size).

        Returns:
            The observation, and the kind of end, or None if the episode continues.

        Raises:
            InvalidArgument: No episode is running.
            PolicyFault: The reply has no such action.
        """
        if self._episode is None or self._seen is None or self._end is not None:
            raise InvalidArgument("step", None, "needs a running episode", "Call `reset` first.")
        try:
            chunk = self.mapping.chunk(reply, most=2)
            if len(chunk) > 1:
                raise ValueError(f"'{self.mapping.action.key}' has several actions. Send one at a time.")
            action = validate_action(self.mapping.action.decode(chunk[0]))
        except ValueError as error:
            raise PolicyFault("wrong answer", str(error)) from error
        self._seen, self._end = self._episode.advance(action, self._limits, self._seen)
        return self._seen, self._end

    def success_is_stable(self) -> bool:
        """Return whether the episode ended with success that still holds after 1 s with the arm stationary."""
        return self._end == "success" and self._task is not None and self._task.success_is_stable()

    def close(self) -> None:
        """Free the environment; `reset` makes it again."""
        environment, self._environment = self._environment, None
        self._task, self._loaded, self._episode = None, "", None
        if environment is not None:
            environment.shutdown()

    def _load(self, item: EpisodeItem) -> TaskEnvironment:
        if self._task is None or self._loaded != item.task:
            if self._environment is None:
                self._environment = make_environment(self.config, self._settings)
            self._task, self._loaded = self._environment.get_task(found_task(item)), item.task
        return self._task
