"""A running task reports ticks, observations and segments to listeners."""

from __future__ import annotations

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.demos import DemoPlayer, Omission, try_play
from rlbench_pin.environment.runtime import Listener
from rlbench_pin.planning.plan import Plan
from rlbench_pin.tasks import Waypoint


class Record(Listener):
    """Counts the calls of its methods."""

    def __init__(self) -> None:
        self.ticks = self.observations = 0
        self.segments: list[tuple[int, str]] = []
        self.seconds = 0.0

    def on_tick(self, seconds: float) -> None:
        self.ticks += 1
        self.seconds += seconds

    def on_observe(self, seconds: float) -> None:
        self.observations += 1
        self.seconds += seconds

    def on_segment(self, waypoint: Waypoint, plan: Plan) -> None:
        self.segments.append((waypoint.index, plan.report.method))


def test_a_demonstration_is_reported_and_not_changed(reach: TaskEnvironment) -> None:
    """Every tick, frame and segment is reported while there is a listener; the demonstration has the same bytes."""
    plain = reach.try_demo(seed=0, variation=0)
    record = Record()
    with reach.runtime.listening(record):
        played = reach.try_demo(seed=0, variation=0)
    assert plain.demo is not None
    assert played.demo is not None
    assert record.ticks >= round(played.duration / reach.world.control_dt) > 0
    assert record.observations == len(played.demo)
    assert record.segments == [(segment.waypoint, segment.method) for segment in played.segments]
    assert record.seconds > 0.0
    for a, b in zip(plain.demo, played.demo, strict=True):
        assert a.get_low_dim_data().tobytes() == b.get_low_dim_data().tobytes()


def test_nothing_is_left_behind(reach: TaskEnvironment) -> None:
    """After the block no listener is called any more, and the world has no hooks left."""
    record = Record()
    with reach.runtime.listening(record):
        reach.runtime.step()
    reach.runtime.step()
    reach.get_observation()
    assert (record.ticks, record.observations) == (1, 0)
    assert reach.world.on_physics == reach.runtime.before_tick == []
    assert len(reach.runtime.after_tick) == 1  # the step of the task


def test_what_is_omitted_is_not_done(reach: TaskEnvironment) -> None:
    """A waypoint that is left out is neither planned nor visited."""
    reach.reset(seed=0, variation=0)
    player = DemoPlayer(reach.runtime, record=False, omit=Omission(waypoints=(0,)))
    cause, segment = try_play(player)
    assert "the goal was not reached" in cause
    assert segment == 0
    assert player.segments == []
