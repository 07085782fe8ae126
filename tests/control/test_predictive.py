"""Model predictive control of the tip."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control import CartesianMPC, PredictiveConfig
from rlbench_pin.errors import InvalidTarget
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from tests.control.analytic_worlds import TABLE_TOP, TOP_DOWN, box, table

DT = 0.05
GOAL = np.array([0.3, 0.2, 1.1, *TOP_DOWN])


def test_a_pose_is_reached_within_limits(model: RobotModel) -> None:
    """The tip comes to rest at a pose, and joint limits hold on the way."""
    controller, q, v, limits = CartesianMPC(model), model.home.copy(), np.zeros(7), model.limits
    for _ in range(60):
        command = controller.command(q, v, GOAL)
        u = command.velocity
        assert not command.stopped
        assert np.all(np.abs(u) <= limits.velocity + 1e-9)
        assert np.all(np.abs(u - v) <= DT * limits.acceleration + 1e-9)
        q, v = q + DT * u, u
        assert limits.contains(q, 1e-9)
    assert np.linalg.norm(model.tip_pose(q)[:3] - GOAL[:3]) < 1e-3


def test_a_moving_reference_is_followed_without_lag(model: RobotModel) -> None:
    """Given the next poses, the tip stays within a few millimetres of a line at 0.2 m/s."""
    controller, q, v = CartesianMPC(model), model.home.copy(), np.zeros(7)
    for _ in range(60):
        v = controller.command(q, v, GOAL).velocity
        q = q + DT * v

    def reference(tick: int) -> np.ndarray:
        return GOAL - [0.0, 0.2 * DT * max(0, tick - 10), 0.0, 0.0, 0.0, 0.0, 0.0]

    for k in range(50):
        poses = np.array([reference(k + i + 1) for i in range(controller.config.horizon)])
        v = controller.command(q, v, poses).velocity
        q = q + DT * v
        assert np.linalg.norm(model.tip_pose(q)[:3] - poses[0, :3]) < 6e-3


@pytest.mark.simulation
def test_distances_are_kept(model: RobotModel) -> None:
    """Sent below a box, the arm stays clear of it while without distances it would not."""
    block = box("block", (0.2, 0.2, 0.15), (0.3, 0.2, TABLE_TOP + 0.075))
    world = WorldSnapshot((table(), block), model.home, np.full(2, 0.04))
    nearest = []
    for aware in (True, False):
        distances, checker = DistanceModel(model), DistanceModel(model)
        distances.update(world)
        checker.update(world)
        controller, q, v = CartesianMPC(model, distances=distances if aware else None), model.home.copy(), np.zeros(7)
        smallest = np.inf
        for _ in range(60):
            v = controller.command(q, v, [0.3, 0.2, TABLE_TOP + 0.05, *TOP_DOWN]).velocity
            q = q + DT * v
            smallest = min(smallest, checker.nearest(q)[0].distance)
        nearest.append(smallest)
    assert nearest[0] > 0.0
    assert nearest[1] < 0.0


def test_a_run_repeats_itself_after_a_reset(model: RobotModel) -> None:
    """Commands depend on those since the last reset and on nothing before."""
    worked = CartesianMPC(model)
    for _ in range(5):
        worked.command(model.home + 0.1, np.zeros(7), GOAL)
    worked.reset()
    for controller in (worked, fresh := CartesianMPC(model)):
        q, v, row = model.home.copy(), np.zeros(7), []
        for _ in range(10):
            v = controller.command(q, v, GOAL).velocity
            q = q + DT * v
            row.append(v)
        controller.history = row  # type: ignore[attr-defined]
    np.testing.assert_array_equal(worked.history, fresh.history)  # type: ignore[attr-defined]


def test_without_a_solution_the_arm_brakes(model: RobotModel) -> None:
    """When the iterations run out, the command is braking, and says so."""
    controller = CartesianMPC(model, PredictiveConfig(iterations=1, tolerance=1e-12))
    command = controller.command(model.home, np.full(7, 0.5), GOAL)
    assert command.stopped
    np.testing.assert_allclose(command.velocity, controller.bounds.braking(np.full(7, 0.5)))


def test_bad_references_are_refused(model: RobotModel) -> None:
    """NaN, zero quaternions and a wrong number of poses raise the typed error."""
    for bad in ([np.nan] * 7, [0.3, 0, 1, 0, 0, 0, 0], np.zeros((3, 7))):
        with pytest.raises(InvalidTarget):
            CartesianMPC(model).command(model.home, np.zeros(7), bad)
