"""The five cameras stand at their known poses; the clear view shows what two of them hide."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from rlbench_pin.environment import CameraConfig, ObservationConfig, TaskEnvironment, clear_view, make_environment
from rlbench_pin.environment.observations.observe import camera_view
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description

# name -> field of view [deg], near [m], far [m], position [m]; the wrist camera rides on the hand
KNOWN = {
    "left_shoulder": (40.0, 0.01, 3.2, (-0.175, 0.2, 1.98)),
    "right_shoulder": (40.0, 0.01, 3.2, (-0.175, -0.2, 1.98)),
    "overhead": (40.0, 0.01, 3.3, (-0.175, 0.0, 2.43)),
    "front": (40.0, 0.01, 4.5, (1.35, 0.0, 1.58)),
    "wrist": (60.0, 0.01, 3.5, None),
}
FOCAL = {40.0: -175.84, 60.0: -110.85}
"""Field of view [deg] -> focal length at 128 px [px]."""


@pytest.fixture(scope="module")
def task_env() -> Iterator[TaskEnvironment]:
    """reach_target at its reset, with default cameras."""
    with make_environment(ObservationConfig()) as environment:
        task = environment.get_task("reach_target")
        task.reset(seed=0)
        yield task


@pytest.mark.parametrize("name", KNOWN)
def test_known_cameras_to_the_digit(task_env: TaskEnvironment, name: str) -> None:
    """Position, field of view, planes and focal length are those that agents trained elsewhere expect."""
    fov, near, far, position = KNOWN[name]
    view = camera_view(name, CameraConfig(), task_env.world, task_env.runtime.description)
    assert (round(float(np.degrees(view.fov)), 9), view.near, view.far) == (fov, near, far)
    if position is not None:
        assert np.allclose(view.pose[:3], position, atol=1e-9)
    observation = task_env.get_observation()
    intrinsics = observation.misc[f"{name}_camera_intrinsics"]
    assert round(float(intrinsics[0, 0]), 2) == round(float(intrinsics[1, 1]), 2) == FOCAL[fov]


def test_the_clear_view_shows_hand_and_table_top(task_env: TaskEnvironment) -> None:
    """At the reset `front` hardly has the hand; `clear_front` has all of it, and the arm hides less of the table from above."""
    world, robot = task_env.world, task_env.runtime.description
    task_env.reset(seed=0)
    masks = {name: world.render(extra.view(world, robot)).mask for name, extra in clear_view().items()}
    for name in ("front", "overhead"):
        masks[name] = world.render(camera_view(name, CameraConfig(), world, robot)).mask

    def share(view: str, part: str) -> float:
        ids = [i for i in np.unique(masks[view]) if part in world.masks[i]]
        return float(np.isin(masks[view], ids).mean())

    hand = np.isin(masks["clear_front"], [i for i in np.unique(masks["clear_front"]) if "panda_hand" in world.masks[i]])
    assert hand.sum() > 60 and not hand[0].any()
    assert share("clear_overhead", "panda") < 0.6 * share("overhead", "panda")
    assert share("clear_overhead", "table") > share("overhead", "table")


def test_the_view_from_behind_the_robot_sees_the_fronts_of_appliances() -> None:
    """Of a closed microwave `clear_robot_side` sees the door, which `clear_front` does not."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("open_microwave")
        task.reset(seed=0, variation=0)
        world, robot = task.world, robot_description(DEFAULT_ROBOT)
        door = next(i for i, name in world.masks.items() if name.endswith("door_link"))
        seen = {name: (world.render(extra.view(world, robot)).mask == door).sum() for name, extra in clear_view().items()}
    assert seen["clear_robot_side"] > 150 > 3 * seen["clear_front"]
