"""What a planner reports about its calls: the interface of listeners, and the listeners of one planner."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.kinematics.goals import PoseRegion
from rlbench_pin.planning.plan import Plan
from rlbench_pin.planning.stages import Stages
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray, PoseLike


@dataclass(frozen=True, eq=False)
class PlanRequest:
    """What a planner was asked for; its arrays are the caller's, so a listener that keeps one copies it."""

    kind: Literal["pose", "configuration", "curve"]
    """Which call: `plan_to_pose`, `plan_to_configuration` or `plan_curve`."""
    q_start: FloatArray
    """Where the arm is (n,), [rad]."""
    goal: PoseLike | Sequence[PoseLike] | PoseRegion
    """Tip poses (7,), one or several, or a region of them; for `configuration` joint positions (n,), [rad]."""
    ignore_collisions: bool
    """Whether the motion may touch anything."""
    allowed: tuple[str, ...]
    """Names of bodies that may be touched."""


class PlanningListener:
    """Is called when a call of a planner ends. The methods do nothing: override those that matter."""

    def on_update(self, snapshot: WorldSnapshot, seconds: float) -> None:
        """The planner took over the world.

        Args:
            snapshot: The world as it is now.
            seconds: Process time that it took [s].
        """

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        """A motion was planned, or could not be.

        Args:
            request: What was asked for.
            outcome: The plan, or the error that the caller is about to get.
            seconds: Process time that it took [s].
        """

    def on_reach(self, seconds: float) -> None:
        """A configuration at a pose was looked for, without a motion to it, in `seconds` [s] of process time."""


class PlanningListeners:
    """The listeners of one planner; nothing is measured while there are none."""

    def __init__(self) -> None:
        self._listeners: list[PlanningListener] = []

    @contextmanager
    def including(self, listener: PlanningListener) -> Iterator[None]:
        """Report to `listener` as well, for the duration of a block."""
        self._listeners.append(listener)
        try:
            yield
        finally:
            self._listeners.remove(listener)

    @contextmanager
    def update(self, snapshot: WorldSnapshot) -> Iterator[None]:
        """Report the block as one update."""
        if not self._listeners:
            yield
            return
        began = time.process_time()
        yield
        seconds = time.process_time() - began
        for listener in self._listeners:
            listener.on_update(snapshot, seconds)

    @contextmanager
    def plan(self, request: PlanRequest, stages: Stages) -> Iterator[Stages]:
        """Report the block as one planned motion: `stages.plan`, or the error that it raises."""
        if not self._listeners:
            yield stages
            return
        began = time.process_time()
        try:
            yield stages
        except PlanningError as error:
            self._report(request, error, time.process_time() - began)
            raise
        assert stages.plan is not None
        self._report(request, stages.plan, time.process_time() - began)

    @contextmanager
    def reach(self) -> Iterator[None]:
        """Report the block as one search for a configuration."""
        if not self._listeners:
            yield
            return
        began = time.process_time()
        try:
            yield
        finally:
            seconds = time.process_time() - began
            for listener in self._listeners:
                listener.on_reach(seconds)

    def _report(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        for listener in self._listeners:
            listener.on_plan(request, outcome, seconds)
