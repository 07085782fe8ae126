"""The passes of TOPP-RA: the numbers of its own driver."""

from __future__ import annotations

import numpy as np
import pytest
import toppra
import toppra.algorithm

from rlbench_pin.planning.path import JointPath, through
from rlbench_pin.planning.timing.arc import ArcLimits
from rlbench_pin.planning.timing.constraint import MotionConstraint
from rlbench_pin.planning.timing.passes import fastest_speeds
from rlbench_pin.planning.timing.torque import TorqueLimits
from rlbench_pin.robot.model import RobotModel


class Path(toppra.interpolator.AbstractGeometricPath):
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
        path = Path(through(rng.uniform(0.6 * model.limits.lower, 0.6 * model.limits.upper, (5, 7))))
        theirs = toppra.algorithm.TOPPRA(constraints, path, gridpoints=grid, solver_wrapper="seidel")
        _, speeds, _ = theirs.compute_parameterization(0.0, 0.0)
        ours = fastest_speeds(constraints, path, grid)
        assert ours is not None
        np.testing.assert_array_equal(ours, speeds)


def test_where_the_end_cannot_be_reached_there_are_no_speeds(model: RobotModel) -> None:
    """Torque limits far below the arm's weight leave no way to stand still."""
    torque = TorqueLimits(model)
    torque.limit = 0.01 * torque.limit
    path = Path(through(np.array([model.home, model.home + 0.2, model.home + 0.4, model.home + 0.5])))
    assert fastest_speeds([torque.constraint()], path, np.linspace(0.0, 1.0, 21)) is None
