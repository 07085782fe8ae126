"""Timing: limits of joints, arc and motors, and the passes of TOPP-RA."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import toppra
import toppra.algorithm

from rlbench_pin.planning.path import JointPath, along, straight_path, through
from rlbench_pin.planning.timing import ArcLimits, MotionConstraint, TorqueLimits, fastest_speeds, retime
from rlbench_pin.robot.dynamics import payload_inertia
from rlbench_pin.robot.model import JointLimits, RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.scene.snapshot import BodySnapshot
from rlbench_pin.spatial import pose_at
from tests.worlds_for_tests import HOME, Boxes


class ToppraPath(toppra.interpolator.AbstractGeometricPath):
    """A joint path for TOPPRA."""

    def __init__(self, path: JointPath) -> None:
        self.path = path

    def __call__(self, s: np.ndarray, order: int = 0) -> np.ndarray:
        return self.path(s, order)

    dof, path_interval, waypoints = 7, np.array([0.0, 1.0]), None


@pytest.mark.parametrize("torque", [False, True])
def test_speeds_are_those_of_toppra_to_the_last_bit(model: RobotModel, torque: bool) -> None:
    """On random curves, with and without torque limits, whose range of speeds need not contain 0."""
    rng, grid = np.random.default_rng(4), np.linspace(0.0, 1.0, 61)
    constraints: list[toppra.constraint.Constraint] = [MotionConstraint(model.limits, ArcLimits(1.0, 4.0), 0.98)]
    constraints += [TorqueLimits(model).constraint()] if torque else []
    for _ in range(3):
        path = ToppraPath(through(rng.uniform(0.6 * model.limits.lower, 0.6 * model.limits.upper, (5, 7))))
        theirs = toppra.algorithm.TOPPRA(constraints, path, gridpoints=grid, solver_wrapper="seidel")
        _, speeds, _ = theirs.compute_parameterization(0.0, 0.0)
        ours = fastest_speeds(constraints, path, grid)
        assert ours is not None
        np.testing.assert_array_equal(ours, speeds)


def test_where_the_end_cannot_be_reached_there_are_no_speeds(model: RobotModel) -> None:
    """Torque limits far below the arm's weight leave no way to stand still."""
    torque = TorqueLimits(model)
    torque.limit = 0.01 * torque.limit
    path = ToppraPath(through(np.array([model.home, model.home + 0.2, model.home + 0.4, model.home + 0.5])))
    assert fastest_speeds([torque.constraint()], path, np.linspace(0.0, 1.0, 21)) is None


def every_millisecond(trajectory: Trajectory) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sample q, v, a on a grid of 1 ms."""
    samples = [trajectory.sample(t) for t in np.arange(0.0, trajectory.duration, 1e-3)]
    q, v, a = (np.array(x) for x in zip(*samples, strict=True))
    return q, v, a


@pytest.mark.parametrize("seed", range(12))
def test_limits_hold_at_every_millisecond(limits: JointLimits, seed: int) -> None:
    """Velocity and acceleration stay within their limits, also when differenced from what is commanded."""
    rng = np.random.default_rng(seed)
    vertices = np.cumsum(rng.uniform(-0.6, 0.6, (rng.integers(2, 7), 7)), axis=0)
    q, v, a = every_millisecond(retime(along(vertices, 0.2), limits))
    assert (np.abs(v) <= limits.velocity).all()
    assert (np.abs(a) <= limits.acceleration).all()
    assert (np.abs(np.diff(q, axis=0)) / 1e-3 <= limits.velocity * 1.001).all()
    assert (np.abs(np.diff(v, axis=0)) / 1e-3 <= limits.acceleration * 1.01).all()


def test_limits_hold_on_a_line_of_the_tip(model: RobotModel, limits: JointLimits) -> None:
    """The same is true where joint velocities change along the way."""
    line = straight_path(model, model.home, pose_at((0.35, 0.3, 0.85), np.pi, 0.0, np.pi))
    _, v, a = every_millisecond(retime(through(line, np.linspace(0.0, 1.0, len(line))), limits))
    assert (np.abs(v) <= limits.velocity).all()
    assert (np.abs(a) <= limits.acceleration).all()


def test_it_rests_at_both_ends(limits: JointLimits) -> None:
    """The trajectory starts and ends exactly at the path's ends, without velocity."""
    ends = np.array([np.zeros(7), np.full(7, 0.5)])
    trajectory = retime(ends, limits)
    np.testing.assert_allclose(trajectory.q[[0, -1]], ends, atol=1e-12)
    np.testing.assert_array_equal(trajectory.v[[0, -1]], np.zeros((2, 7)))


def test_it_is_nearly_as_fast_as_possible(limits: JointLimits) -> None:
    """A line is driven with a trapezoid of velocity, within a few per cent of the fastest."""
    trajectory = retime(np.array([np.zeros(7), np.full(7, 1.0)]), limits)
    fastest = 1.0 / 1.0 + 1.0 / 4.0
    assert fastest <= trajectory.duration < 1.05 * fastest


def test_the_slowest_joint_decides() -> None:
    """Each joint has its own limit."""
    one = np.ones(2)
    limits = JointLimits(-one, one, np.array([1.0, 0.1]), np.array([4.0, 4.0]), one)
    assert retime(np.array([[0.0, 0.0], [0.5, 0.5]]), limits).duration > 5.0


