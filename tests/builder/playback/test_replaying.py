"""Stored demonstrations are played again frame by frame."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.builder.playback.replaying import recording_of_demo
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.errors import DemoError, TaskEnvironmentError
from rlbench_pin.observation import Demo


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
    assert [(leg.waypoint, leg.begins) for leg in recording.legs] == [("key frame 1", 0)]


def test_without_actions_the_joint_positions_are_played(reach: TaskEnvironment, demo: Demo) -> None:
    """A demonstration of which only observations were kept is shown, too; one without any of them is refused."""
    kept = [observation.misc.pop("joint_position_action") for observation in demo[1:]]
    try:
        recording = recording_of_demo(reach, demo)
        assert len(recording.frames) == len(demo)
        assert recording.frames[-1].success
        opening, demo[5].gripper_open = demo[5].gripper_open, None
        with pytest.raises(DemoError, match="Frame 5 of the demonstration holds neither"):
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
    assert "What does not hold: tip inside goal." in failure.cause


def test_another_task_is_refused(reach: TaskEnvironment, demo: Demo) -> None:
    """A demonstration belongs to its task."""
    other = Demo(list(demo), random_seed=3, task_name="open_drawer")
    with pytest.raises(TaskEnvironmentError, match="shows 'open_drawer'"):
        recording_of_demo(reach, other)
