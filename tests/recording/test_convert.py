"""Demonstrations in other action spaces."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rlbench_pin.environment import (
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorVelocity,
    Environment,
    ERJointViaIK,
    JointPosition,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
)
from rlbench_pin.environment.actions.modes import ArmActionMode
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.environment.replay import reaches_goal
from rlbench_pin.errors import DemoError, InvalidActionError
from rlbench_pin.recording import convert_by_playing, convert_demo, verify
from rlbench_pin.robot import RobotModel

MODES = [
    JointPosition(),
    JointPosition(absolute_mode=False),
    JointVelocity(),
    EndEffectorPoseViaIK(),
    EndEffectorPoseViaIK(absolute_mode=False),
    EndEffectorPoseViaIK(frame="end effector"),
    EndEffectorVelocity(),
    EndEffectorVelocity(frame="end effector"),
]


@pytest.mark.simulation
@pytest.mark.parametrize("arm", MODES, ids=lambda a: f"{type(a).__name__}-{getattr(a, 'frame', '')}-{a.absolute_mode}")
def test_a_converted_demo_still_succeeds(arm: ArmActionMode) -> None:
    """Picking and lifting works again in another action space."""
    mode = MoveArmThenGripper(arm, Discrete())
    with Environment(mode, obs_config=low_dim_config(), seed=0) as env:
        task = env.get_task("pick_and_lift")
        (demo,) = task.get_demos(1, live_demos=True, seed=3)
        actions = convert_demo(demo, mode, task.runtime.model)
        assert len(actions) == len(demo) - 1
        assert all(action.shape == env.action_shape for action in actions)
        assert verify(task, demo, actions)


PLAYED = [JointTorque(), JointTorque(absolute_mode=False), JointVelocity(absolute_mode=False), EndEffectorVelocity(False)]


@pytest.mark.simulation
@pytest.mark.parametrize("arm", PLAYED, ids=lambda a: f"{type(a).__name__}-{a.absolute_mode}")
def test_torques_and_differences_are_found_by_playing(arm: ArmActionMode) -> None:
    """What drifts when it is worked out from the model alone succeeds when it was worked out from what was measured."""
    mode = MoveArmThenGripper(arm, Discrete())
    with Environment(mode, obs_config=low_dim_config(), seed=0) as env:
        task = env.get_task("pick_and_lift")
        (demo,) = task.get_demos(1, live_demos=True, seed=3)
        actions = convert_by_playing(task, demo)
        assert 1 < len(actions) <= len(demo) - 1
        assert all(action.shape == env.action_shape for action in actions)
        assert verify(task, demo, actions)


@pytest.mark.simulation
def test_actions_that_do_nothing_do_not_verify() -> None:
    """The check fails when the decisive action is left out."""
    mode = MoveArmThenGripper(JointPosition(), Discrete())
    with Environment(mode, obs_config=low_dim_config(), seed=0) as env:
        task = env.get_task("pick_and_lift")
        (demo,) = task.get_demos(1, live_demos=True, seed=3)
        actions = convert_demo(demo, mode, task.runtime.model)
        for action in actions:
            action[-1] = 1.0
        assert not verify(task, demo, actions)


def test_what_cannot_be_converted_says_so() -> None:
    """Elbow control and torque changes are refused by name."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config(), seed=0) as env:
        task = env.get_task("reach_target")
        (demo,) = task.get_demos(1, live_demos=True, seed=3)
        for arm in (ERJointViaIK(), JointTorque(absolute_mode=False)):
            with pytest.raises(InvalidActionError, match=type(arm).__name__):
                convert_demo(demo, MoveArmThenGripper(arm, Discrete()), task.runtime.model)


@pytest.mark.simulation
@pytest.mark.parametrize("arm", [JointPosition(), EndEffectorPoseViaIK()], ids=lambda a: type(a).__name__)
def test_another_arm_follows_the_tip(arm: ArmActionMode) -> None:
    """A demonstration of the Panda lifts the cube with the UR5e, in more ticks; one that reaches too far is refused."""
    mode = MoveArmThenGripper(arm, Discrete())
    with (
        make_environment(low_dim_config()) as first,
        Environment(mode, obs_config=low_dim_config(), robot_setup="ur5e", seed=0) as second,
    ):
        task, other = first.get_task("pick_and_lift"), second.get_task("pick_and_lift")
        (demo,) = task.get_demos(1, live_demos=True, seed=3)
        other.reset(seed=3)
        actions = convert_demo(demo, mode, task.runtime.model, robot=other.runtime.model)
        assert len(actions) > len(demo) - 1
        assert reaches_goal(other, actions)
        short = RobotModel(replace(other.runtime.model.description, base_pose=(5.0, 0.0, 0.75, 0.0, 0.0, 0.0, 1.0)))
        with pytest.raises(DemoError, match="'ur5e' follows the demonstration only to tick 0 of"):
            convert_demo(demo, mode, task.runtime.model, robot=short)
