"""Pinocchio and PyBullet say the same about one robot, over its whole joint range."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.checking import arms
from rlbench_pin.robot import SUPPORTED_ROBOTS, RobotModel

CONFIGURATIONS = 1000


@pytest.fixture(scope="module", params=tuple(SUPPORTED_ROBOTS))
def model(request: pytest.FixtureRequest) -> RobotModel:
    """The analytic model of an arm."""
    return RobotModel(SUPPORTED_ROBOTS[request.param])


@pytest.fixture(scope="module")
def configurations(model: RobotModel) -> np.ndarray:
    """Random configurations within the limits and a turn to either side, (n, joints) [rad]."""
    return arms.random_configurations(model, CONFIGURATIONS)


def test_tip_poses_agree(model: RobotModel, configurations: np.ndarray) -> None:
    """Within 1e-6 m and 1e-6 rad at 1,000 random configurations."""
    far, turned = arms.tip_deviation(model, configurations)
    assert far < 1e-6
    assert turned < 1e-6


def test_gravity_torques_agree(model: RobotModel, configurations: np.ndarray) -> None:
    """Within 1e-6 of the largest torque at 1,000 random configurations, fingers open."""
    assert arms.gravity_deviation(model, configurations) < 1e-6
