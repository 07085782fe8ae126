"""The pose action that plans: with a flag for collisions, a second try without checks, and a callback for every step.

The arm of the scene is asked for the path, so an arm whose `get_path` a program replaced, or whose pace it changed, moves so.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from pyrep.errors import ConfigurationPathError
from pyrep.robots.arms import Panda
from pyrep.robots.configuration_paths import ArmConfigurationPath
from rlbench_pin.compat.unwrap import SceneLike, runtime_of
from rlbench_pin.environment.motion import follow
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import FloatArray

OnStep = Callable[[Observation], object]
SEARCH = {"trials": 100, "max_configs": 10, "max_time_ms": 10, "trials_per_goal": 5}
"""What arms are asked for besides; the arm of this package has a budget of its own."""


class Followed(Protocol):
    """A path that is followed by `step()` and a step of the scene in turn, until it says that it is done."""

    def step(self) -> bool:
        """Command the next part."""
        ...


def plan_motion(scene: SceneLike, target: FloatArray, ignore_collisions: bool, second_try: bool) -> Followed:
    """Ask the arm for a path of the tip to a world pose (7,).

    Args:
        scene: What moves.
        target: Where to.
        ignore_collisions: Plan as if nothing could be touched.
        second_try: Where a plan with checks is refused, plan without.

    Raises:
        InvalidActionError: There is no motion.
    """
    runtime_of(scene).check_target_in_workspace(target[:3])
    arm: Any = Panda() if isinstance(scene, Runtime) else scene.robot.arm
    try:
        path: Followed = arm.get_path(target[:3], quaternion=target[3:], ignore_collisions=ignore_collisions, **SEARCH)
    except ConfigurationPathError as error:
        if second_try and not ignore_collisions:
            return plan_motion(scene, target, True, False)
        raise InvalidActionError(f"No motion to the target pose: {error.__cause__ or error}") from error
    return path


def run(scene: SceneLike, path: Followed, on_step: OnStep | None) -> None:
    """Follow a path to its end, or until the episode is over; with a callback always to its end.

    Args:
        scene: What moves.
        path: The motion.
        on_step: Called with an observation after every step.
    """
    runtime = runtime_of(scene)

    def show() -> None:
        """Hand over what is seen after a step."""
        if on_step is not None:
            on_step(scene.get_observation())

    if isinstance(path, ArmConfigurationPath):
        follow(runtime, path.trajectory, on_tick=lambda target: show(), whole=on_step is not None)
        return
    done = False
    while not done:
        done = bool(path.step())
        scene.step()
        show()
        done = done or (runtime.over and on_step is None)
