"""Kinematics and dynamics of the arm."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from rlbench_pin.errors import RobotModelError
from rlbench_pin.robot.model import JointLimits, RobotModel
from rlbench_pin.spatial import above_table, pose_to_se3, rotation_distance

STEP = 1e-6


@pytest.fixture
def q(model: RobotModel) -> np.ndarray:
    """A configuration without special values."""
    return model.home + np.array([0.1, -0.2, 0.3, -0.1, 0.2, 0.3, -0.4])


def test_home_looks_down_on_the_workspace(model: RobotModel) -> None:
    """At home the tip is above the table, in the plane of the arm, pointing down and slightly forward."""
    pose = model.tip_pose(model.home)
    np.testing.assert_allclose(pose[:3], [0.278, 0.0, above_table(0.701)], atol=1e-3)
    approach = pose_to_se3(pose).rotation[:, 2]
    np.testing.assert_allclose(approach, [np.sin(0.1745), 0.0, -np.cos(0.1745)], atol=1e-3)


def test_base_stands_where_it_is_put(model: RobotModel, q: np.ndarray) -> None:
    """Another base pose moves and turns the tip with it."""
    turned = RobotModel(model.description, (1.0, 2.0, 0.0, 0.0, 0.0, np.sin(0.5), np.cos(0.5)))
    relative = model.base.actInv(model.tip_se3(q))
    assert turned.tip_se3(q).isApprox(turned.base * relative, 1e-12)


@pytest.mark.parametrize("frame", ["world", "tip"])
def test_jacobian_is_the_derivative_of_the_tip(model: RobotModel, q: np.ndarray, frame: str) -> None:
    """Columns agree with finite differences, along world axes or in tip axes."""
    T = model.tip_se3(q)
    for i in range(model.size):
        shifted = q.copy()
        shifted[i] += STEP
        twist = pin.log6(T.actInv(model.tip_se3(shifted))).vector / STEP
        if frame == "world":
            twist = np.concatenate([T.rotation @ twist[:3], T.rotation @ twist[3:]])
        np.testing.assert_allclose(model.jacobian(q, frame)[:, i], twist, atol=1e-5)  # type: ignore[arg-type]


@pytest.mark.parametrize("frame", ["world", "tip"])
def test_jacobian_dot_is_the_derivative_of_the_jacobian(model: RobotModel, q: np.ndarray, frame: str) -> None:
    """dJ/dt agrees with finite differences along the motion."""
    v = np.linspace(-0.5, 0.5, model.size)
    expected = (model.jacobian(q + STEP * v, frame) - model.jacobian(q, frame)) / STEP  # type: ignore[arg-type]
    np.testing.assert_allclose(model.jacobian_dot(q, v, frame), expected, atol=1e-5)  # type: ignore[arg-type]


def test_dynamics_agree_with_each_other(model: RobotModel, q: np.ndarray) -> None:
    """M a + C v + g are the torques of inverse dynamics, and forward dynamics undoes them."""
    v, a = np.linspace(-1.0, 1.0, 7), np.linspace(2.0, -1.0, 7)
    tau = model.inverse_dynamics(q, v, a)
    np.testing.assert_allclose(model.mass_matrix(q) @ a + model.coriolis(q, v) + model.gravity(q), tau, atol=1e-9)
    np.testing.assert_allclose(model.forward_dynamics(q, v, tau), a, atol=1e-9)


def test_payload_weighs_on_the_joints(model: RobotModel, q: np.ndarray) -> None:
    """A mass at the tip adds J^T m g, and goes away again."""
    before = model.gravity(q)
    model.set_payload(0.7, np.zeros(3))
    np.testing.assert_allclose(model.gravity(q) - before, 0.7 * 9.81 * model.jacobian(q)[2], atol=1e-9)
    model.set_payload(0.0, np.zeros(3))
    np.testing.assert_array_equal(model.gravity(q), before)


def test_manipulability_vanishes_when_stretched(model: RobotModel) -> None:
    """A stretched arm cannot move outwards."""
    assert model.manipulability(model.home) > 0.02
    stretched = np.array([0.0, 0.0, 0.0, -0.0698, 0.0, 0.0, 0.0])
    assert model.manipulability(stretched) < 0.02


def test_results_are_the_callers(model: RobotModel, q: np.ndarray) -> None:
    """Writing to a result does not change the next one."""
    first = model.jacobian(q)
    kept = first.copy()
    first[:] = 0.0
    np.testing.assert_array_equal(model.jacobian(q), kept)


def test_wrong_joint_names_are_refused(model: RobotModel) -> None:
    """A description whose joints are in another order, or missing, does not load."""
    names = model.description.arm_joints
    with pytest.raises(RobotModelError, match="arm joints of the URDF"):
        RobotModel(replace(model.description, arm_joints=(names[1], names[0], *names[2:])))
    with pytest.raises(RobotModelError, match="has the joints"):
        RobotModel(replace(model.description, arm_joints=("elbow", *names[1:])))
    with pytest.raises(RobotModelError, match="no frame 'nose'"):
        RobotModel(replace(model.description, tip_frame="nose"))


def test_home_outside_the_limits_is_refused(model: RobotModel, tmp_path: Path) -> None:
    """A home that the joints cannot reach is a fault of the description."""
    with pytest.raises(RobotModelError, match="home"):
        RobotModel(replace(model.description, home=(9.0, *model.description.home[1:])))


def test_the_tip_of_a_hand_that_points_down(model: RobotModel) -> None:
    """It is (0, 1, 0, 0) but for the 10 degrees that home leans, and y goes from the first finger to the second."""
    home = model.tip_pose(model.home)
    assert np.degrees(rotation_distance(home, np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]))) == pytest.approx(10.0, abs=0.1)
    data = model.full.createData()
    pin.framesForwardKinematics(model.full, data, model.full_configuration(model.home))
    first, second = (data.oMf[model.full.getFrameId(link)].translation for link in model.description.finger_links)
    assert (second - first) @ pose_to_se3(home).rotation[:, 1] == pytest.approx(0.08, abs=1e-6)


LIMITS = JointLimits(-np.ones(2), np.ones(2), np.array([0.5, 3.0]), np.array([10.0, 1.0]), np.ones(2))


def test_arrays_cannot_be_changed() -> None:
    """Limits are shared, so nobody may write to them."""
    with pytest.raises(ValueError, match="read-only"):
        LIMITS.lower[0] = 0.0


def test_caps_only_lower() -> None:
    """A cap slows the fast joints down and leaves the slow ones as they are."""
    capped = LIMITS.capped(1.0, 4.0)
    np.testing.assert_array_equal(capped.velocity, [0.5, 1.0])
    np.testing.assert_array_equal(capped.acceleration, [4.0, 1.0])


def test_margin_is_the_distance_to_the_nearest_limit() -> None:
    """The margin is negative outside."""
    assert LIMITS.margin(np.array([0.0, 0.9])) == pytest.approx(0.1)
    assert LIMITS.margin(np.array([-1.2, 0.0])) == pytest.approx(-0.2)
    assert LIMITS.contains(np.array([1.0, -1.0]))
    assert not LIMITS.contains(np.array([1.1, 0.0]))


def test_wrong_shape_is_refused() -> None:
    """All arrays have one length."""
    with pytest.raises(ValueError, match="velocity"):
        JointLimits(-np.ones(2), np.ones(2), np.ones(3), np.ones(2), np.ones(2))