@pytest.mark.parametrize("seed", range(8))
def test_limits_along_the_arc_hold_at_every_millisecond(limits: JointLimits, seed: int) -> None:
    """The norm of the joint velocity and its change stay within their limits, beside those of the joints, and are used."""
    rng = np.random.default_rng(seed)
    vertices = np.cumsum(rng.uniform(-0.6, 0.6, (rng.integers(2, 7), 7)), axis=0)
    arc = ArcLimits(0.7, 1.5)
    for jerk_time in (0.0, 0.1):
        _, v, a = every_millisecond(retime(along(vertices, 0.2), limits, arc=arc, jerk_time=jerk_time))
        speed = np.linalg.norm(v, axis=1)
        assert 0.6 < speed.max() <= arc.velocity + 1e-9
        assert np.abs(np.diff(speed)).max() / 1e-3 <= 1.01 * arc.acceleration
        assert (np.abs(v) <= limits.velocity).all() and (np.abs(a) <= limits.acceleration).all()


def test_a_line_is_as_long_as_the_arc_says(limits: JointLimits) -> None:
    """A trapezoid of the speed along the arc, within a few per cent of the fastest; a joint limit slows it further."""
    line = np.array([np.zeros(7), np.full(7, 1.0)])
    fastest = np.sqrt(7.0) / 1.0 + 1.0 / 4.0
    assert fastest <= retime(line, limits, arc=ArcLimits(1.0, 4.0)).duration < 1.03 * fastest
    slow = limits.capped(0.2, 4.0)
    assert retime(line, slow, arc=ArcLimits(1.0, 4.0)).duration > 5.0


def test_short_motions_keep_the_limits_along_the_arc(limits: JointLimits) -> None:
    """Those that are timed by a polynomial, too."""
    arc = ArcLimits(0.01, 0.05)
    _, v, a = every_millisecond(retime(np.array([np.zeros(7), np.full(7, 1e-3)]), limits, arc=arc))
    assert 0.5 * arc.velocity < np.linalg.norm(v, axis=1).max() <= arc.velocity
    assert np.linalg.norm(a, axis=1).max() <= arc.acceleration


def test_standing_still_takes_no_time(limits: JointLimits) -> None:
    """A path without length has one sample, and it can be asked for any time."""
    trajectory = retime(np.tile(np.linspace(0.0, 1.0, 7), (3, 1)), limits)
    assert trajectory.duration == 0.0
    np.testing.assert_array_equal(trajectory.sample(0.5)[0], np.linspace(0.0, 1.0, 7))


def test_tiny_motions_can_be_timed(limits: JointLimits) -> None:
    """A motion of a hair's breadth is timed too."""
    for size in (1e-8, 1e-5, 1e-3):
        trajectory = retime(np.array([np.zeros(7), np.full(7, size)]), limits)
        np.testing.assert_allclose(trajectory.q[-1], size, rtol=1e-6)
        assert trajectory.duration < 0.1
        every = every_millisecond(trajectory)
        assert (np.abs(every[1]) <= limits.velocity).all()
        assert (np.abs(every[2]) <= limits.acceleration).all()


def test_no_path_is_passed_almost_at_a_standstill(limits: JointLimits) -> None:
    """Where TOPPRA would halt at a sharp bend between two grid points of the first grid, a finer one lets the motion go on."""
    rng = np.random.default_rng(407)
    count = rng.integers(4, 8)
    vertices = np.cumsum(rng.normal(size=(count, 7)) * 0.4, axis=0)
    path = along(vertices, rng.uniform(0.02, 0.2, size=count))
    trajectory = retime(path, limits)
    speed = np.linalg.norm(trajectory.v, axis=1)
    inside = (trajectory.times > 0.1) & (trajectory.times < trajectory.duration - 0.1)
    assert speed[inside].min() > 0.02
    assert trajectory.duration < 2.8


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
    """Mass and centre of mass, where the gripper carries them; other bodies and fixed ones count nothing."""
    (tmp_path / "bar.urdf").write_text(BAR)
    pose = np.array([[*model.tip_pose(HOME)[:3], 0.0, 0.0, 0.0, 1.0]])
    for held, fixed, mass in ((("bar",), False, 1.5), ((), False, 0.0), (("bar",), True, 0.0)):
        bar = BodySnapshot("bar", tmp_path / "bar.urdf", ("base",), pose, fixed=fixed)
        load = payload_inertia(model, boxes.snapshot(bar, attached=held))
        assert load.mass == pytest.approx(mass)
        if mass:
            pin.forwardKinematics(model.arm, model.data, HOME)
            np.testing.assert_allclose(model.data.oMi[7].act(load.lever), pose[0, :3] + [0.0, 0.0, 0.1], atol=1e-9)


def test_a_held_body_can_weigh_more_and_be_larger(model: RobotModel, boxes: Boxes, tmp_path: Path) -> None:
    """A changed mass counts, and lengths are scaled."""
    (tmp_path / "bar.urdf").write_text(BAR)
    pose = np.array([[*model.tip_pose(HOME)[:3], 0.0, 0.0, 0.0, 1.0]])
    bar = BodySnapshot("bar", tmp_path / "bar.urdf", ("base",), pose, scale=2.0, masses={"base": 3.0})
    load = payload_inertia(model, boxes.snapshot(bar, attached=("bar",)))
    pin.forwardKinematics(model.arm, model.data, HOME)
    assert load.mass == pytest.approx(3.0)
    np.testing.assert_allclose(model.data.oMi[7].act(load.lever), pose[0, :3] + [0.0, 0.0, 0.2], atol=1e-9)


def test_a_payload_stays_with_its_planner(model: RobotModel) -> None:
    """The arm's own model does not get heavier."""
    before = model.gravity(HOME)
    loaded = TorqueLimits(model, LOAD).torques(HOME, np.zeros(7), np.zeros(7))
    np.testing.assert_array_equal(model.gravity(HOME), before)
    assert np.abs(loaded - before).max() > 3.0
