"""Simulation is recorded frame by frame, and is what it is without being recorded; stored demonstrations are replayed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import cast

import numpy as np
import pytest

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import DemoError, GoalInCollision, NoIkSolution, TaskEnvironmentError, WaypointError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.tasks import Condition, find_task
from rlbench_pin.viewer.recording import Frame, FrameRecorder, failure_of, record_demonstration, recording_of_demo, success_texts


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("task", "texts"),
    [
        ("open_drawer", ("chest/drawer_bottom moved by more than 0.15",)),
        ("stack_blocks", ("at least 2 of block0, block1, block2, block3 inside column",)),
        ("push_button", ("in order (",)),
    ],
)
def test_conditions_say_what_they_ask_for(task: str, texts: tuple[str, ...]) -> None:
    """Each condition of the vocabulary has words, with the names of the scene."""
    with make_environment(low_dim_config()) as environment:
        running = environment.get_task(find_task(task))
        running.reset(seed=0, variation=0)
        said = success_texts(running.task)
    for text, begins in zip(said, texts, strict=False):
        assert text.startswith(begins)


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
    assert recording.instruction == "Move the gripper to the red ball."
    assert recording.conditions == ("tip inside goal",)
    assert [(segment.waypoint, segment.begins) for segment in recording.segments] == [("waypoint0", 0)]
    assert [recording.frames[0].conditions_met, recording.frames[-1].conditions_met] == [(False,), (True,)]
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
    assert recording.failure.cause.endswith("but the goal was not reached. Conditions not met: Count.")
    assert recording.frames[-1].conditions_met == (True, False)
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


@pytest.fixture(scope="module")
def demo(reach: TaskEnvironment) -> Demo:
    """A demonstration."""
    made = reach.try_demo(seed=3, variation=1).demo
    assert made is not None
    return made


def test_the_stored_motion_is_what_is_shown(reach: TaskEnvironment, demo: Demo) -> None:
    """Every stored frame is there, joint by joint, with the instruction of the demonstration and ways to its key frames."""
    recording = recording_of_demo(reach, demo)
    stored = np.array([observation.joint_positions for observation in demo])
    assert np.abs(np.array([frame.arm for frame in recording.frames]) - stored).max() < 1e-9
    assert recording.failure is None
    assert recording.frames[-1].success
    assert recording.instruction == demo.instructions[0]
    assert [(segment.waypoint, segment.begins) for segment in recording.segments] == [("key frame 1", 0)]


def test_without_actions_the_joint_positions_are_played(reach: TaskEnvironment, demo: Demo) -> None:
    """A demonstration of which only observations were kept is shown, too; one without any of them is refused."""
    kept = [observation.misc.pop("joint_position_action") for observation in demo[1:]]
    try:
        recording = recording_of_demo(reach, demo)
        assert len(recording.frames) == len(demo)
        assert recording.frames[-1].success
        opening, demo[5].gripper_open = demo[5].gripper_open, None
        with pytest.raises(DemoError, match="Frame 5 of the demonstration contains neither"):
            recording_of_demo(reach, demo)
        demo[5].gripper_open = opening
    finally:
        for observation, action in zip(demo[1:], kept, strict=True):
            observation.misc["joint_position_action"] = action


def test_a_demonstration_that_misses_its_goal_says_how_far_it_is_off(reach: TaskEnvironment, demo: Demo) -> None:
    """Actions that lead elsewhere are shown as far as they lead, with what does not hold."""
    kept = [observation.misc["joint_position_action"] for observation in demo[1:]]
    try:
        for observation in demo[1:]:
            observation.misc["joint_position_action"] = kept[0]
        failure = recording_of_demo(reach, demo).failure
    finally:
        for observation, action in zip(demo[1:], kept, strict=True):
            observation.misc["joint_position_action"] = action
    assert failure is not None
    assert "does not reach its goal" in failure.cause
    assert "rad from the stored ones" in failure.cause
    assert "Conditions not met: tip inside goal." in failure.cause


def test_another_task_is_refused(reach: TaskEnvironment, demo: Demo) -> None:
    """A demonstration belongs to its task."""
    other = Demo(list(demo), random_seed=3, task_name="open_drawer")
    with pytest.raises(TaskEnvironmentError, match="is of task 'open_drawer'"):
        recording_of_demo(reach, other)
