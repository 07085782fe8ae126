"""Resets and segments take the later waypoints into account."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from rlbench_pin.environment import reset
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.tasks import Waypoint, find_task


def test_a_reset_looks_at_every_round(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three draughtsmen are missing: the reset asks for three grasps, and begins the first round afterwards."""
    grasps = []
    check = reset.check_feasible

    def noting(planner: Any, waypoints: Sequence[Waypoint], *rest: Any) -> None:
        grasps.append(waypoints[1].pose.tobytes())
        check(planner, waypoints, *rest)

    monkeypatch.setattr(reset, "check_feasible", noting)
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(find_task("setup_checkers"))
        task.reset(seed=0, variation=2)
        assert len(set(grasps[-3:])) == 3
        assert task.task.round == 0
        assert task.runtime.world.frame("waypoint1").parent == f"piece{vars(task.task)['missing'][0]}"


@pytest.mark.simulation
def test_a_leg_ends_where_the_next_can_go_straight() -> None:
    """The nearest configuration before the spoke is one from which the mug could not be slid on in a line."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(find_task("place_cups"))
        outcome = task.try_demo(seed=22, variation=1, record=False)
        assert outcome.success, outcome.cause
        assert all(segment.method == "straight" for segment in outcome.segments if segment.waypoint in (4, 5))
