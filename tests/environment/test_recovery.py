"""Recovery demonstrations: one disturbance, and success from where it leads to."""

from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest

from rlbench_pin import (
    Demo,
    Discrete,
    EndEffectorPoseViaPlanning,
    Environment,
    MoveArmThenGripper,
    TaskEnvironment,
)
from rlbench_pin.datasets import key_frames
from rlbench_pin.environment import low_dim_config
from rlbench_pin.environment.recovery import PUSH
from rlbench_pin.environment.replay import replay_succeeds
from rlbench_pin.errors import InvalidArgument
from rlbench_pin.observation import Disturbance


def disturbed(task: TaskEnvironment, kind: Disturbance, seed: int) -> Demo:
    outcome = task.try_demo(seed=seed, disturb=(kind,))
    assert outcome.demo is not None, outcome.cause
    return outcome.demo


def phases(demo: Demo) -> list[str]:
    """Phases in order, each once for a run of frames."""
    return [phase for phase, _ in groupby(frame.misc["phase"] for frame in demo)]


@pytest.mark.simulation
@pytest.mark.parametrize("kind", ["push", "slip", "stop"])
def test_the_goal_is_reached_after_a_disturbance(lift: TaskEnvironment, kind: Disturbance) -> None:
    """One disturbance, then recovery; only that is an intervention. The recorded actions reach the goal when replayed."""
    for seed in (1, 2, 3):
        demo = disturbed(lift, kind, seed)
        found = phases(demo)
        assert found[:3] == ["task", kind, "recovery"]
        assert found[3:] in ([], ["task"])
        assert all(frame.misc["intervention"] is (frame.misc["phase"] == "recovery") for frame in demo)
        lift.reset_to_demo(demo)
        assert replay_succeeds(lift, demo)


@pytest.mark.simulation
def test_a_push_moves_the_gripper(reach: TaskEnvironment) -> None:
    """By 3 cm, give or take what it moved on by itself; the episode is another one than without."""
    demo = disturbed(reach, "push", 4)
    tips = np.array([frame.gripper_pose[:3] for frame in demo if frame.gripper_pose is not None])
    pushed = [i for i, frame in enumerate(demo) if frame.misc["phase"] == "push"]
    moved = np.linalg.norm(tips[pushed[-1]] - tips[pushed[0] - 1])
    assert 0.5 * PUSH < moved < 2.0 * PUSH
    plain = reach.try_demo(seed=4).demo
    assert plain is not None
    assert "phase" not in plain[0].misc
    assert len(plain) < len(demo)


@pytest.mark.simulation
def test_what_slips_is_grasped_again(lift: TaskEnvironment) -> None:
    """The fingers are open after the slip, and the object is held at the end."""
    demo = disturbed(lift, "slip", 1)
    slip = next(i for i, frame in enumerate(demo) if frame.misc["phase"] == "slip")
    assert demo[slip - 1].gripper_open == 0.0
    assert demo[slip].gripper_open == 1.0
    assert demo[-1].gripper_open == 0.0
    assert lift.runtime.gripper.held


@pytest.mark.simulation
def test_equal_seeds_give_equal_bytes(lift: TaskEnvironment) -> None:
    """Kind, moment and direction follow from the seed; another attempt draws others."""
    first, again = (lift.try_demo(seed=6, disturb=("push", "slip", "stop")).demo for _ in range(2))
    other = lift.try_demo(seed=6, attempt=1, disturb=("push", "slip", "stop")).demo
    assert first is not None
    assert again is not None
    assert other is not None
    assert [f.get_low_dim_data().tobytes() for f in first] == [f.get_low_dim_data().tobytes() for f in again]
    assert [f.misc["phase"] for f in first] == [f.misc["phase"] for f in again]
    assert [f.misc["phase"] for f in first] != [f.misc["phase"] for f in other]


@pytest.mark.simulation
def test_key_frames_leave_the_disturbance_out(lift: TaskEnvironment) -> None:
    """Nobody learns to let go or to go aside."""
    demo = disturbed(lift, "slip", 1)
    frames = key_frames(demo)
    assert all(demo[i].misc["phase"] in ("task", "recovery") for i in frames)


@pytest.mark.simulation
def test_a_slip_needs_something_that_is_gripped(reach: TaskEnvironment) -> None:
    """Without, the demonstration fails and says so, unless something else may happen."""
    outcome = reach.try_demo(seed=0, disturb=("slip",))
    assert not outcome.success
    assert "No segment of the demonstration allows slip" in outcome.cause
    other = reach.try_demo(seed=0, disturb=("slip", "stop")).demo
    assert other is not None
    assert "stop" in phases(other)


def test_an_unknown_disturbance_is_refused(reach: TaskEnvironment) -> None:
    """With those that there are."""
    with pytest.raises(InvalidArgument, match="push, slip, stop"):
        reach.try_demo(seed=0, disturb=("shove",))  # type: ignore[arg-type]


@pytest.mark.simulation
@pytest.mark.slow
def test_most_tasks_recover() -> None:
    """At least 80 % of the tasks with something to grip, after pushes and after slips."""
    from rlbench_pin.tasks import library_names

    with Environment(MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()), obs_config=low_dim_config(), seed=0) as env:
        for kind in ("push", "slip"):
            outcomes = []
            for name in library_names():
                outcome = env.get_task(name).try_demo(seed=90_000, variation=0, record=False, disturb=(kind,))  # type: ignore[arg-type]
                if "No segment of the demonstration allows" not in outcome.cause:
                    outcomes.append(outcome.success)
            assert np.mean(outcomes) >= 0.8


@pytest.mark.simulation
def test_get_demos_makes_them_with_any_action_mode() -> None:
    """Also where actions are poses to plan for."""
    with Environment(MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()), obs_config=low_dim_config(), seed=0) as env:
        demos = env.get_task("push_button").get_demos(1, live_demos=True, seed=3, disturb=("stop",))
    assert phases(demos[0])[1:3] == ["stop", "recovery"]
