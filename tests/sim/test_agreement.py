"""Pinocchio and PyBullet say the same about one robot, over its whole joint range."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.robot import SUPPORTED_ROBOTS, RobotModel
from rlbench_pin.robot.fingers import fingers_of
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import World
from rlbench_pin.sim.client import bullet
from rlbench_pin.spatial import rotation_distance

CONFIGURATIONS = 1000


@pytest.fixture(scope="module", params=tuple(SUPPORTED_ROBOTS))
def model(request: pytest.FixtureRequest) -> RobotModel:
    """The analytic model of an arm."""
    return RobotModel(SUPPORTED_ROBOTS[request.param])


@pytest.fixture(scope="module")
def configurations(model: RobotModel) -> np.ndarray:
    """Random configurations within the limits and a turn to either side, (n, joints) [rad]."""
    rng = np.random.default_rng(0)
    low, high = np.maximum(model.limits.lower, -2.0 * np.pi), np.minimum(model.limits.upper, 2.0 * np.pi)
    return rng.uniform(low, high, (CONFIGURATIONS, model.size))


def test_tip_poses_agree(model: RobotModel, configurations: np.ndarray) -> None:
    """Within 1e-6 m and 1e-6 rad at 1,000 random configurations."""
    with World(SceneSpec(format=1), model.description) as world:
        for q in configurations:
            world.robot.reset_configuration(q)
            simulated, analytic = world.robot.tip_pose(), model.tip_pose(q)
            assert np.abs(simulated[:3] - analytic[:3]).max() < 1e-6
            assert np.abs(np.abs(simulated[3:] @ analytic[3:]) - 1.0) < 1e-12
            assert rotation_distance(simulated, analytic) < 1e-6


def test_gravity_torques_agree(model: RobotModel, configurations: np.ndarray) -> None:
    """Within 1e-6 of the largest torque at 1,000 random configurations, fingers open."""
    description, hand = model.description, fingers_of(model.description)
    opened = dict(zip(hand.joints, hand.joint_values(np.full(2, description.gripper_open)), strict=True))
    with World(SceneSpec(format=1), description) as world:
        uid, client = world.robot.model.uid, world.client.id
        joints = [bullet.getJointInfo(uid, k, client) for k in range(bullet.getNumJoints(uid, client))]
        names = [joint[1].decode() for joint in joints if joint[2] != bullet.JOINT_FIXED]
        arm, rest = [names.index(name) for name in description.arm_joints], [0.0] * len(names)
        for q in configurations:
            values = opened | dict(zip(description.arm_joints, q, strict=True))
            full = bullet.calculateInverseDynamics(uid, [values[name] for name in names], rest, rest, physicsClientId=client)
            analytic = model.gravity(q)
            assert np.abs(np.array(full)[arm] - analytic).max() < 1e-6 * max(1.0, np.abs(analytic).max())
