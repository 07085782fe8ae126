"""Stopping in time, within the torques of the motors."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from rlbench_pin.control import SafetyConfig, SafetyFilter
from rlbench_pin.control.braking import RESERVE, MotorCheck
from rlbench_pin.control.qp.constraints import JointBounds
from rlbench_pin.robot.model import RobotModel

DT = 0.05
BACKWARDS = np.array([-1.494, -1.672, 0.197, -0.283, -1.936, 2.393, 0.921])
"""The arm stretched out behind its base."""
FALLING = np.array([-1.927, -0.963, -0.737, -0.387, -1.052, 0.532, -1.362])


def test_the_torques_are_those_of_braking_to_standstill(model: RobotModel) -> None:
    """A command passes where its own tick and every tick of braking keep the torques, and only there."""
    bounds, rng, found = JointBounds(model.limits, DT, "any"), np.random.default_rng(0), set()
    check = MotorCheck(model, bounds)
    for _ in range(200):
        q = rng.uniform(model.limits.lower, model.limits.upper)
        v, command = rng.uniform(-0.5, 0.5, (2, model.size)) * model.limits.velocity
        here, before, after, worst = q, v, command, 0.0
        while True:
            torques = model.inverse_dynamics(here, before, (after - before) / DT)
            worst = max(worst, float((np.abs(torques) / model.limits.effort).max()))
            if not after.any():
                break
            here, before, after = here + DT * after, after, bounds.braking(after)
        assert check.overloaded(q, v, command) == (worst > RESERVE)
        found.add(worst > RESERVE)
    assert found == {False, True}


def test_what_the_arm_carries_counts(model: RobotModel) -> None:
    """With 8 kg in the gripper the stretched arm cannot brake as hard as without."""
    check = MotorCheck(model, JointBounds(model.limits, DT, "any"))
    q, v = np.array([0.0, 1.4, 0.0, -0.3, 0.0, 1.2, 0.0]), np.zeros(model.size)
    assert not check.overloaded(q, v, v)
    check.carry(pin.Inertia(8.0, np.array([0.0, 0.0, 0.1]), np.zeros((3, 3))))
    assert check.overloaded(q, v, v)
    check.carry(pin.Inertia.Zero())
    assert not check.overloaded(q, v, v)


def test_a_command_that_leaves_no_torque_to_brake_with_is_changed(model: RobotModel) -> None:
    """The second joint falls, and the others would push it on: the filter says so, and its own command can be braked."""
    safety = SafetyFilter(model, SafetyConfig(hold="any"))
    wanted = FALLING + DT * np.array([0.0, 4.9, 9.5, -11.9, 14.2, 0.0, 0.0])
    check = MotorCheck(model, safety.bounds)
    assert check.overloaded(BACKWARDS, FALLING, wanted)
    command = safety.filter(BACKWARDS, FALLING, wanted)
    assert "torque" in command.reasons
    assert not check.overloaded(BACKWARDS, FALLING, command.velocity)
