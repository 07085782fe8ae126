"""Honesty by construction: a demonstration without its decisive deed reaches no goal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import pytest

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.demonstrate import DemoPlayer, try_play
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.tasks import Waypoint, task_class


@dataclass(frozen=True)
class LeftOut:
    """What a negative script leaves out."""

    legs: tuple[int, ...] = ()
    """Waypoints that are not travelled to."""
    grips: bool = True
    """Whether the hand closes on things."""


NO_GRIP = LeftOut(grips=False)
DEEDS = {
    "beat_the_buzz": NO_GRIP,
    "close_microwave": LeftOut(legs=(1,)),
    "open_door": LeftOut(legs=(3,)),  # the swing alone also turns the lever, as the hand slides along it
    "open_oven": LeftOut(legs=(2,)),
    "push_button": LeftOut(legs=(1,)),
    "push_buttons": LeftOut(legs=(1,)),
    "reach_target": LeftOut(legs=(0,)),
    "slide_block_to_target": LeftOut(legs=(1,)),
}
"""The deed of each task; not gripping where nothing is said."""


class Negative(DemoPlayer):
    """Plays a demonstration with something left out."""

    def __init__(self, runtime: Runtime, left_out: LeftOut) -> None:
        super().__init__(runtime, record=False)
        self.left_out = left_out

    def _run_leg(self, waypoint: Waypoint, turns: Sequence[float]) -> None:
        if waypoint.index not in self.left_out.legs:
            super()._run_leg(waypoint, turns)

    def _operate_gripper(self, waypoint: Waypoint) -> None:
        if waypoint.releases or self.left_out.grips:
            super()._operate_gripper(waypoint)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_without_the_deed_there_is_no_success(task_env: TaskEnvironment, seed: int) -> None:
    """The script runs as far as it can; the goal is not reached, at no moment of its last leg and not afterwards."""
    left_out = DEEDS.get(task_env.get_name(), NO_GRIP)
    task_env.set_variation(-1)
    task_env.reset(seed=seed)
    cause, _ = try_play(Negative(task_env.runtime, left_out))
    assert cause, "reached without the deed"
    assert task_env.task.success()[0] is False
    task_env.set_variation(0)


@pytest.mark.parametrize("name", DEEDS)
def test_the_list_names_tasks_that_exist(name: str) -> None:
    """A renamed task must not lose its negative script."""
    assert task_class(name)
