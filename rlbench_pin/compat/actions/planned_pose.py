"""The pose action that plans: with a flag for collisions, a second try without checks, and a callback for every step."""

from __future__ import annotations

from collections.abc import Callable

from rlbench_pin.compat import arm_planning
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.compat.unwrap import SceneLike, runtime_of
from rlbench_pin.environment.motion import follow
from rlbench_pin.errors import InvalidActionError, PlanningError
from rlbench_pin.observation import Observation
from rlbench_pin.planning import Plan
from rlbench_pin.spatial import FloatArray

OnStep = Callable[[Observation], object]


def plan_motion(target: FloatArray, ignore_collisions: bool, second_try: bool) -> Plan:
    """Plan a motion of the tip to a world pose (7,).

    Args:
        target: Where to.
        ignore_collisions: Plan as if nothing could be touched.
        second_try: Where a plan with checks is refused, plan without.

    Raises:
        InvalidActionError: There is no motion.
    """
    runtime = Simulator.current().runtime
    runtime.check_target_in_workspace(target[:3])
    try:
        return arm_planning.plan_to(Simulator.current(), target, straight=None, ignore_collisions=ignore_collisions)
    except PlanningError as error:
        if second_try and not ignore_collisions:
            return plan_motion(target, True, False)
        raise InvalidActionError(f"No motion to the target pose: {error}") from error


def run(scene: SceneLike, plan: Plan, on_step: OnStep | None) -> None:
    """Follow a plan to its end, or until the task is done; with a callback always to its end.

    Args:
        scene: What moves.
        plan: The motion.
        on_step: Called with an observation after every step.
    """
    runtime = runtime_of(scene)
    if on_step is None:
        follow(runtime, plan.trajectory, until=lambda: bool(runtime.task.success()[0]))
    else:

        def record(target: FloatArray) -> None:
            """Hand over what is seen after a step."""
            on_step(scene.get_observation())

        follow(runtime, plan.trajectory, on_tick=record)
