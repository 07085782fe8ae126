"""Analytic derivatives equal finite differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rlbench_pin.robot.dynamics import (
    forward_dynamics_derivatives,
    inverse_dynamics_derivatives,
    jacobian_derivative,
    manipulability_gradient,
)
from rlbench_pin.robot.model import RobotModel

STEP = 1e-6


def differences(function: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> np.ndarray:
    """Return central differences of a function, the derivative by x_k in entry k of the last axis."""
    columns = [(function(x + STEP * e) - function(x - STEP * e)) / (2.0 * STEP) for e in np.eye(len(x))]
    return np.stack(columns, axis=-1)


def close(analytic: np.ndarray, numeric: np.ndarray) -> None:
    """Check equality within 1e-6 of the largest entry."""
    np.testing.assert_allclose(analytic, numeric, atol=1e-6 * max(1.0, float(np.abs(analytic).max())))


def state(model: RobotModel, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a random configuration, velocity and acceleration."""
    rng = np.random.default_rng(seed)
    return rng.uniform(model.limits.lower, model.limits.upper), rng.normal(size=7), rng.normal(size=7)


@pytest.mark.parametrize("seed", range(5))
def test_inverse_dynamics(model: RobotModel, seed: int) -> None:
    """Torques by configuration, velocity and acceleration."""
    q, v, a = state(model, seed)
    derivatives = inverse_dynamics_derivatives(model, q, v, a)
    close(derivatives.by_q, differences(lambda x: model.inverse_dynamics(x, v, a), q))
    close(derivatives.by_v, differences(lambda x: model.inverse_dynamics(q, x, a), v))
    close(derivatives.by_input, model.mass_matrix(q))


@pytest.mark.parametrize("seed", range(5))
def test_forward_dynamics(model: RobotModel, seed: int) -> None:
    """Accelerations by configuration, velocity and torque."""
    q, v, tau = state(model, seed)
    derivatives = forward_dynamics_derivatives(model, q, v, tau)
    close(derivatives.by_q, differences(lambda x: model.forward_dynamics(x, v, tau), q))
    close(derivatives.by_v, differences(lambda x: model.forward_dynamics(q, x, tau), v))
    close(derivatives.by_input, np.linalg.inv(model.mass_matrix(q)))


@pytest.mark.parametrize("seed", range(5))
def test_jacobian(model: RobotModel, seed: int) -> None:
    """The tip Jacobian by configuration, in both frames; along a motion it is the time derivative."""
    q, v, _ = state(model, seed)
    for frame in ("world", "tip"):
        analytic = jacobian_derivative(model, q, frame)
        close(np.moveaxis(analytic, 0, -1), differences(lambda x, f=frame: model.jacobian(x, f), q))
        close(np.einsum("k,kij->ij", v, analytic), model.jacobian_dot(q, v, frame))


@pytest.mark.parametrize("seed", range(5))
def test_manipulability(model: RobotModel, seed: int) -> None:
    """The gradient of the manipulability."""
    q, _, _ = state(model, seed)
    close(manipulability_gradient(model, q), differences(lambda x: np.array(model.manipulability(x)), q))
