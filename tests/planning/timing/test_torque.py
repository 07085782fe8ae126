"""Torques along timed motions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from rlbench_pin.planning.path import along
from rlbench_pin.planning.timing.retime import retime
from rlbench_pin.planning.timing.torque import TorqueLimits
from rlbench_pin.robot.dynamics import payload_inertia
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import BodySnapshot
from tests.worlds_for_tests import HOME, Boxes

LOAD = pin.Inertia(3.0, np.array([0.0, 0.0, 0.2]), 0.005 * np.eye(3))
BAR = """<robot name="bar"><link name="base"><inertial><mass value="1.5"/><origin xyz="0 0 0.1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="0.05 0.05 0.05"/></geometry></collision></link></robot>"""


def sprint(model: RobotModel, seed: int) -> np.ndarray:
    """Corners of a long way."""
    rng = np.random.default_rng(seed)
    return 0.8 * rng.uniform(model.limits.lower, model.limits.upper, (3, 7)) + 0.2 * HOME


@pytest.mark.simulation
def test_torque_limits_are_kept_everywhere(model: RobotModel) -> None:
    """At full speed with 3 kg some motions break the limits; with them they take a little longer and keep them."""
    torque, limits = TorqueLimits(model, LOAD), model.limits.capped(2.5, 15.0)
    broken = 0
    for seed in range(6):
        path = along(sprint(model, seed), 0.3)
        free, kept = retime(path, limits), retime(path, limits, torque=torque)
        broken += torque.worst(free) > 1.0
        assert torque.worst(kept) <= 1.0
        assert free.duration - 1e-9 <= kept.duration < 1.3 * free.duration
    assert broken > 0


@pytest.mark.simulation
def test_the_quick_bound_is_cautious(model: RobotModel) -> None:
    """Where it says that limits are surely kept, they are."""
    torque = TorqueLimits(model, LOAD)
    said = []
    for top in (2.0, 8.0):
        limits = model.limits.capped(1.0, top)
        for seed in range(6):
            trajectory = retime(along(sprint(model, seed), 0.3), limits)
            said.append(torque.surely_kept(trajectory, limits.acceleration))
            assert not said[-1] or torque.worst(trajectory) <= 1.0
    assert any(said)


def test_acceleration_can_be_eased(model: RobotModel) -> None:
    """With `jerk_time` no sample jumps, the end is reached, and it takes about that much longer."""
    limits = model.limits.capped(1.0, 4.0)
    path = along(sprint(model, 0), 0.3)
    sharp, soft = retime(path, limits), retime(path, limits, jerk_time=0.1)
    jump = [np.abs(np.diff(t.a, axis=0)).max() for t in (sharp, soft)]
    assert jump[1] < 0.3 * jump[0]
    np.testing.assert_allclose(soft.q[[0, -1]], sharp.q[[0, -1]], atol=1e-9)
    assert np.abs(soft.v).max() <= 1.0
    assert np.abs(soft.a).max() <= 4.0
    assert soft.duration == pytest.approx(sharp.duration + 0.1, abs=0.3)


def test_a_held_body_weighs_what_its_file_says(model: RobotModel, boxes: Boxes, tmp_path: Path) -> None:
    """Mass and centre of mass, where the hand carries them; other bodies and fixed ones count nothing."""
    (tmp_path / "bar.urdf").write_text(BAR)
    pose = np.array([[*model.tip_pose(HOME)[:3], 0.0, 0.0, 0.0, 1.0]])
    for held, fixed, mass in ((("bar",), False, 1.5), ((), False, 0.0), (("bar",), True, 0.0)):
        bar = BodySnapshot("bar", tmp_path / "bar.urdf", ("base",), pose, fixed=fixed)
        load = payload_inertia(model, boxes.snapshot(bar, attached=held))
        assert load.mass == pytest.approx(mass)
        if mass:
            pin.forwardKinematics(model.arm, model.data, HOME)
            np.testing.assert_allclose(model.data.oMi[7].act(load.lever), pose[0, :3] + [0.0, 0.0, 0.1], atol=1e-9)


def test_a_payload_stays_with_its_planner(model: RobotModel) -> None:
    """The arm's own model does not get heavier."""
    before = model.gravity(HOME)
    loaded = TorqueLimits(model, LOAD).torques(HOME, np.zeros(7), np.zeros(7))
    np.testing.assert_array_equal(model.gravity(HOME), before)
    assert np.abs(loaded - before).max() > 3.0
