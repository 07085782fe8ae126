"""Several environments in one process keep to their own worlds, as long as their own calls are made in turn."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pyrep.objects.shape import Shape
from rlbench import Environment, ObservationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.tasks import PickAndLift, ReachTarget

pytestmark = pytest.mark.simulation

STILL = np.array([0.0] * 7 + [1.0])


@pytest.fixture
def two() -> Iterator[tuple[Environment, Environment]]:
    """Two launched environments without pictures."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.task_low_dim_state = True
    both = tuple(Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=config, headless=True) for _ in range(2))
    for env in both:
        env.launch()
    yield both[0], both[1]
    for env in both:
        env.shutdown()


def test_they_take_turns(two: tuple[Environment, Environment]) -> None:
    """Each steps and resets its own task; views look at the environment that was used last."""
    reach = two[0].get_task(ReachTarget)
    _, first = reach.reset()
    lift = two[1].get_task(PickAndLift)
    _, other = lift.reset()
    assert Shape.exists("block") and not Shape.exists("target")
    observation, _, _ = reach.step(STILL)
    assert np.allclose(observation.task_low_dim_state, first.task_low_dim_state)
    assert np.allclose(Shape("target").get_position(), first.task_low_dim_state)
    assert np.allclose(lift.get_observation().task_low_dim_state, other.task_low_dim_state, atol=1e-3)
    assert Shape.exists("block")


def test_one_outlives_the_other(two: tuple[Environment, Environment]) -> None:
    """After a shutdown of one, the other goes on."""
    reach = two[0].get_task(ReachTarget)
    _, first = reach.reset()
    two[1].get_task(PickAndLift).reset()
    two[1].shutdown()
    observation, _, _ = reach.step(STILL)
    assert np.allclose(observation.task_low_dim_state, first.task_low_dim_state)
    demo = reach.get_demos(1, live_demos=True)[0]
    assert np.linalg.norm(demo[-1].gripper_pose[:3] - demo[-1].task_low_dim_state) < 0.03
