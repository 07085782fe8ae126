"""No accidental success: a demonstration without its decisive action reaches no goal."""

from __future__ import annotations

import pytest

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.demonstrate import DemoPlayer, Omission, try_play
from rlbench_pin.tasks import task_class

NO_GRASP = Omission(grasps=True)
OMISSIONS = {
    "beat_the_buzz": NO_GRASP,
    "close_microwave": Omission(waypoints=(1,)),
    "open_door": Omission(waypoints=(3, 4)),  # the swing alone also turns the lever, as the hand slides along it
    "open_oven": Omission(waypoints=(2, 3, 4)),
    "push_button": Omission(waypoints=(1,)),
    "push_buttons": Omission(waypoints=(1,)),
    "reach_target": Omission(waypoints=(0,)),
    "slide_block_to_target": Omission(waypoints=(1,)),
}
"""What each task cannot do without; grasping where nothing is said."""


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_without_its_decisive_action_it_fails(task_env: TaskEnvironment, seed: int) -> None:
    """The script runs as far as it can; the goal is not reached, at no moment of its last leg and not afterwards."""
    omit = OMISSIONS.get(task_env.get_name(), NO_GRASP)
    task_env.set_variation(-1)
    task_env.reset(seed=seed)
    cause, _ = try_play(DemoPlayer(task_env.runtime, record=False, omit=omit))
    assert cause, "reached without the decisive action"
    assert task_env.task.success()[0] is False
    task_env.set_variation(0)


@pytest.mark.parametrize("name", OMISSIONS)
def test_the_list_names_tasks_that_exist(name: str) -> None:
    """A renamed task must not lose its negative script."""
    assert task_class(name)
