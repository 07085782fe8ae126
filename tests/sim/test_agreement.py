"""Pinocchio and PyBullet say the same about one robot, over its whole joint range."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.robot.description import robot_description
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import World
from rlbench_pin.sim.client import bullet
from rlbench_pin.spatial import rotation_distance

PANDA = robot_description("panda")
CONFIGURATIONS = 1000


@pytest.fixture(scope="module")
def model() -> RobotModel:
    """The analytic model of the arm."""
    return RobotModel(PANDA)


@pytest.fixture(scope="module")
def configurations(model: RobotModel) -> np.ndarray:
    """Random configurations within the limits, (n, 7) [rad]."""
    rng = np.random.default_rng(0)
    return rng.uniform(model.limits.lower, model.limits.upper, (CONFIGURATIONS, model.size))


def test_tip_poses_agree(model: RobotModel, configurations: np.ndarray) -> None:
    """Within 1e-6 m and 1e-6 rad at 1,000 random configurations."""
    with World(SceneSpec(format=1), PANDA) as world:
        for q in configurations:
            world.robot.reset_configuration(q)
            simulated, analytic = world.robot.tip_pose(), model.tip_pose(q)
            assert np.abs(simulated[:3] - analytic[:3]).max() < 1e-6
            assert np.abs(np.abs(simulated[3:] @ analytic[3:]) - 1.0) < 1e-12
            assert rotation_distance(simulated, analytic) < 1e-6


def test_gravity_torques_agree(model: RobotModel, configurations: np.ndarray) -> None:
    """Within 1e-6 of the largest torque at 1,000 random configurations, fingers open."""
    fingers, rest = [PANDA.gripper_open] * 2, [0.0] * 9
    with World(SceneSpec(format=1), PANDA) as world:
        uid, client = world.robot.model.uid, world.client.id
        for q in configurations:
            full = bullet.calculateInverseDynamics(uid, [*q.tolist(), *fingers], rest, rest, physicsClientId=client)
            analytic = model.gravity(q)
            assert np.abs(np.array(full)[:7] - analytic).max() < 1e-6 * max(1.0, np.abs(analytic).max())
