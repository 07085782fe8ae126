"""Key frames: each clause of the rule, on made-up demonstrations and on a live one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from rlbench_pin import Demo, Discrete, Environment, JointPosition, MoveArmThenGripper, Observation
from rlbench_pin.datasets import key_frames
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.errors import DatasetError

FAST, REST = 0.5, 0.0


def demo_of(speeds: Sequence[float], openings: str | None = None) -> Demo:
    """A demo in which one joint moves at given speeds; `o` is an open gripper, `c` a closed one; open by default."""
    letters = openings or "o" * len(speeds)
    return Demo(
        [
            Observation(joint_velocities=np.array([0.0, speed, 0.0]), gripper_open=float(letter == "o"))
            for speed, letter in zip(speeds, letters, strict=True)
        ]
    )


def moving(length: int, *stops: int) -> list[float]:
    """Speeds of a motion that rests at some frames."""
    return [REST if i in stops else FAST for i in range(length)]


def test_the_last_frame_is_one_and_the_first_is_none() -> None:
    """Whether the arm rests there or not; a demonstration of one frame has none."""
    assert key_frames(demo_of(moving(12))) == [11]
    assert key_frames(demo_of(moving(12, 0, 11))) == [11]
    assert key_frames(demo_of(moving(2))) == [1]
    assert key_frames(demo_of(moving(1))) == []


def test_a_change_of_the_hand_is_one() -> None:
    """Opening and closing, however fast the arm is."""
    assert key_frames(demo_of(moving(12), "ooooccccoooo")) == [4, 8, 11]


def test_a_stop_is_one() -> None:
    """All joints within the threshold, in either direction; one joint above it is a motion."""
    assert key_frames(demo_of(moving(12, 5))) == [5, 11]
    for speed, expected in ((0.1, [5, 11]), (-0.1, [5, 11]), (0.11, [11]), (-0.11, [11])):
        assert key_frames(demo_of([*moving(5), speed, *moving(6)])) == expected
    slow = demo_of([*moving(5), 0.3, *moving(6)])
    assert key_frames(slow, max_speed=0.3) == [5, 11]
    assert key_frames(slow, max_speed=0.29) == [11]


@pytest.mark.parametrize(("change", "is_stop"), [(4, True), (5, False), (6, False), (7, False), (8, True)])
def test_a_stop_needs_a_hand_that_does_not_change(change: int, is_stop: bool) -> None:
    """A stop at frame 6 counts when the gripper is the same in frames 4 to 7."""
    keys = key_frames(demo_of(moving(14, 6), "o" * change + "c" * (14 - change)))
    assert keys == sorted({change, 13} | ({6} if is_stop else set()))


def test_a_stop_is_none_of_the_last_two_frames() -> None:
    """The last but one is no stop; the one before it may be."""
    assert key_frames(demo_of(moving(12, 10))) == [11]
    assert key_frames(demo_of(moving(12, 9))) == [9, 11]


def test_frames_after_a_stop_are_none() -> None:
    """The four that follow a stop are not, the fifth is again; the number is an argument."""
    assert key_frames(demo_of(moving(20, 5, 6, 7, 8, 9))) == [5, 19]
    assert key_frames(demo_of(moving(20, 5, 10))) == [5, 10, 19]
    assert key_frames(demo_of(moving(20, *range(3, 16)))) == [3, 8, 13, 19]
    assert key_frames(demo_of(moving(20, 5, 6, 7, 8)), frames_between_stops=2) == [5, 8, 19]
    assert key_frames(demo_of(moving(20, 5, 6)), frames_between_stops=0) == [5, 6, 19]


def test_of_two_at_the_end_the_earlier_is_left_out() -> None:
    """Only where they follow each other directly, and only there."""
    assert key_frames(demo_of(moving(12), "o" * 10 + "cc")) == [11]
    assert key_frames(demo_of(moving(12), "o" * 9 + "ccc")) == [9, 11]
    assert key_frames(demo_of(moving(12), "ooooco" + "o" * 6)) == [4, 5, 11]


def test_frames_before_the_first_are_the_last_ones() -> None:
    """A resting first frame keeps the next four from being stops, unless the gripper ends otherwise than it begins."""
    start = moving(20, 0, 1, 2)
    assert key_frames(demo_of(start)) == [19]
    assert key_frames(demo_of(start, "o" * 10 + "c" * 10)) == [2, 10, 19]
    assert key_frames(demo_of(start, "o" * 10 + "c" * 9 + "o")) == [1, 10, 19]


def test_a_missing_field_is_named() -> None:
    """With the frame and the setting that records it."""
    demo = demo_of(moving(5))
    demo[3].joint_velocities = None
    with pytest.raises(DatasetError, match=r"Frame 3 has no joint_velocities.*ObservationConfig\.joint_velocities"):
        key_frames(demo)
    demo = demo_of(moving(5))
    demo[2].gripper_open = None
    with pytest.raises(DatasetError, match="Frame 2 has no gripper_open"):
        key_frames(demo)


@pytest.mark.simulation
def test_a_live_demonstration() -> None:
    """Key frames are where the segment above the lid ends, where the gripper has closed on it, and the end."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config()) as environment:
        outcome = environment.get_task("take_lid_off_saucepan").try_demo(seed=0)
    assert outcome.demo is not None
    demo, segments = outcome.demo, outcome.segments
    above = round(segments[0].duration / 0.05)
    at_lid = above + round(segments[1].duration / 0.05)
    (closed,) = (i for i in range(1, len(demo)) if demo[i].gripper_open != demo[i - 1].gripper_open)
    keys = key_frames(demo)
    assert keys[1:] == [closed, len(demo) - 1]
    assert abs(keys[0] - above) <= 1
    assert 0 <= closed - at_lid <= 3
