"""A planner reports its calls to listeners."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import NoIkSolution, PlanningError
from rlbench_pin.planning.plan import ListenerList, Plan, PlanningListener, PlanRequest
from rlbench_pin.planning.planner import MotionPlanner
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import pose_at
from tests.worlds_for_tests import HOME, TABLE_TOP, Boxes

GOAL = pose_at((0.35, 0.25, TABLE_TOP + 0.1), np.pi, 0.0, np.pi)
TOO_FAR = pose_at((1.5, 0.0, 1.0), np.pi, 0.0, np.pi)


class Record(PlanningListener):
    """Keeps what it is called with."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.plans: list[tuple[PlanRequest, Plan | PlanningError]] = []
        self.seconds = 0.0

    def on_update(self, snapshot: WorldSnapshot, seconds: float) -> None:
        self.calls.append("update")
        self.seconds += seconds

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        self.calls.append(request.kind)
        self.plans.append((request, outcome))
        self.seconds += seconds

    def on_reach(self, seconds: float) -> None:
        self.calls.append("reach")
        self.seconds += seconds


def test_every_call_is_reported_once(model: RobotModel, boxes: Boxes, rng: np.random.Generator) -> None:
    """Each with what was asked for and what came of it, only while there is a listener."""
    planner, record = MotionPlanner(model), Record()
    with planner.listeners.including(record):
        planner.update(boxes.snapshot())
        plan = planner.plan_to_pose(HOME, GOAL, allowed=("table",), rng=rng)
        planner.plan_to_configuration(HOME, plan.path[-1], rng=rng)
        planner.plan_curve(HOME, [GOAL])
        planner.reachable(HOME, GOAL, rng)
    planner.plan_to_pose(HOME, GOAL, rng=rng)
    assert record.calls == ["update", "pose", "configuration", "curve", "reach"]
    request, outcome = record.plans[0]
    assert outcome is plan
    assert request.q_start is HOME
    assert request.goal is GOAL
    assert request.allowed == ("table",)
    assert [request.ignore_collisions for request, _ in record.plans] == [False, False, True]
    assert record.seconds > 0.0


def test_failures_are_reported_and_raised(model: RobotModel, rng: np.random.Generator) -> None:
    """The listener gets the same error as the caller."""
    planner, record = MotionPlanner(model), Record()
    with planner.listeners.including(record):
        with pytest.raises(NoIkSolution) as caught:
            planner.plan_to_pose(HOME, TOO_FAR, rng=rng)
        with pytest.raises(NoIkSolution):
            planner.reachable(HOME, TOO_FAR, rng)
    assert record.plans[0][1] is caught.value
    assert record.calls == ["pose", "reach"]


def test_listening_changes_no_plan(model: RobotModel, boxes: Boxes) -> None:
    """The same generator state gives the same plan, whoever listens."""
    plans = []
    for listener in (None, PlanningListener()):
        planner = MotionPlanner(model)
        planner.update(boxes.snapshot(boxes.screen()))
        if listener is None:
            plans.append(planner.plan_to_pose(HOME, GOAL, rng=np.random.default_rng(3)))
            continue
        with planner.listeners.including(listener):
            plans.append(planner.plan_to_pose(HOME, GOAL, rng=np.random.default_rng(3)))
    assert plans[0].trajectory.q.tobytes() == plans[1].trajectory.q.tobytes()


def test_a_block_that_raises_is_reported_only_for_the_errors_named() -> None:
    """Every listener gets the same time and the error; other errors pass without a report."""
    listeners = ListenerList[PlanningListener]()
    reports: list[tuple[PlanningListener, float, BaseException | None]] = []

    def run(error: Exception) -> None:
        with listeners.timed(lambda *report: reports.append(report), KeyError):
            raise error

    first, second, known = Record(), Record(), KeyError("known")
    with pytest.raises(KeyError):
        run(known)
    assert reports == []
    with listeners.including(first), listeners.including(second):
        with pytest.raises(KeyError):
            run(known)
        with pytest.raises(ValueError, match="another"):
            run(ValueError("another"))
    seconds = reports[0][1]
    assert reports == [(first, seconds, known), (second, seconds, known)]
