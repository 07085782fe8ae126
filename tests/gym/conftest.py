"""Environments shared by the tests of this folder."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rlbench_pin.environment import Discrete, EndEffectorPoseViaPlanning, MoveArmThenGripper
from rlbench_pin.gym import GymnasiumEnv


@pytest.fixture(scope="module")
def reach() -> Iterator[GymnasiumEnv]:
    """reach_target with joint differences."""
    env = GymnasiumEnv("reach_target")
    yield env
    env.close()


@pytest.fixture(scope="module")
def reach_poses() -> Iterator[GymnasiumEnv]:
    """reach_target with planned tip poses."""
    env = GymnasiumEnv("reach_target", action_mode=MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()))
    yield env
    env.close()
