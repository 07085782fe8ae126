"""Velocity bounds that keep joint limits at all times."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control.qp.constraints import HeldQuantity, JointBounds, largest_step, stopping_room
from rlbench_pin.robot.model import RobotModel

DT = 0.05


def test_the_largest_step_is_the_one_that_just_stops() -> None:
    """Function g inverts f, and f is the sum of the speeds of the braking ticks."""
    speeds = np.linspace(0.0, 9.7, 200)
    steps = [largest_step(room, 0.3) for room in (0.3 * stopping_room(speeds)).tolist()]
    np.testing.assert_allclose(steps, 0.3 * speeds, atol=1e-12)
    assert stopping_room(np.array([2.5]))[0] == pytest.approx(2.5 + 1.5 + 0.5)
    assert largest_step(-0.1, 0.3) == -0.1


@pytest.mark.parametrize("hold", ["velocity", "acceleration", "any"])
@pytest.mark.parametrize("policy", ["random", "outward"])
def test_limits_hold_whatever_is_chosen_inside_the_interval(model: RobotModel, hold: HeldQuantity, policy: str) -> None:
    """Choosing any point of the interval for long keeps position, velocity and acceleration limits, and never empties it."""
    rng, limits = np.random.default_rng(1), model.limits
    bounds = JointBounds(limits, DT, hold)
    q, v = model.home.copy(), np.zeros(model.size)
    for k in range(4000):
        slowest, fastest = bounds.interval(q, v)
        assert np.all(slowest <= fastest + 1e-12)
        direction = np.sin(0.02 * k * (1.0 + np.arange(model.size))) > 0.0
        share = rng.random(model.size) if policy == "random" else direction.astype(float)
        u = slowest + share * (fastest - slowest)
        assert np.all(np.abs(u) <= limits.velocity + 1e-12)
        assert np.all(np.abs(u - v) <= DT * limits.acceleration + 1e-12)
        late = {"velocity": 0.0, "acceleration": 0.5, "any": 0.5 * rng.random(model.size)}[hold]
        q = q + DT * (u + late * (v - u))
        v = u
        assert limits.contains(q, 1e-9)


def test_the_bounds_are_tight(model: RobotModel) -> None:
    """A joint that always goes as fast upwards as it may comes to rest at its limit, not before it."""
    bounds, q, v = JointBounds(model.limits, DT), model.home.copy(), np.zeros(model.size)
    for _ in range(200):
        v = bounds.interval(q, v)[1]
        q = q + DT * v
    np.testing.assert_allclose(q, model.limits.upper, atol=1e-9)


def test_a_state_outside_brakes_then_returns(model: RobotModel) -> None:
    """Beyond a limit the interval is one point: the hardest braking, then the way back, within the acceleration limit."""
    bounds, v = JointBounds(model.limits, DT), 2.0 * np.ones(model.size)
    q = model.limits.upper + 0.05
    for _ in range(60):
        slowest, fastest = bounds.interval(q, v)
        assert np.all(slowest <= fastest + 1e-12)
        assert np.all(np.abs(fastest - v) <= DT * model.limits.acceleration + 1e-12)
        v = fastest
        q = q + DT * v
    assert model.limits.contains(q, 1e-9)


def test_travel_is_what_braking_takes(model: RobotModel, rng: np.random.Generator) -> None:
    """The travel of a command is the sum over its own and the braking ticks."""
    bounds = JointBounds(model.limits, DT)
    u = rng.uniform(-bounds.velocity, bounds.velocity)
    way, speed = np.zeros(model.size), u.copy()
    while speed.any():
        way += DT * np.abs(speed)
        speed = bounds.braking(speed)
    np.testing.assert_allclose(bounds.travel(np.zeros(model.size), u), way, atol=1e-12)


def test_a_tick_has_to_take_time(model: RobotModel) -> None:
    """A tick of zero seconds is refused."""
    with pytest.raises(ValueError, match="control tick"):
        JointBounds(model.limits, 0.0)


def test_sudden_changes_leave_what_can_stop_in_time(model: RobotModel) -> None:
    """Without a limit on changes of velocity, the largest next velocity is the one from which braking stops at the limit."""
    limits, step = model.limits, DT * model.limits.acceleration
    sudden, usual = JointBounds(limits, DT, sudden=True), JointBounds(limits, DT)
    q, v = limits.upper - 0.05, np.zeros(model.size)
    highest = sudden.interval(q, v)[1]
    np.testing.assert_allclose(sudden.travel(v, highest), 0.05, atol=1e-12)
    np.testing.assert_allclose(usual.interval(q, v)[1], np.minimum(highest, step), atol=1e-12)
    np.testing.assert_allclose(sudden.interval(model.home, v)[1][0], limits.velocity[0])
