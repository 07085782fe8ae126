"""Simulation is recorded frame by frame, and is what it is without being recorded."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import cast

import numpy as np
import pytest

from rlbench_pin.builder.contracts import Frame
from rlbench_pin.builder.playback.failures import failure_of
from rlbench_pin.builder.playback.recorder import FrameRecorder, record_demonstration
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.errors import GoalInCollision, NoIkSolution, WaypointError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.tasks import Condition


def _bytes(observation: Observation) -> dict[str, bytes]:
    return {name: value.tobytes() for name, value in vars(observation).items() if isinstance(value, np.ndarray)}


def _same(a: Demo | None, b: Demo | None) -> bool:
    return a is not None and b is not None and [_bytes(o) for o in a] == [_bytes(o) for o in b]


def test_a_recorded_episode_has_the_bytes_of_an_unrecorded_one(reach: TaskEnvironment) -> None:
    """Looking at every tick changes no observation."""
    plain = reach.try_demo(seed=3, variation=0)
    with FrameRecorder(reach.runtime):
        recorded = reach.try_demo(seed=3, variation=0)
    assert _same(plain.demo, recorded.demo)


def test_a_demonstration_is_recorded(reach: TaskEnvironment) -> None:
    """There is one frame for the reset and one for each tick, each as the demonstration observed it."""
    seen: list[Frame] = []
    recording = record_demonstration(reach, 3, 0, seen.append)
    demo = reach.try_demo(seed=3, variation=0).demo
    assert demo is not None
    assert len(recording.frames) == len(demo) == len(seen)
    assert [frame.time for frame in recording.frames] == pytest.approx([0.05 * i for i in range(len(demo))])
    for frame, observation in zip(recording.frames, demo, strict=True):
        assert frame.arm.tolist() == np.asarray(observation.joint_positions).tolist()
        assert frame.velocities.tolist() == np.asarray(observation.joint_velocities).tolist()
    assert recording.failure is None
    assert recording.instruction == "Move the hand to the red ball."
    assert recording.conditions == ("tip inside goal",)
    assert [(leg.waypoint, leg.begins) for leg in recording.legs] == [("waypoint0", 0)]
    assert [recording.frames[0].held, recording.frames[-1].held] == [(False,), (True,)]
    assert recording.frames[-1].success


def test_a_frame_has_every_link_and_what_was_painted(reach: TaskEnvironment) -> None:
    """Links that are only seen have poses, too; the ball is red, as this variation asks."""
    frame = record_demonstration(reach, 3, 0).frames[0]
    world = reach.world
    assert set(frame.poses) == {f"{name}/{link}" for name, body in world.bodies.items() for link in body.links}
    assert any(color[:3] == (1.0, 0.0, 0.0) for color in frame.colors.values())


class Count(Condition):
    """Counts how often it was asked; never holds."""

    def __init__(self) -> None:
        self.asked = 0

    def met(self) -> bool:
        """Count, and say no."""
        self.asked += 1
        return False

    def reset(self) -> None:
        """Begin at 0."""
        self.asked = 0

    def state(self) -> int:
        """Return the count."""
        return self.asked

    def set_state(self, state: object) -> None:
        """Set the count."""
        self.asked = cast(int, state)


@contextmanager
def asked_as_well(reach: TaskEnvironment, condition: Condition) -> Iterator[None]:
    """Ask for one more condition for the duration of a block."""
    before = reach.task.get_success_conditions()
    reach.task.register_success_conditions([*before, condition])
    try:
        yield
    finally:
        reach.task.register_success_conditions(before)


def test_what_a_condition_remembers_is_not_changed_by_looking(reach: TaskEnvironment) -> None:
    """A condition that counts has counted the same, recorded or not; the failure says what does not hold."""
    with asked_as_well(reach, count := Count()):
        assert not reach.try_demo(seed=3, variation=0).success
        unrecorded = count.asked
        recording = record_demonstration(reach, 3, 0)
    assert count.asked == unrecorded > 10
    assert recording.failure is not None
    assert recording.failure.cause.endswith("but the goal was not reached. What does not hold: Count.")
    assert recording.frames[-1].held == (True, False)
    assert not recording.frames[-1].success


def test_what_a_listener_raises_ends_the_recording(reach: TaskEnvironment) -> None:
    """Who looks on can stop a demonstration; afterwards nothing is recorded any more."""
    seen: list[Frame] = []

    def stop_at_fifth(frame: Frame) -> None:
        seen.append(frame)
        if len(seen) == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        record_demonstration(reach, 3, 0, stop_at_fifth)
    reach.runtime.step()
    assert len(seen) == 5


def test_an_error_of_inverse_kinematics_brings_the_nearest_pose(reach: TaskEnvironment) -> None:
    """The pose stands in the error itself or in what it was raised from; pairs likewise."""
    nearest = np.array([0.5, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0])
    far = NoIkSolution(np.ones(7), 0.1, 0.2, 8, nearest)
    out_of_reach = WaypointError("Waypoint waypoint0 cannot be reached.")
    out_of_reach.__cause__ = far
    failure = failure_of(out_of_reach, "waypoint0", reach.task)
    assert failure.nearest is not None
    assert np.array_equal(failure.nearest, nearest)
    assert (failure.waypoint, failure.pairs) == ("waypoint0", ())
    touching = failure_of(GoalInCollision([("hand", "table")], 3), "waypoint1", reach.task)
    assert (touching.pairs, touching.nearest) == ((("hand", "table"),), None)
