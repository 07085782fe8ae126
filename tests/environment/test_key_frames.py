"""Key frames of live demonstrations: the flag that they carry, where it is stored, and that they reach the goal again."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin import (
    Demo,
    Discrete,
    EndEffectorPoseViaPlanning,
    Environment,
    MoveArmThenGripper,
    Observation,
    ObservationConfig,
    SafeArm,
    TaskEnvironment,
)
from rlbench_pin.datasets import key_frame_actions, read_demo
from rlbench_pin.datasets.writer import write_demo
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.environment.replay import key_frames_succeed
from rlbench_pin.errors import DemoError, InvalidActionError
from rlbench_pin.planning import MotionPlanner

LID = "take_lid_off_saucepan"


def environment(mode: EndEffectorPoseViaPlanning | SafeArm, config: ObservationConfig | None = None) -> Environment:
    """An environment whose actions are tip poses by planning."""
    return Environment(MoveArmThenGripper(mode, Discrete()), obs_config=config or low_dim_config(), seed=0)


@pytest.fixture(scope="module")
def task() -> Iterator[TaskEnvironment]:
    """The lid, with actions that are planned again without checks where they are refused."""
    with environment(EndEffectorPoseViaPlanning(retry_without_checks=True)) as env:
        yield env.get_task(LID)


@pytest.fixture(scope="module")
def demo(task: TaskEnvironment) -> Demo:
    """A demonstration: two segments that avoid collisions, and one up with the lid that ignores them."""
    return task.get_demos(1, live_demos=True, seed=3)[0]


def test_every_frame_says_how_its_leg_was_planned(demo: Demo) -> None:
    """Frames up to the closed gripper belong to segments with checks, later ones to the segment without; so do stored ones."""
    flags = [frame.ignore_collisions for frame in demo]
    assert flags == sorted(flags) and flags[0] is False and flags[-1] is True
    closed = [i for i, frame in enumerate(demo) if frame.gripper_open == 0.0]
    assert flags.index(True) == closed[0] + 1


def test_the_flag_is_stored(demo: Demo, tmp_path: Path) -> None:
    """Reading an episode file gives it back."""
    write_demo(demo, tmp_path / "episode.hdf5")
    assert [f.ignore_collisions for f in read_demo(tmp_path / "episode.hdf5")] == [f.ignore_collisions for f in demo]


def test_without_the_setting_there_is_no_flag() -> None:
    """`record_ignore_collisions=False` leaves observations as they are known."""
    config = low_dim_config()
    config.record_ignore_collisions = False
    with environment(EndEffectorPoseViaPlanning(), config) as env:
        frames = env.get_task(LID).get_demos(1, live_demos=True, seed=3)[0]
    assert all("ignore_collisions" not in vars(frame) for frame in frames)
    assert Observation().ignore_collisions is None


def test_key_frames_reach_the_goal(task: TaskEnvironment, demo: Demo) -> None:
    """One action of nine numbers for each key frame; the joints go where they went in the demonstration."""
    actions = key_frame_actions(demo)
    assert {action.shape for action in actions} == {(9,)}
    task.reset_to_demo(demo)
    assert key_frames_succeed(task, demo)
    task.reset_to_demo(demo)
    first, _, _ = task.step(actions[0])
    there = np.abs(np.array([frame.joint_positions for frame in demo]) - first.joint_positions).max(axis=1)
    assert there.min() < 0.01


def test_a_demonstration_without_flags_has_no_such_actions(demo: Demo) -> None:
    """The error names the frame and what it lacks."""
    bare = [
        Observation(joint_velocities=f.joint_velocities, gripper_open=f.gripper_open, gripper_pose=f.gripper_pose) for f in demo
    ]
    with pytest.raises(DemoError, match="lacks `gripper_pose`, `gripper_open` or `ignore_collisions`"):
        key_frame_actions(Demo(bare))


# The ninth number --------------------------------------------------------------------------------------------------------


class Asked:
    """What planners are asked: the `ignore_collisions` of every plan."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.flags: list[bool] = []
        plan = MotionPlanner.plan_to_pose

        def spy(planner: MotionPlanner, *args: object, **settings: object) -> object:
            self.flags.append(bool(settings["ignore_collisions"]))
            return plan(planner, *args, **settings)  # type: ignore[arg-type]

        monkeypatch.setattr(MotionPlanner, "plan_to_pose", spy)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Asked:
    """Watch the planners."""
    return Asked(monkeypatch)


ABOVE = [0.3, 0.0, 1.2, 0.0, 1.0, 0.0, 0.0]


@pytest.mark.parametrize("checking", [False, True])
@pytest.mark.parametrize("wrapped", [False, True])
def test_it_counts_instead_of_the_setting(asked: Asked, checking: bool, wrapped: bool) -> None:
    """Eight numbers leave it to `collision_checking`, a ninth says it; also behind the safety filter."""
    mode = EndEffectorPoseViaPlanning(collision_checking=checking)
    with environment(SafeArm(mode) if wrapped else mode) as env:
        task = env.get_task("reach_target")
        for more, expected in (([], not checking), ([1.0], True), ([0], False)):
            task.reset(seed=1)
            task.step([*ABOVE, 1.0, *more])
            assert asked.flags.pop() is expected
        mode.action(task.runtime, ABOVE, ignore_collisions=True)
        assert asked.flags.pop() is True
        assert task.action_bounds()[0].shape == (8,)


@pytest.mark.parametrize("bad", [[2.0], [-0.1], [np.nan], [1.0, 1.0]])
def test_other_numbers_are_refused(task: TaskEnvironment, bad: list[float]) -> None:
    """Nothing has moved then."""
    before, _ = task.reset(seed=1)[1].joint_positions, None
    with pytest.raises(InvalidActionError):
        task.step([*ABOVE, 1.0, *bad])
    np.testing.assert_array_equal(task.get_observation().joint_positions, before)


def test_modes_that_do_not_plan_take_no_ninth_number() -> None:
    """The error names the shape that is taken."""
    with Environment(MoveArmThenGripper(SafeArm(EndEffectorPoseViaPlanning()), Discrete()), obs_config=low_dim_config()) as env:
        task = env.get_task("reach_target")
        task.reset(seed=0)
        with pytest.raises(InvalidActionError, match=r"\(8,\) or \(9,\), not \(10,\)"):
            task.step([*ABOVE, 1.0, 0.0, 0.0])


def test_a_refused_plan_is_made_without_checks_when_asked(task: TaskEnvironment) -> None:
    """Down into the lid there is no free motion: refused as a rule, run with `retry_without_checks`."""
    _, obs = task.reset(seed=1)
    into = np.concatenate([task.world.body("saucepan").position + [0.0, 0.0, 0.05], ABOVE[3:], [1.0, 0.0]])
    strict = MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete())
    with pytest.raises(InvalidActionError, match="No motion"):
        strict.action(task.runtime, into)
    np.testing.assert_array_equal(task.get_observation().joint_positions, obs.joint_positions)
    moved, _, _ = task.step(into)
    assert np.abs(moved.joint_positions - obs.joint_positions).max() > 0.1
