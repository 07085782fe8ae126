"""Compliant approach: bounded force and speed, giving way across the motion, and the search for an opening."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control import CompliantConfig, CompliantFollowing
from rlbench_pin.errors import InvalidTarget, InvalidValue
from rlbench_pin.planning.path import straight_path
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray

DOWN = 0.05
"""Length of the approach [m]."""
STIFFNESS = 2e4
"""Of what the tip meets [N/m]."""


def approach(model: RobotModel) -> Trajectory:
    """The tip goes straight down within a second."""
    goal = model.tip_pose(model.home)
    goal[2] -= DOWN
    path = np.array(straight_path(model, model.home, goal))
    rates = np.gradient(path, axis=0) * (len(path) - 1)
    return Trajectory(np.linspace(0.0, 1.0, len(path)), path, rates, np.zeros_like(path))


class Plate:
    """A plate under the tip, with a shaft in it, whose walls are springs."""

    def __init__(self, model: RobotModel, height: float, shaft: tuple[float, float] | None = None, width: float = 0.0) -> None:
        self.model, self.start, self.height = model, model.tip_pose(model.home)[:3], height
        self.shaft, self.width = shaft, width

    def force(self, q: FloatArray) -> FloatArray:
        """The force (3,) on the tip [N]."""
        place = self.model.tip_pose(q)[:3] - self.start
        depth = self.height - place[2]
        if depth <= 0.0:
            return np.zeros(3)
        beside = np.full(2, np.inf) if self.shaft is None else place[:2] - self.shaft
        if np.linalg.norm(beside) > self.width + 0.0005:
            return np.array([0.0, 0.0, STIFFNESS * depth])
        over = max(0.0, float(np.linalg.norm(beside)) - self.width)
        return np.append(-STIFFNESS * over * beside / max(float(np.linalg.norm(beside)), 1e-9), 0.0)

    def torques(self, q: FloatArray) -> FloatArray:
        """What motors hold that keep the arm at rest (n,) [N m]."""
        return self.model.gravity(q) - self.model.jacobian(q)[:3].T @ self.force(q)


def run(model: RobotModel, plate: Plate, config: CompliantConfig | None = None) -> tuple[FloatArray, list[float], list[float]]:
    """Follow to the end; return where the tip is then, from its start (3,), its speeds [m/s] and the forces on it [N]."""
    following, q = CompliantFollowing(model, approach(model), 0.05, config), model.home.copy()
    speeds, forces = [], []
    while not following.done:
        before, q = q, following.command(q, plate.torques(q))
        speeds.append(float(np.linalg.norm(model.tip_pose(q)[:3] - model.tip_pose(before)[:3])) / 0.05)
        forces.append(float(np.linalg.norm(plate.force(q))))
    return model.tip_pose(q)[:3] - plate.start, speeds, forces


def test_a_free_way_is_followed_at_the_speed_asked_for(model: RobotModel) -> None:
    """The tip arrives, never faster than the bound."""
    place, speeds, _ = run(model, Plate(model, -1.0), CompliantConfig(speed=0.04))
    np.testing.assert_allclose(place, [0.0, 0.0, -DOWN], atol=1e-4)
    assert max(speeds) < 0.042


def test_the_arm_stops_where_the_force_is_reached(model: RobotModel) -> None:
    """On a plate without an opening the tip presses with the force of the bound, and patience ends the approach."""
    place, _, forces = run(model, Plate(model, -0.02))
    assert place[2] == pytest.approx(-0.021, abs=2e-4)
    np.testing.assert_allclose(forces[-40:], 20.0, atol=2.0)


@pytest.mark.parametrize("shaft", [(0.0015, 0.0), (0.0, -0.002), (-0.0012, 0.0012)])
def test_the_opening_is_searched(model: RobotModel, shaft: tuple[float, float]) -> None:
    """A shaft beside the way, 0.7 mm wider than the tip, is found, and the tip goes to its bottom; without search it does not."""
    place, _, _ = run(model, Plate(model, -0.02, shaft, 0.0007))
    assert place[2] == pytest.approx(-DOWN, abs=1e-3)
    place, _, _ = run(model, Plate(model, -0.02, shaft, 0.0007), CompliantConfig(radius=1e-6))
    assert place[2] > -0.025


def test_a_weight_that_is_held_is_no_contact(model: RobotModel) -> None:
    """Torques that are there from the first command on change nothing."""
    following, q, heavy = CompliantFollowing(model, approach(model)), model.home.copy(), np.array([0.0, 0.0, -15.0])
    while not following.done:
        q = following.command(q, model.gravity(q) - model.jacobian(q)[:3].T @ heavy)
    np.testing.assert_allclose(following.displacement, 0.0, atol=1e-4)


def test_bad_values_are_refused(model: RobotModel) -> None:
    """NaN torques, a force of nothing, settings that are an array, and a tick that gives too many commands."""
    with pytest.raises(InvalidValue, match="config"):
        CompliantFollowing(model, approach(model), config=np.zeros((0, 7)))  # type: ignore[arg-type]
    with pytest.raises(InvalidValue, match="control tick"):
        CompliantFollowing(model, approach(model), 5e-324)
    with pytest.raises(InvalidTarget, match="torques"):
        CompliantFollowing(model, approach(model)).command(model.home, np.full(7, np.nan))
    with pytest.raises(InvalidValue, match=r"CompliantConfig\.force"):
        CompliantConfig(force=0.0)
