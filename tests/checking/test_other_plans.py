"""The scene of a failed demonstration is tried again with other plans."""

from __future__ import annotations

import pytest

from rlbench_pin.checking.validate import demo_bytes, solved_by_other_plans
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.environment.runtime import Listener
from rlbench_pin.errors import DemoError
from rlbench_pin.planning.plan import Plan
from rlbench_pin.tasks import Waypoint


class _FailsTwice(Listener):
    """Ends the first two demonstrations before their first segment, and notes where each began."""

    def __init__(self, task: TaskEnvironment) -> None:
        self._task = task
        self.worlds: list[bytes] = []
        self.draws: list[float] = []

    def on_segment(self, waypoint: Waypoint, plan: Plan) -> None:
        """Note, or fail."""
        if waypoint.index == 0:
            self.worlds.append(self._task.world.bodies["block"].position.tobytes())
            self.draws.append(float(self._task.runtime.planning_rng.random()))
        if len(self.worlds) < 3:
            raise DemoError("Not yet.", self._task.task)


@pytest.mark.simulation
def test_other_plans_start_in_the_very_scene_and_draw_other_numbers() -> None:
    """Each try begins in the same world, with draws of its own, until one succeeds; the seed itself stays as it was."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("pick_and_lift")
        before = task.try_demo(seed=3, variation=1).demo
        assert before is not None
        fails = _FailsTwice(task)
        with task.runtime.listening(fails):
            assert not solved_by_other_plans(task, 3, 1, 2)
            assert solved_by_other_plans(task, 3, 1, 4)
        assert len(fails.worlds) == 3
        assert len(set(fails.worlds)) == 1
        assert fails.draws[2] == fails.draws[0] != fails.draws[1]
        after = task.try_demo(seed=3, variation=1).demo
        assert after is not None
        assert demo_bytes(after) == demo_bytes(before)
