"""Waypoints with `compliant = true`: openings that are not where the scene file says, and grasps that are not exact."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.environment.replay import replay_succeeds
from rlbench_pin.spatial import FloatArray, compose, pose_at, relative

pytestmark = pytest.mark.simulation
BESIDE = [-0.0455, 0.0025, 0.1505, 0.0, 1.0, 0.0, 0.0]
"""A pose of the tip that misses the holes, whose walls leave 2 mm, by 2.9 mm."""


def aim_beside(task: TaskEnvironment, compliant: bool) -> None:
    """Let the charger be pushed into the wall beside the holes."""
    _, _, before, insertion, _ = task.task.get_waypoints()
    before.set_hooks(lambda _: insertion.frame.set_local(BESIDE), None)
    insertion.spec = insertion.spec.model_copy(update={"compliant": compliant})


def test_the_holes_are_found() -> None:
    """Pushed 3 mm beside them, the pins find their holes, and the recorded actions replay; without the option they do not."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("plug_charger_in_power_supply")
        aim_beside(task, compliant=False)
        assert not any(task.try_demo(seed=seed).success for seed in range(3))
        aim_beside(task, compliant=True)
        outcomes = [task.try_demo(seed=seed) for seed in range(3)]
        assert all(outcome.success for outcome in outcomes), [outcome.cause for outcome in outcomes]
        forces = [np.abs(frame.joint_forces).max() for outcome in outcomes for frame in outcome.demo or ()]
        assert max(forces) < 87.0
        demo = outcomes[0].demo
        assert demo is not None
        assert replay_succeeds(task, demo)


@pytest.mark.parametrize("off", [pose_at((0.006, 0.0, 0.0)), pose_at((0.0, 0.0, 0.0), pitch=0.12)], ids=["shifted", "tilted"])
def test_the_grasp_as_measured_is_taken_into_account(off: FloatArray) -> None:
    """Gripped 6 mm off, or 7 degrees askew, the charger arrives as exactly as otherwise."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("plug_charger_in_power_supply")
        grasp, _, before, insertion, _ = task.task.get_waypoints()
        exact, arrived = grasp.frame.local, []
        grasp.set_hooks(lambda w: w.frame.set_local(compose(exact, off)), lambda w: w.frame.set_local(exact))
        insertion.set_hooks(None, lambda w: arrived.append(relative(grasp.frame.pose, w.pose)))
        before.spec = before.spec.model_copy(update={"compliant": True})
        insertion.spec = insertion.spec.model_copy(update={"compliant": True, "gripper": None})
        task.try_demo(seed=0)
        assert np.linalg.norm(arrived[0][:3]) < 1e-3
        assert 2.0 * np.arccos(abs(arrived[0][6])) < 0.01
