"""The worker of an evaluation. It plays an episode and returns its record, and keeps policy and environment between episodes."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from types import TracebackType

from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.evaluation.policies.client import PolicyClient, open_policy
from rlbench_pin.evaluation.policies.policy import PolicyFault
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.results.records import EpisodeRecord
from rlbench_pin.evaluation.run.config import (
    EXPERT,
    EpisodeItem,
    EvaluationConfig,
    expert_settings,
    found_task,
    make_environment,
)
from rlbench_pin.evaluation.run.episode import NO_DEMONSTRATION, Episode, EpisodeOutcome, Limits, make_context, shortened
from rlbench_pin.values import as_record

Around = Callable[[TaskEnvironment], AbstractContextManager[object]]
"""Makes a context around an episode from its start to its end, such as a video recorder."""
NOT_PLAYED = "not played"
"""The fault of an episode that failed for another reason than the policy, such as a failed reset."""


class EpisodeRunner:
    """Plays episodes, one after the other.

    Args:
        config: Settings of the evaluation.
        client: The policy; None opens the policy of `config`.

    Raises:
        PolicyReferenceError: The reference names no policy.
    """

    def __init__(self, config: EvaluationConfig, client: PolicyClient | None = None) -> None:
        self.config = as_record(config, EvaluationConfig, "config")
        self._client = client
        if client is None and config.policy != EXPERT:
            self._client = open_policy(config.policy, time_limit=config.time_limit, start_limit=config.start_limit)
        self._environment: Environment | None = None
        self._task: TaskEnvironment | None = None
        self._loaded = ""

    def make(self, item: EpisodeItem) -> EpisodeOutcome:
        """Play an episode; its record contains all faults."""
        return self.play(item)

    def play(self, item: EpisodeItem, around: Around = lambda task: nullcontext()) -> EpisodeOutcome:
        """Play an episode.

        Args:
            item: The episode.
            around: Makes a context around the episode, from its start to its end.
        """
        try:
            settings = self.settings()
            task = self._load(item, settings)
            task.set_factors(item.factors)
            instructions, seen = task.reset(seed=item.seed, variation=item.variation)
            episode = Episode(item, task)
            slowness = task.runtime.model.slowness
            limits = Limits.of(self.config, settings, task.action_mode, task.world.control_dt, slowness)
            with around(task), episode.meter.running():
                if self._client is None:
                    end, detail = episode.demonstrate(limits)
                    fault = NO_DEMONSTRATION if end == "fault" else ""
                else:
                    try:
                        context = make_context(self.config, item, task, limits)
                        end, fault, detail = episode.play(self._client, instructions[0], context, limits, seen), "", ""
                    except PolicyFault as error:
                        end, fault, detail = "fault", error.kind, error.detail
            lasts = end == "success" and task.success_is_stable()
            return EpisodeOutcome(item, episode.record(end, fault, detail, lasts=lasts), tuple(episode.action_times))
        except PolicyFault as error:  # it did not start
            return EpisodeOutcome(item, not_played(item, error.kind, error.detail))
        except Exception as error:  # a fault of one episode must not cost the others
            self._close_environment()
            return EpisodeOutcome(item, not_played(item, NOT_PLAYED, f"{type(error).__name__}: {error}"))

    def settings(self) -> PolicySettings:
        """Return the settings of the policy; the first call starts the policy.

        Raises:
            PolicyFault: The policy does not start.
            PolicyOfAnotherArm: The policy was made for the joints of another arm.
        """
        settings = expert_settings() if self._client is None else self._client.settings
        settings.check_robot(self.config.robot)
        return settings

    def close(self) -> None:
        """End the policy and free the environment; the next item makes both again."""
        self._close_environment()
        if self._client is not None:
            self._client.close()

    def __enter__(self) -> EpisodeRunner:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _load(self, item: EpisodeItem, settings: PolicySettings) -> TaskEnvironment:
        if self._task is None or self._loaded != item.task:
            chosen = found_task(item)
            if self._environment is None:
                self._environment = make_environment(self.config, settings)
            self._task, self._loaded = self._environment.get_task(chosen), item.task
        return self._task

    def _close_environment(self) -> None:
        if self._environment is not None:
            self._environment.shutdown()
        self._environment, self._task, self._loaded = None, None, ""


def not_played(item: EpisodeItem, fault: str, detail: str) -> EpisodeRecord:
    """Return the record of an episode that did not start, or was lost."""
    return EpisodeRecord(
        task=item.name, variation=item.variation, seed=item.seed, success=False, lasts=False, steps=0, seconds=0.0,
        end="fault", fault=fault, fault_detail=shortened(detail), factors=item.factors,
    )  # fmt: skip
