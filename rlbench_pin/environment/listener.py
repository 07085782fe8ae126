"""What a running task reports: plans, control ticks, observations and the legs of a demonstration.

`Runtime.listening` calls a listener for the duration of a block; a listener changes nothing that it is called for.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

from rlbench_pin.planning.listener import ListenerList, PlanningListener
from rlbench_pin.planning.plan import Plan
from rlbench_pin.sim import World
from rlbench_pin.tasks import Waypoint


class Listener(PlanningListener):
    """Is called for what a runtime does. The methods do nothing: override those that matter."""

    def on_tick(self, seconds: float) -> None:
        """A control tick was simulated, in `seconds` [s] of process time."""

    def on_observe(self, seconds: float) -> None:
        """An observation was made, in `seconds` [s] of process time."""

    def on_leg(self, waypoint: Waypoint, plan: Plan) -> None:
        """The motion to a waypoint of a demonstration was chosen and is about to begin."""


class Listeners(ListenerList[Listener]):
    """The listeners of one runtime."""

    def observe(self) -> AbstractContextManager[None]:
        """Report the block as one observation."""
        return self.timed(lambda listener, seconds, _: listener.on_observe(seconds))

    def leg(self, waypoint: Waypoint, plan: Plan) -> None:
        """Report that the motion to a waypoint is about to begin."""
        for listener in self._listeners:
            listener.on_leg(waypoint, plan)


@contextmanager
def timed_ticks(world: World, on_tick: Callable[[float], None]) -> Iterator[None]:
    """Call `on_tick` after every control tick of a block with the process time since its first physics step began [s]."""
    began: list[float] = []

    def before_physics() -> None:
        if not began:
            began.append(time.process_time())

    def after_tick() -> None:
        on_tick(time.process_time() - began.pop())

    world.on_physics.insert(0, before_physics)
    world.on_step.append(after_tick)
    try:
        yield
    finally:
        world.on_physics.remove(before_physics)
        world.on_step.remove(after_tick)
