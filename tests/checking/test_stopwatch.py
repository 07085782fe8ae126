"""Where the time of a demonstration goes."""

from __future__ import annotations

import pytest

from rlbench_pin.checking.trials import Stopwatch
from rlbench_pin.environment.presets import low_dim_config, make_environment


@pytest.mark.simulation
def test_kinds_of_work_are_parts_of_the_whole() -> None:
    """Planning, physics and observing all take time, and together no more than there was; two demonstrations add up."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("reach_target")
        watch = Stopwatch()
        with watch.watching(task.runtime):
            outcome = task.try_demo(seed=0)
        assert outcome.demo is not None
        once, ticks = watch.total, watch.ticks
        assert all(seconds > 0.0 for seconds in watch.spent.values())
        assert sum(watch.spent.values()) < once
        assert ticks >= outcome.duration / task.world.control_dt
        task.try_demo(seed=0)
        assert watch.ticks == ticks
        with pytest.raises(ZeroDivisionError), watch.watching(task.runtime):
            task.try_demo(seed=0)
            raise ZeroDivisionError
        assert watch.ticks == 2 * ticks
        assert watch.total > once
