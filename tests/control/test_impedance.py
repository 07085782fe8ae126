"""Impedance: displacement is force over stiffness, damping has no overshoot."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control import CartesianImpedance, JointImpedance
from rlbench_pin.control.impedance import as_stiffness, damping_for
from rlbench_pin.errors import InvalidTarget
from rlbench_pin.robot.model import RobotModel
from tests.control.analytic_worlds import simulate

DT = 1.0 / 240.0
BENT = np.array([0.0, 0.175, 0.0, -1.8, 0.0, 2.2, 0.785])


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("stiffness", [200.0, 600.0])
def test_a_push_gives_the_displacement_that_the_stiffness_says(model: RobotModel, axis: int, stiffness: float) -> None:
    """5 N on the tip move it by 5 N / K within 10 %, along the push and not across."""
    controller, plant = CartesianImpedance(model, [stiffness] * 3 + [30.0] * 3), RobotModel(model.description)
    q, v, target = BENT.copy(), np.zeros(7), model.tip_pose(BENT)
    force = 5.0 * np.eye(3)[axis]
    for _ in range(480):
        q, v = simulate(plant, q, v, controller.torque(q, v, target), DT, force)
    np.testing.assert_allclose(plant.tip_pose(q)[:3] - target[:3], force / stiffness, atol=0.1 * 5.0 / stiffness)


@pytest.mark.simulation
def test_stiffness_may_differ_by_direction_and_change(model: RobotModel) -> None:
    """Soft along z and stiff across; made stiff, the same push moves the tip less."""
    controller, plant = CartesianImpedance(model, [800.0, 800.0, 100.0, 30, 30, 30]), RobotModel(model.description)
    q, v, target, force = BENT.copy(), np.zeros(7), model.tip_pose(BENT), np.array([0.0, 0.0, 5.0])
    for k in range(960):
        if k == 480:
            soft = plant.tip_pose(q)[2] - target[2]
            controller.stiffness = 800.0 * np.ones(6)
        q, v = simulate(plant, q, v, controller.torque(q, v, target), DT, force)
    assert soft == pytest.approx(0.05, rel=0.1)
    assert plant.tip_pose(q)[2] - target[2] == pytest.approx(5.0 / 800.0, rel=0.1)


def test_joints_return_without_overshoot(model: RobotModel) -> None:
    """Critically damped, a displaced arm creeps back to its target."""
    controller, plant = JointImpedance(model, 50.0), RobotModel(model.description)
    q, v = BENT + 0.1, np.zeros(7)
    for _ in range(720):
        q, v = simulate(plant, q, v, controller.torque(q, v, BENT), DT)
        assert np.all(q > BENT - 0.02)
    np.testing.assert_allclose(q, BENT, atol=5e-3)


@pytest.mark.simulation
def test_the_spring_stops_at_joint_limits(model: RobotModel) -> None:
    """Pulled beyond a joint limit by the tip or by the joints, the arm stops before it, and leaves it again."""
    plant, limits = RobotModel(model.description), model.limits
    beyond = BENT.copy()
    beyond[1] = limits.upper[1] + 0.2
    pose = model.tip_pose(beyond)
    tip, joints = CartesianImpedance(model, posture_stiffness=50.0, posture=beyond), JointImpedance(model, 600.0)
    for torque in (lambda q, v: tip.torque(q, v, pose), lambda q, v: joints.torque(q, v, beyond)):
        q, v = BENT.copy(), np.zeros(7)
        q[1] = limits.upper[1] - 0.3
        for _ in range(480):
            q, v = simulate(plant, q, v, torque(q, v), DT)
            assert limits.contains(q)
        assert limits.upper[1] - q[1] < 0.01
    for _ in range(480):
        q, v = simulate(plant, q, v, joints.torque(q, v, BENT), DT)
    np.testing.assert_allclose(q, BENT, atol=1e-2)


def test_every_mode_has_the_damping_ratio(rng: np.random.Generator) -> None:
    """The modes of inertia and stiffness are damped with the same ratio."""
    a, b = rng.normal(size=(2, 6, 6))
    inertia, stiffness = a @ a.T + np.eye(6), b @ b.T
    damping = damping_for(stiffness, inertia, 0.7)
    system = np.block([[np.zeros((6, 6)), np.eye(6)], [-np.linalg.solve(inertia, stiffness), -np.linalg.solve(inertia, damping)]])
    poles = np.linalg.eigvals(system)
    np.testing.assert_allclose(-poles.real / np.abs(poles), 0.7, atol=1e-6)


@pytest.mark.parametrize("bad", [np.nan, [1.0] * 5, -1.0, [[0.0, 1.0], [0.0, 0.0]]])
def test_stiffness_that_is_none_is_refused(bad: object) -> None:
    """NaN, wrong shapes, negative and unsymmetric matrices raise the typed error."""
    with pytest.raises((InvalidTarget, ValueError)):
        as_stiffness(bad, 6 if not isinstance(bad, list) or len(bad) != 2 else 2)  # type: ignore[arg-type]


def test_bad_targets_are_refused(model: RobotModel) -> None:
    """NaN in a target raises the typed error."""
    with pytest.raises(InvalidTarget):
        CartesianImpedance(model).torque(BENT, np.zeros(7), [np.nan] * 7)
    with pytest.raises(InvalidTarget):
        JointImpedance(model).torque(BENT, np.zeros(7), [np.nan] * 7)
