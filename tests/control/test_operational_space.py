"""Operational space control, in rigid-body dynamics by Pinocchio."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control import OperationalSpaceConfig, OperationalSpaceQP, PoseIK
from rlbench_pin.errors import InvalidTarget
from rlbench_pin.robot.model import JointLimits, RobotModel
from rlbench_pin.spatial import FloatArray
from tests.control.analytic_worlds import TOP_DOWN, simulate

DT = OperationalSpaceConfig().dt


def circle(t: float, radius: float, speed: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return pose (7,), twist (6,) and acceleration (6,) on an upright circle, the speed reached within half a second."""
    omega = speed / radius
    phase, rate, push = (omega * t * t, 2 * omega * t, 2 * omega) if t < 0.5 else (omega * (t - 0.25), omega, 0.0)
    out, along = np.array([0, np.cos(phase), np.sin(phase)]), np.array([0, -np.sin(phase), np.cos(phase)])
    pose = np.concatenate([[0.22, 0.0, 1.12] + radius * out, TOP_DOWN])
    twist = np.concatenate([radius * rate * along, np.zeros(3)])
    return pose, twist, np.concatenate([radius * (push * along - rate * rate * out), np.zeros(3)])


@pytest.mark.simulation
@pytest.mark.parametrize("radius", [0.25, 0.125])
def test_a_circle_is_followed(model: RobotModel, radius: float) -> None:
    """A circle at 0.5 m/s: less than 2 mm off at all times, torques within the limits."""
    controller, plant = OperationalSpaceQP(model), RobotModel(model.description)
    q = PoseIK(model).solve(circle(0.0, radius, 0.5)[0], model.home, np.random.default_rng(0)).q
    v, worst = np.zeros(7), 0.0
    for k in range(int((2 * np.pi * radius / 0.5 + 0.5) / DT)):
        pose, twist, acceleration = circle(k * DT, radius, 0.5)
        worst = max(worst, float(np.linalg.norm(plant.tip_pose(q)[:3] - pose[:3])))
        command = controller.command(q, v, pose, twist, acceleration)
        assert not command.stopped
        assert np.all(np.abs(command.torque) <= model.limits.effort)
        q, v = simulate(plant, q, v, command.torque, DT)
    assert worst < 2e-3


def test_the_pull_is_bounded(model: RobotModel) -> None:
    """However far the target, the tip is accelerated towards it by 10 m/s^2 at most: what holds the arm back is not crushed."""
    controller, q = OperationalSpaceQP(model), model.home + [0, 0.2, 0, -1.0, 0, 1.0, 0]
    pose, pulls = model.tip_pose(q), []
    for distance in (0.01, 0.1, 0.4):
        command = controller.command(q, np.zeros(7), pose - [0, 0, distance, 0, 0, 0, 0])
        pulls.append(float(-(model.jacobian(q) @ command.acceleration)[2]))
    assert pulls[0] == pytest.approx(6.25, rel=0.05)
    assert pulls[1] == pytest.approx(pulls[2], rel=1e-3)
    assert 7.0 < pulls[1] < 10.1


def test_a_far_target_is_approached_within_all_limits(model: RobotModel) -> None:
    """Asked for a pose far away and out of reach, torque, velocity and position limits hold."""
    controller, plant, limits = OperationalSpaceQP(model), RobotModel(model.description), model.limits
    q, v = model.home.copy(), np.zeros(7)
    for _ in range(720):
        command = controller.command(q, v, [0.9, -0.8, 0.9, *TOP_DOWN])
        assert np.all(np.abs(command.torque) <= limits.effort)
        q, v = simulate(plant, q, v, command.torque, DT)
        assert limits.contains(q, 2e-3)
        assert np.all(np.abs(v) <= limits.velocity + 1e-2)


def test_motors_too_weak_for_the_limits_brake(model: RobotModel) -> None:
    """When no torque keeps all constraints the command is the safe stop, within the torque limits."""
    limits = model.limits
    weak = JointLimits(limits.lower, limits.upper, limits.velocity, limits.acceleration, 0.1 * np.ones(7))
    command = OperationalSpaceQP(model, limits=weak).command(model.home, np.zeros(7), model.tip_pose(model.home))
    assert command.stopped
    assert np.all(np.abs(command.torque) <= 0.1)


def test_bad_input_is_refused(model: RobotModel) -> None:
    """NaN and quaternions of norm zero raise the typed error."""
    controller, v = OperationalSpaceQP(model), np.zeros(7)
    for pose in ([np.nan] * 7, [0.3, 0, 1, 0, 0, 0, 0]):
        with pytest.raises(InvalidTarget):
            controller.command(model.home, v, pose)
    with pytest.raises(InvalidTarget):
        controller.command(model.home, v, model.tip_pose(model.home), twist=np.full(6, np.inf))
