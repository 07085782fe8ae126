"""What the analytic model adds to an observation."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from rlbench_pin.environment import Discrete, Environment, JointPosition, ModelObservationConfig, MoveArmThenGripper
from rlbench_pin.environment.presets import low_dim_config

EVERYTHING = ModelObservationConfig(
    tip_jacobian=True,
    tip_jacobian_dot=True,
    mass_matrix=True,
    gravity=True,
    coriolis=True,
    manipulability=True,
    world_distances=3,
    self_distances=1,
)


def test_it_is_off_by_default() -> None:
    """No key is added unless asked for."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config()) as env:
        _, obs = env.get_task("pick_and_lift").reset(seed=0)
        assert not {f.name for f in fields(ModelObservationConfig)} & set(obs.misc)


def test_what_is_asked_for_is_right() -> None:
    """Matrices equal the model's at the measured joints; the nearest world pair is measured between its points."""
    config = low_dim_config()
    config.model = EVERYTHING
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config) as env:
        task = env.get_task("pick_and_lift")
        _, obs = task.reset(seed=0)
        model, q = task.runtime.model, obs.joint_positions
        assert np.allclose(obs.misc["tip_jacobian"], model.jacobian(q))
        assert np.allclose(obs.misc["mass_matrix"], model.mass_matrix(q))
        assert np.allclose(obs.misc["gravity"], model.gravity(q))
        assert obs.misc["tip_jacobian_dot"].shape == (6, 7)
        assert obs.misc["coriolis"].shape == (7,)
        assert obs.misc["manipulability"] > 0.0
        nearest = obs.misc["world_distances"]
        assert [d.distance for d in nearest] == sorted(d.distance for d in nearest)
        assert len(nearest) == 3
        for pair in (*nearest, *obs.misc["self_distances"]):
            assert np.isclose(np.linalg.norm(pair.point_b - pair.point_a), abs(pair.distance), atol=1e-4)
            assert np.isclose(np.linalg.norm(pair.normal), 1.0)
        bodies = {body.name for body in task.world.snapshot().bodies}
        assert all(pair.b in bodies or pair.a in bodies for pair in nearest)
        assert all(pair.b not in bodies for pair in obs.misc["self_distances"])


def test_the_jacobian_derivative_is_the_finite_difference() -> None:
    """dJ/dt agrees with two Jacobians along the motion within 1e-6 of its size per microsecond step."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config()) as env:
        task = env.get_task("reach_target")
        task.reset(seed=0)
        model = task.runtime.model
        rng = np.random.default_rng(0)
        for _ in range(20):
            q, v = rng.uniform(model.limits.lower, model.limits.upper), rng.normal(size=7)
            h = 1e-6
            difference = (model.jacobian(q + h * v).copy() - model.jacobian(q - h * v).copy()) / (2 * h)
            assert np.abs(model.jacobian_dot(q, v) - difference).max() < 1e-6
