"""Where resets put a task: as the specification and the footprint say, or what the arm cannot reach is a listed deviation."""

from __future__ import annotations

from unittest.mock import patch

import numpy as np
import pytest

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.robot.description import robot_description
from rlbench_pin.scene import DeviationSpec, SceneSpec
from rlbench_pin.sim import World
from rlbench_pin.spatial import quaternion_yaw
from rlbench_pin.tasks import Task, place_task
from rlbench_pin.tasks.placement import footprint
from tests.tasks.figures import specification

SPECIFIED = specification()
DRAWS, FIRST_SEED = 1000, 9000
SPREAD = 0.1
"""The middle nine tenths of the drawn x, and of the drawn y, lie no closer together [m]; `spread` is the lesser of both."""
IN_REACH = 0.9
"""So many of the drawn placements are accepted; `placements in reach` is the share."""
DISTANCE = 2.2
"""Distributions of n and m values are taken as alike up to this times sqrt(1/n + 1/m): one in 8,000 pairs is farther apart."""


@pytest.mark.parametrize(("resets", "slack"), [(40, 0.15), pytest.param(200, 0.05, marks=pytest.mark.slow)])
def test_what_resets_accept_is_spread_as_declared(task_env: TaskEnvironment, resets: int, slack: float) -> None:
    """x, y and yaw of the task lie as a draw of them does, the yaw as specified; what reach takes away is listed."""
    accepted, share = played(task_env, resets)
    declared = draws(task_env.task)
    listed = {entry.name: entry for entry in task_env.task.world.spec.deviation}
    if SPECIFIED[task_env.get_name()]["static"] == [1.0]:
        assert not np.ptp(accepted, axis=0).any()
        return
    low, high = np.quantile(declared[:, :2], (0.05, 0.95), axis=0)
    check_figure("spread", float((high - low).min()), SPREAD, 0.01, listed)
    check_figure("placements in reach", share, IN_REACH, slack, listed)
    yaws = np.linspace(*SPECIFIED[task_env.get_name()]["yaw"], DRAWS)
    narrower = 1.0 - share if "placements in reach" in listed else 0.0
    for name, here, asked in zip(("x", "y", "yaw"), accepted.T, (*declared.T[:2], yaws), strict=True):
        limit = DISTANCE * np.sqrt(1.0 / resets + 1.0 / DRAWS) + narrower
        assert apart(here, asked) <= limit, f"{name} is not spread as declared"


def check_figure(name: str, here: float, least: float, slack: float, listed: dict[str, DeviationSpec]) -> None:
    """Check that a figure is large enough, or that the deviation which is listed names it."""
    if name not in listed:
        assert here >= least - slack, f"{name} is {here:.3f}: mend it or list a deviation"
        return
    text = listed[name].here.partition(":")[0]
    said = float(text.split()[0]) / (100.0 if "%" in text else 1.0)
    assert said < least, f"{name} is as declared: strike the deviation"
    assert abs(said - here) <= slack, f"{name} is {here:.3f}, listed as {text}"


def played(task_env: TaskEnvironment, resets: int) -> tuple[np.ndarray, float]:
    """Return x, y [m] and yaw [rad] of the task after resets, (resets, 3), and which share of what was drawn these are."""
    accepted, drawn = [], []

    def noting(task: Task, rng: np.random.Generator) -> None:
        place(task, rng)
        drawn.append(task.world.root.pose)

    place = Task.place
    with patch.object(Task, "place", noting):
        for number in range(resets):
            task_env.reset(seed=FIRST_SEED + number, variation=number % task_env.variation_count())
            accepted.append(placement(task_env.task.world))
    return np.array(accepted), len(accepted) / max(len(drawn), len(accepted))


def draws(task: Task) -> np.ndarray:
    """Return x, y [m] and yaw [rad] of as many placements as it takes to know how they are spread, whether in reach or not."""
    rng, (low, high) = np.random.default_rng(FIRST_SEED), footprint(task.world)
    patch_of_table = {"footprint": tuple(high - low), "footprint_center": tuple((low + high) / 2.0)}
    scene = SceneSpec(format=2, placement=task.world.spec.placement.model_copy(update=patch_of_table))
    found = []
    with World(scene, robot_description("panda")) as world:
        for _ in range(DRAWS):
            place_task(world, rng, task.base_rotation_bounds())
            found.append(placement(world))
    return np.array(found)


def placement(world: World) -> np.ndarray:
    """Return x, y [m] and yaw [rad] of the root."""
    pose = world.root.pose
    return np.array([*pose[:2], quaternion_yaw(pose[3:])])


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Return how far the distributions of two samples are apart, from 0 to 1 (Kolmogorov and Smirnov)."""
    values = np.concatenate([one, other])
    below = [np.searchsorted(np.sort(sample), values, side="right") / len(sample) for sample in (one, other)]
    return float(np.abs(below[0] - below[1]).max())
