"""One episode of an evaluation: its limits, its counters, and its play."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from rlbench_pin.environment.actions import ActionMode, EndEffectorPoseViaPlanning, unwrapped
from rlbench_pin.environment.demos import DemoPlayer, try_play
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.evaluation.policies.client import PolicyClient
from rlbench_pin.evaluation.policies.policy import PolicyContext, PolicyFault
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.results.records import End, EpisodeRecord
from rlbench_pin.evaluation.run.config import EpisodeItem, EvaluationConfig
from rlbench_pin.observation import Observation

KEY_FRAMES = 25
"""Default maximum number of actions of an episode if each action plans a motion to a pose."""
MIN_FORCE = 1.0
"""Smallest force of a contact that counts [N]."""
APART = 5
"""Number of control ticks without contact after which a new contact with the same body is another collision."""
POSITION_TOLERANCE = 1e-3
"""Distance beyond its limit from which a joint position is a violation [rad], or [m]."""
VELOCITY_TOLERANCE = 0.01
"""Share of its limit by which a joint velocity must exceed the limit to be a violation."""
POSITION, VELOCITY = "joint position", "joint velocity"
LONGEST_DETAIL = 500
"""Maximum number of characters of the detail of a fault in a record."""
NO_DEMONSTRATION = "no demonstration"
"""The fault of the expert."""


@dataclass(frozen=True)
class Limits:
    """Limits of an episode."""

    steps: int
    """Maximum number of actions."""
    seconds: float
    """Maximum simulated time [s]."""

    @classmethod
    def of(
        cls, config: EvaluationConfig, settings: PolicySettings, mode: ActionMode, control_period: float, slowness: float = 1.0
    ) -> Limits:
        """Return the limits of a policy's episodes.

        Args:
            config: Settings of the user, with the highest priority.
            settings: Suggestions of the policy, with the second priority.
            mode: Action mode. Without other numbers: 25 actions if it plans motions to poses, otherwise one action per tick.
            control_period: Time of a control tick [s].
            slowness: Factor of the time limit for the arm, see `RobotModel.slowness`.
        """
        seconds = config.max_seconds * slowness
        ticks = math.ceil(seconds / control_period)
        usual = KEY_FRAMES if isinstance(unwrapped(mode.arm_action_mode), EndEffectorPoseViaPlanning) else ticks
        return cls(config.max_steps or settings.max_steps or usual, seconds)


@dataclass
class Meter:
    """Counts collisions and violations of limits of one episode, in every physics step and control tick.

    A collision is a contact of the arm or the gripper with a body that the gripper does not hold. The hand link may touch
    graspable bodies. Contacts of the fingers with bodies of the task are part of the task, so fingers collide only with the room:
    table, walls, floor.
    """

    runtime: Runtime
    collisions: int = 0
    """Number of collisions."""
    max_force: float = 0.0
    """Largest normal force of arm and gripper together on one such body, in any physics step [N]."""
    violations: dict[str, int] = field(default_factory=dict)
    """Limit -> number of control ticks at whose end a joint was beyond it."""

    def __post_init__(self) -> None:
        self._arm, self._limits = self.runtime.description, self.runtime.model.limits
        self._room = frozenset(self.runtime.world.room)
        self._ticks = 0
        self._last: dict[str, int] = {}
        self._touched: set[str] = set()

    @contextmanager
    def running(self) -> Iterator[Meter]:
        world = self.runtime.world
        world.on_physics.insert(0, self._after_physics)
        try:
            with self.runtime.calling(after=self._after_tick):
                yield self
        finally:
            world.on_physics.remove(self._after_physics)

    def _after_physics(self) -> None:
        """Read the contacts of the previous physics step."""
        forces: dict[str, float] = {}
        for (link, body), force in self.runtime.robot.contact_forces().items():
            if not self._may_touch(link, body):
                forces[body] = forces.get(body, 0.0) + force
        for body, force in forces.items():
            if force >= MIN_FORCE:
                self._touched.add(body)
                self.max_force = max(self.max_force, force)

    def _may_touch(self, link: str, body: str) -> bool:
        if body in self.runtime.gripper.grasped:
            return True
        if link in self.runtime.model.fingers.links[1:]:
            return body not in self._room
        return link == self._arm.hand_link and body in self.runtime.task.get_graspable_objects()

    def _after_tick(self) -> None:
        self._after_physics()
        self._ticks += 1
        for body in self._touched:
            if self._ticks - self._last.get(body, -APART - 1) > APART:
                self.collisions += 1
            self._last[body] = self._ticks
        self._touched.clear()
        q, v = self.runtime.robot.joint_positions, self.runtime.robot.joint_velocities
        if not self._limits.contains(q, POSITION_TOLERANCE):
            self._count(POSITION)
        if bool(np.any(np.abs(v) > (1.0 + VELOCITY_TOLERANCE) * self._limits.velocity)):
            self._count(VELOCITY)

    def _count(self, limit: str) -> None:
        self.violations[limit] = self.violations.get(limit, 0) + 1


@dataclass(frozen=True)
class EpisodeOutcome:
    """Outcome of one episode."""

    item: EpisodeItem
    """The planned episode."""
    record: EpisodeRecord
    """Its record, which is the same in every process."""
    action_times: tuple[float, ...] = ()
    """Time of the policy for each answer [s]."""


@dataclass
class Episode:
    """A running episode.

    Args:
        item: The planned episode.
        task: Environment with its task.
    """

    item: EpisodeItem
    task: TaskEnvironment
    meter: Meter = field(init=False)
    steps: int = 0
    """Number of actions so far, including refused actions."""
    refused: Counter[str] = field(default_factory=Counter)
    """Cause -> number of refused actions so far."""
    action_times: list[float] = field(default_factory=list)
    """Time of each answer so far [s]."""

    def __post_init__(self) -> None:
        self.meter = Meter(self.task.runtime)
        self._began = self.task.world.ticks

    @property
    def ticks(self) -> int:
        """Control ticks since the start."""
        return self.task.world.ticks - self._began

    def play(self, client: PolicyClient, instruction: str, context: PolicyContext, limits: Limits, seen: Observation) -> End:
        """Let a policy act until the episode ends, and return the kind of end.

        Args:
            client: The policy.
            instruction: Instruction for the policy.
            context: Context for the policy.
            limits: Limits of the episode. A refused action counts as one control tick.
            seen: The first observation.

        Raises:
            PolicyFault: The policy failed.
        """
        client.reset(instruction, context)
        while True:
            action = self._asked(client, seen)
            try:
                seen, end = self.advance(action, limits, seen)
            except InvalidActionError as error:
                detail = f"an action has the shape {action.shape}; it must be ({len(context.action_low)},)."
                raise PolicyFault("wrong answer", detail) from error
            if end is not None:
                return end

    def advance(self, action: np.ndarray, limits: Limits, seen: Observation) -> tuple[Observation, End | None]:
        """Play one action.

        Args:
            action: The action, in the form of the action mode.
            limits: Limits of the episode. A refused action counts as one control tick.
            seen: The observation before the action.

        Returns:
            The observation after the action, or the previous one if the action was refused; and the kind of end, or None if the
            episode continues.

        Raises:
            InvalidActionError: The action has the wrong shape; the world is unchanged.
        """
        over = False
        try:
            seen, _, over = self.task.step(action)
        except InvalidActionError as error:
            if error.cause == "wrong shape":
                raise
            self.refused[error.cause] += 1
        self.steps += 1
        if over:
            return seen, "success" if self.task.succeeded else "failed"
        if (self.ticks + sum(self.refused.values())) * self.task.world.control_dt >= limits.seconds - 1e-9:
            return seen, "seconds"
        return seen, "steps" if self.steps >= limits.steps else None

    def _asked(self, client: PolicyClient, seen: Observation) -> np.ndarray:
        began = time.perf_counter()
        try:
            return client.act(seen)
        finally:
            self.action_times.append(time.perf_counter() - began)

    def demonstrate(self, limits: Limits) -> tuple[End, str]:
        """Play the demonstration of this seed once; return the kind of end, and the cause of a failure."""
        cause, _ = try_play(DemoPlayer(self.task.runtime, record=False))
        self.steps = self.ticks
        if cause:
            return "fault", cause
        late = self.ticks * self.task.world.control_dt > limits.seconds + 1e-9
        return ("seconds" if late else "success"), ""

    def record(self, end: End, fault: str = "", detail: str = "", *, lasts: bool = False) -> EpisodeRecord:
        """Return the record of the episode."""
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
            factors=self.item.factors,
        )


def make_context(config: EvaluationConfig, item: EpisodeItem, task: TaskEnvironment, limits: Limits) -> PolicyContext:
    """Return the context of a policy at the start of an episode."""
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
    """Return the end of a long text, because errors state the cause there."""
    return text if len(text) <= LONGEST_DETAIL else f"...{text[3 - LONGEST_DETAIL :]}"
