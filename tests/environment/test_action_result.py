"""Success and fail lists are asked after every control tick, in every mode; what ends the episode ends the action."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from rlbench_pin.datasets import key_frame_actions
from rlbench_pin.environment import (
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    Environment,
    ERJointViaIK,
    MoveArmThenGripper,
    SafeArm,
    TaskEnvironment,
)
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.tasks.conditions import Condition

pytestmark = pytest.mark.simulation
ARMS = {
    "planning": EndEffectorPoseViaPlanning(),
    "ik": EndEffectorPoseViaIK(),
    "elbow": ERJointViaIK(commanded_joints=()),
    "safe": SafeArm(EndEffectorPoseViaIK()),
}


class Glimpse(Condition):
    """Holds in one tick alone, the `tick`-th from now on."""

    def __init__(self, task: TaskEnvironment, tick: int) -> None:
        self.task, self.tick = task, tick
        self.start = task.world.time
        self.asked: list[int] = []

    def met(self) -> bool:
        """Whether the tick has come."""
        self.asked.append(round((self.task.world.time - self.start) / self.task.world.control_dt))
        return self.asked[-1] == self.tick


@pytest.fixture(params=ARMS)
def reach(request: pytest.FixtureRequest) -> Iterator[TaskEnvironment]:
    """`reach_target` with one arm mode whose actions take many ticks, at the start of an episode."""
    with Environment(MoveArmThenGripper(ARMS[request.param], Discrete()), obs_config=low_dim_config()) as env:
        task = env.get_task("reach_target")
        task.reset(seed=3)
        yield task


def aside(task: TaskEnvironment) -> np.ndarray:
    """Return an action that leads the tip 0.15 m to the side, far from targets that count, and closes the gripper."""
    pose = task.world.robot.tip_pose()
    pose[1] += 0.15
    return np.append(pose, 0.0)


def ticks(task: TaskEnvironment, since: float) -> int:
    return round((task.world.time - since) / task.world.control_dt)


def test_a_goal_passed_within_an_action_counts(reach: TaskEnvironment) -> None:
    """The action ends at the tick that reached the goal, with reward 1; fingers stay as they are."""
    glimpse = Glimpse(reach, 3)
    reach.task.register_success_conditions([glimpse])
    _, reward, over = reach.step(aside(reach))
    assert (reward, over, reach.succeeded) == (1.0, True, True)
    assert glimpse.asked == [1, 2, 3]
    assert ticks(reach, glimpse.start) == 3
    assert reach.runtime.gripper.is_open


def test_a_rule_broken_within_an_action_ends_it(reach: TaskEnvironment) -> None:
    """The fail list is met for one tick: no reward, though the goal would be reached by the end of the action."""
    glimpse, goal = Glimpse(reach, 4), Glimpse(reach, 6)
    reach.task.register_success_conditions([goal])
    reach.task.register_fail_conditions([glimpse])
    _, reward, over = reach.step(aside(reach))
    assert (reward, over, reach.succeeded) == (0.0, True, False)
    assert ticks(reach, glimpse.start) == 4


def test_fingers_are_watched_too(reach: TaskEnvironment) -> None:
    """A goal that is reached while the gripper closes ends the motion of the fingers."""
    here = np.append(reach.world.robot.tip_pose(), 0.0)
    start = reach.world.time
    reach.step(here)
    whole = ticks(reach, start)
    reach.reset(seed=3)
    glimpse = Glimpse(reach, whole - 1)
    reach.task.register_success_conditions([glimpse])
    _, reward, _ = reach.step(here)
    assert reward == 1.0
    assert ticks(reach, glimpse.start) == whole - 1


def test_outside_of_actions_nobody_is_asked(reach: TaskEnvironment) -> None:
    """Stepping the runtime by hand asks nothing, and an action without a tick is asked about once."""
    glimpse = Glimpse(reach, 0)
    reach.task.register_success_conditions([glimpse])
    reach.runtime.step()
    assert glimpse.asked == []
    with reach.runtime.acting() as result:
        pass
    assert glimpse.asked == [1]
    assert not result.over
    assert not reach.runtime.over


def test_a_lasting_success_is_told_from_one_of_an_instant(reach: TaskEnvironment) -> None:
    """The tip at the target stays there; a goal of one tick does not last; nothing has changed afterwards."""
    reach.reset(seed=3)
    assert not reach.success_is_stable()
    target = reach.world.body("target").position
    reach.step(np.concatenate([target, reach.world.robot.tip_pose()[3:], [1.0]]))
    assert reach.succeeded
    before, clock = vars(reach.get_observation()), reach.world.time
    assert reach.success_is_stable()
    assert reach.world.time == clock
    for name, value in vars(reach.get_observation()).items():
        if isinstance(value, np.ndarray) and name != "joint_forces":  # which the motors tell after a tick
            assert np.array_equal(value, before[name]), name
    reach.task.register_success_conditions([Glimpse(reach, 0)])
    assert not reach.success_is_stable()


def test_a_wand_dragged_along_the_rod_gets_no_reward() -> None:
    """One planned motion leads the ring to the right end, against the rod on the way: it stops there, and the episode is over."""
    with Environment(MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()), obs_config=low_dim_config()) as env:
        task = env.get_task("beat_the_buzz")
        demo = task.get_demos(1, live_demos=True, seed=4)[0]
        task.reset_to_demo(demo)
        approach, grasp, _, end, _ = key_frame_actions(demo)
        task.step(approach)
        assert task.step(grasp)[1:] == (0.0, False)
        end[2] -= 0.03
        began = task.world.time
        assert task.step(end)[1:] == (0.0, True)
        assert 0.1 < task.world.time - began < 1.0
        assert task.world.body("wand").position[0] < task.world.sensor("end").pose[0] - 0.03
