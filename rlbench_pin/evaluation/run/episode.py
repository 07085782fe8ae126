"""One episode: what a policy does in it, step by step, and the record of it."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from rlbench_pin.environment.demos import DemoPlayer, try_play
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.evaluation.policies.client import PolicyClient
from rlbench_pin.evaluation.policies.policy import PolicyContext, PolicyFault
from rlbench_pin.evaluation.results.records import End, EpisodeRecord
from rlbench_pin.evaluation.run.config import EpisodeItem, EvaluationConfig
from rlbench_pin.evaluation.run.limits import Limits
from rlbench_pin.evaluation.run.meter import Meter
from rlbench_pin.observation import Observation

LONGEST_DETAIL = 500
"""Letters that a record keeps of what was said of a fault."""
NO_DEMONSTRATION = "no demonstration"
"""The fault of the expert."""


@dataclass(frozen=True)
class EpisodeOutcome:
    """What came of one episode."""

    item: EpisodeItem
    """What was played."""
    record: EpisodeRecord
    """What it came to: the same wherever it is played."""
    action_times: tuple[float, ...] = ()
    """How long the policy took for each answer [s]."""


@dataclass
class Episode:
    """An episode under way.

    Args:
        item: Which one.
        task: Its task, loaded.
    """

    item: EpisodeItem
    task: TaskEnvironment
    meter: Meter = field(init=False)
    steps: int = 0
    """Actions so far, refused ones among them."""
    refused: Counter[str] = field(default_factory=Counter)
    """Cause -> actions refused so far."""
    action_times: list[float] = field(default_factory=list)
    """Time of each answer so far [s]."""

    def __post_init__(self) -> None:
        """Count from now on."""
        self.meter = Meter(self.task.runtime)
        self._began = self.task.world.ticks

    @property
    def ticks(self) -> int:
        """Control ticks since the start."""
        return self.task.world.ticks - self._began

    def play(self, client: PolicyClient, instruction: str, context: PolicyContext, limits: Limits, seen: Observation) -> End:
        """Let a policy act until the episode is over, and say how it ended.

        Args:
            client: The policy.
            instruction: What it is told to do.
            context: What it is told beside that.
            limits: Where the episode is cut off. A refused action counts as one control tick.
            seen: The first observation.

        Raises:
            PolicyFault: The policy failed.
        """
        period = self.task.world.control_dt
        client.reset(instruction, context)
        while True:
            action = self._asked(client, seen)
            try:
                seen, _, over = self.task.step(action)
            except InvalidActionError as error:
                if error.cause == "wrong shape":
                    detail = f"an action of shape {action.shape}, where ({len(context.action_low)},) is needed."
                    raise PolicyFault("wrong answer", detail) from error
                self.refused[error.cause] += 1
                over = False
            self.steps += 1
            if over:
                return "success" if self.task.succeeded else "failed"
            if (self.ticks + sum(self.refused.values())) * period >= limits.seconds - 1e-9:
                return "seconds"
            if self.steps >= limits.steps:
                return "steps"

    def _asked(self, client: PolicyClient, seen: Observation) -> np.ndarray:
        began = time.perf_counter()
        try:
            return client.act(seen)
        finally:
            self.action_times.append(time.perf_counter() - began)

    def demonstrate(self, limits: Limits) -> tuple[End, str]:
        """Play the demonstration of this very seed once; return how it ended, and why there is none."""
        cause, _ = try_play(DemoPlayer(self.task.runtime, record=False))
        self.steps = self.ticks
        if cause:
            return "fault", cause
        late = self.ticks * self.task.world.control_dt > limits.seconds + 1e-9
        return ("seconds" if late else "success"), ""

    def record(self, end: End, fault: str = "", detail: str = "", *, lasts: bool = False) -> EpisodeRecord:
        """Return what the episode came to."""
        return EpisodeRecord(
            task=self.item.name,
            variation=self.item.variation,
            seed=self.item.seed,
            success=end == "success",
            lasts=lasts,
            steps=self.steps,
            seconds=round(self.ticks * self.task.world.control_dt, 6),
            end=end,
            refused=dict(sorted(self.refused.items())),
            collisions=self.meter.collisions,
            max_force=round(self.meter.max_force, 3),
            violations=dict(sorted(self.meter.violations.items())),
            fault=fault,
            fault_detail=shortened(detail),
        )


def make_context(config: EvaluationConfig, item: EpisodeItem, task: TaskEnvironment, limits: Limits) -> PolicyContext:
    """Return what a policy is told at the start of an episode."""
    low, high = task.action_bounds()
    return PolicyContext(
        robot=config.robot,
        joints=task.runtime.model.size,
        action_low=tuple(low.tolist()),
        action_high=tuple(high.tolist()),
        control_period=task.world.control_dt,
        max_steps=limits.steps,
        seed=item.policy_seed,
        task=item.name if config.tell_task else "",
    )


def shortened(text: str) -> str:
    """Return the end of a long text, where errors say what happened."""
    return text if len(text) <= LONGEST_DETAIL else f"...{text[3 - LONGEST_DETAIL :]}"
