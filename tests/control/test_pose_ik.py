"""One pose, one configuration."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control import PoseIK
from rlbench_pin.errors import InvalidTarget, NoIkSolution
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import rotation_distance


@pytest.mark.simulation
def test_reachable_poses_are_reached(model: RobotModel) -> None:
    """Of 1000 poses that random configurations make, at least 995 are reached to 0.1 mm and 1 mrad, within the joint limits."""
    rng, ik, limits = np.random.default_rng(7), PoseIK(model), model.limits
    reached = 0
    for pose in [model.tip_pose(rng.uniform(limits.lower, limits.upper)) for _ in range(1000)]:
        try:
            solution = ik.solve(pose, model.home, rng)
        except NoIkSolution:
            continue
        tip = model.tip_pose(solution.q)
        assert limits.contains(solution.q)
        assert np.linalg.norm(tip[:3] - pose[:3]) <= 1e-4
        assert rotation_distance(tip, pose) <= 1e-3
        reached += 1
    assert reached >= 995


def test_a_pose_out_of_reach_raises_with_the_error_left(model: RobotModel) -> None:
    """The error says how near the arm came."""
    with pytest.raises(NoIkSolution) as caught:
        PoseIK(model).solve([2.0, 0, 1, 1, 0, 0, 0], model.home, np.random.default_rng(0))
    assert caught.value.position_error > 0.5


@pytest.mark.simulation
def test_the_same_seed_gives_the_same_configuration(model: RobotModel) -> None:
    """Solutions depend on the arguments and the generator alone."""
    ik, limits = PoseIK(model), model.limits
    poses = [model.tip_pose(np.random.default_rng(i).uniform(limits.lower, limits.upper)) for i in range(30)]
    first = [ik.solve(pose, model.home, np.random.default_rng(1)).q for pose in poses]
    again = [PoseIK(model).solve(pose, model.home, np.random.default_rng(1)).q for pose in reversed(poses)]
    np.testing.assert_array_equal(first, again[::-1])


def test_bad_poses_are_refused(model: RobotModel) -> None:
    """NaN and quaternions of norm zero are no poses."""
    for bad in ([np.nan] * 7, [0.3, 0, 1, 0, 0, 0, 0]):
        with pytest.raises(InvalidTarget):
            PoseIK(model).solve(bad, model.home, np.random.default_rng(0))
