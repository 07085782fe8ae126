"""What is refused: actions that cannot be done, malformed ones, options and arguments that make no sense."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence

import rlbench_pin
from rlbench_pin.environment import Discrete, EndEffectorPoseViaPlanning, JointVelocity, MoveArmThenGripper
from rlbench_pin.errors import (
    InvalidActionError,
    InvalidArgument,
    NoShapedReward,
    RlbenchPinError,
    TaskEnvironmentError,
    UnknownArgument,
    UnknownName,
)
from rlbench_pin.gym import GymnasiumEnv

OUT_OF_REACH = np.array([0.7, 0.6, 1.7, 0.0, 0.0, 0.0, 1.0, 1.0])


def test_a_refused_pose_is_reported_and_changes_nothing(reach_poses: GymnasiumEnv) -> None:
    """A pose out of reach gives reward 0, the same observation and the reason, and the episode goes on."""
    before, _ = reach_poses.reset(seed=0)
    after, reward, terminated, truncated, info = reach_poses.step(OUT_OF_REACH)
    assert (reward, terminated, truncated, info["success"]) == (0.0, False, False, False)
    assert "pose" in info["error"]
    assert data_equivalence(before, after, exact=True)


@pytest.mark.simulation
def test_a_refused_pose_may_end_the_episode_or_be_raised() -> None:
    """The other two ways of handling a refused action."""
    mode = MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete())
    with GymnasiumEnv("reach_target", action_mode=mode, invalid_action="terminate") as env:
        env.reset(seed=0)
        assert env.step(OUT_OF_REACH)[1:3] == (0.0, True)
    with GymnasiumEnv("reach_target", action_mode=mode, invalid_action="raise") as env:
        env.reset(seed=0)
        with pytest.raises(InvalidActionError, match="pose"):
            env.step(OUT_OF_REACH)


def test_quaternions_are_brought_to_unit_length(reach_poses: GymnasiumEnv) -> None:
    """A policy over a box may name a rotation by four numbers of any length."""
    obs, _ = reach_poses.reset(seed=0)
    pose = obs["gripper_pose"].astype(np.float64)
    pose[2] -= 0.05
    pose[3:] *= 0.4
    obs, *_, info = reach_poses.step(np.append(pose, 1.0))
    assert "error" not in info
    np.testing.assert_allclose(obs["gripper_pose"][:3], pose[:3], atol=0.01)


@pytest.mark.parametrize("action", [np.zeros(7), np.zeros((1, 8)), np.full(8, np.nan), [np.inf] * 8])
def test_malformed_actions_are_the_callers_mistake(reach: GymnasiumEnv, action: Any) -> None:
    """Wrong shapes, NaN and infinity are raised, not swallowed, and the message names the numbers."""
    reach.reset(seed=0)
    with pytest.raises(InvalidActionError, match="8 finite numbers.*finger"):
        reach.step(action)


@pytest.mark.parametrize(
    ("options", "error", "says"),
    [
        ({"variaton": 1}, UnknownName, "Did you mean 'variation'"),
        ({"variation": 99}, TaskEnvironmentError, "has no variation 99"),
        ({"variation": -2}, TaskEnvironmentError, "has no variation -2"),
        ({"variation": "red"}, TaskEnvironmentError, "whole number"),
        ({"variation": True}, TaskEnvironmentError, "whole number"),
        ({"reset_to_demo": [1, 2]}, TaskEnvironmentError, "not list"),
        ({"reset_to_demo": rlbench_pin.Demo([], random_seed=0, task_name="open_drawer")}, TaskEnvironmentError, "open_drawer"),
        ({"reset_to_demo": rlbench_pin.Demo([], random_seed=0), "variation": 1}, TaskEnvironmentError, "not both"),
    ],
)
def test_bad_reset_options_are_typed_errors(
    reach: GymnasiumEnv, options: dict[str, Any], error: type[Exception], says: str
) -> None:
    """Unknown options, variations that do not exist, and what is no demonstration of this task."""
    with pytest.raises(error, match=says):
        reach.reset(seed=0, options=options)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"task": "reach_targt"}, "Did you mean 'reach_target'"),
        ({"task": "reach_target", "observation_mode": "visions"}, "Did you mean 'vision'"),
        ({"task": "reach_target", "render_mode": "rgb"}, "render mode"),
        ({"task": "reach_target", "invalid_action": "ignore"}, "invalid actions"),
        ({"task": "reach_target", "renderer": "gpu"}, "renderer"),
    ],
)
def test_bad_arguments_are_typed_errors(arguments: dict[str, Any], says: str) -> None:
    """Misspelt tasks and choices name the nearest."""
    with pytest.raises(UnknownName, match=says):
        GymnasiumEnv(**arguments)


def test_a_mode_that_cannot_be_copied_is_refused() -> None:
    """A mode of one's own that holds what cannot be copied, such as a solver of C++; the message asks for a new mode."""

    class Own(JointVelocity):
        def __deepcopy__(self, memo: dict[int, Any]) -> Any:
            raise RuntimeError("no copies")

    with pytest.raises(TaskEnvironmentError, match="no copies. Pass a new one"):
        GymnasiumEnv("reach_target", action_mode=MoveArmThenGripper(Own(), Discrete()))


@pytest.mark.parametrize(
    ("arguments", "error", "says"),
    [
        ({"image_sze": (64, 64)}, UnknownArgument, "argument of GymnasiumEnv is called 'image_sze'. Did you mean 'image_size'"),
        ({"cameras": ("frnt",)}, InvalidArgument, "cameras is a setting of images.*-vision-v0"),
        ({"image_size": (64, 64)}, InvalidArgument, "image_size is a setting of images.*-vision-v0"),
        ({"shaped_rewards": "yes"}, InvalidArgument, "shaped_rewards"),
    ],
)
def test_arguments_that_a_state_id_does_not_have_are_refused(
    arguments: dict[str, Any], error: type[Exception], says: str
) -> None:
    """Unknown keywords, and settings of images where there are none."""
    with pytest.raises(error, match=says):
        gymnasium.make("rlbench_pin/reach_target-state-v0", **arguments)


@pytest.mark.parametrize(("cameras", "says"), [(("frnt",), "Did you mean 'front'"), ("front", "list of names")])
def test_cameras_that_there_are_not_are_refused(cameras: Any, says: str) -> None:
    """Misspelt names, and a text where names belong."""
    with pytest.raises(RlbenchPinError, match=says):
        gymnasium.make("rlbench_pin/reach_target-vision-v0", cameras=cameras)


def test_shaped_rewards_of_a_task_without_are_refused_at_once() -> None:
    """Before any episode."""
    with pytest.raises(NoShapedReward, match="'push_button' has no shaped reward. Use shaped_rewards=False"):
        gymnasium.make("rlbench_pin/push_button-state-v0", shaped_rewards=True)
