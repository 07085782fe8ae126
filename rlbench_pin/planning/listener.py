"""What a planner reports about its calls: the interface of listeners, lists of listeners, and the listeners of one planner."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import Generic, Literal, TypeVar

from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.kinematics import PoseRegion
from rlbench_pin.planning.plan import Plan, Stages
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


ListenerT = TypeVar("ListenerT", bound=PlanningListener)
Report = Callable[[ListenerT, float, BaseException | None], None]
"""Calls one listener with the process time of a block [s], and the error that ended it, or None."""


class ListenerList(Generic[ListenerT]):
    """Listeners, each for the duration of a block; nothing is measured while there are none."""

    def __init__(self) -> None:
        self._listeners: list[ListenerT] = []

    @contextmanager
    def including(self, listener: ListenerT) -> Iterator[None]:
        """Report to `listener` as well, for the duration of a block."""
        self._listeners.append(listener)
        try:
            yield
        finally:
            self._listeners.remove(listener)

    @contextmanager
    def timed(self, report: Report[ListenerT], errors: type[BaseException] | tuple[()] = ()) -> Iterator[None]:
        """Report a block when it ends.

        Args:
            report: Is called for every listener.
            errors: Errors that are reported, too; a block that ends with another is not.
        """
        if not self._listeners:
            yield
            return
        began = time.process_time()
        try:
            yield
        except errors as error:
            self._report(report, time.process_time() - began, error)
            raise
        self._report(report, time.process_time() - began, None)

    def _report(self, report: Report[ListenerT], seconds: float, error: BaseException | None) -> None:
        for listener in self._listeners:
            report(listener, seconds, error)


class PlanningListeners(ListenerList[PlanningListener]):
    """The listeners of one planner."""

    def update(self, snapshot: WorldSnapshot) -> AbstractContextManager[None]:
        """Report the block as one update."""
        return self.timed(lambda listener, seconds, _: listener.on_update(snapshot, seconds))

    @contextmanager
    def plan(self, request: PlanRequest, stages: Stages) -> Iterator[Stages]:
        """Report the block as one planned motion: `stages.plan`, or the error that it raises."""

        def report(listener: PlanningListener, seconds: float, error: BaseException | None) -> None:
            outcome = error if isinstance(error, PlanningError) else stages.plan
            assert outcome is not None
            listener.on_plan(request, outcome, seconds)

        with self.timed(report, PlanningError):
            yield stages

    def reach(self) -> AbstractContextManager[None]:
        """Report the block as one search for a configuration, found or not."""
        return self.timed(lambda listener, seconds, _: listener.on_reach(seconds), BaseException)
