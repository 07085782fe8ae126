"""Sheets show the events of a demonstration, from a camera whose image contains the task."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.checking.sheets import demo_moments, events, moment_image, present_frame, task_view
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.observation import CAMERAS
from rlbench_pin.robot.geometry import bounds, box_corners, visual_geometry
from rlbench_pin.sim import World
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import find_task

FRAMES = 101
Poses = list[FloatArray]


def poses(begin: int, end: int) -> Poses:
    """One link that moves 1 m along x from one frame to another, and one that does not."""
    along = np.interp(np.arange(FRAMES), [begin, end], [0.0, 1.0])
    return [np.array([[x, 0, 0, 0, 0, 0, 1.0], [0, 0, 0, 0, 0, 0, 1.0]]) for x in along]


def since(frame: int) -> list[bool]:
    """Whether something holds that begins at a frame."""
    return [k >= frame for k in range(FRAMES)]


NEVER = since(FRAMES)


@pytest.mark.parametrize(
    ("motion", "holds", "touches", "expected"),
    [
        (poses(50, 70), since(42), since(40), {"reset": 0, "grasp": 42, "half way": 60, "success": 100}),
        (poses(85, 95), since(82), since(40), {"reset": 0, "first contact": 40, "grasp": 82, "half way": 90, "success": 100}),
        (poses(40, 60), NEVER, since(40), {"reset": 0, "first contact": 40, "half way": 50, "success": 100}),
        (poses(96, 99), NEVER, since(96), {"reset": 0, "approach": 72, "first contact": 96, "success": 100}),
        (poses(0, 100)[:1] * FRAMES, NEVER, NEVER, {"reset": 0, "half way": 50, "success": 100}),
        (poses(0, 1)[:2], NEVER, NEVER, {"reset": 0, "success": 1}),
    ],
)
def test_events(motion: Poses, holds: list[bool], touches: list[bool], expected: dict[str, int]) -> None:
    """A carry, a door before a grasp, a push, a button, a reach, and a demonstration of two frames; in order."""
    found = events(motion, holds[: len(motion)], touches[: len(motion)])
    assert found == expected
    assert list(found) == list(expected)


def test_a_long_demonstration_is_shown_in_quarters() -> None:
    """A long carry, after a door that took long."""
    frames = 800
    motion = [np.array([[x, 0, 0, 0, 0, 0, 1.0]]) for x in np.linspace(0.0, 8.0, frames + 1)]
    found = events(motion, [k >= 400 for k in range(frames + 1)], [k >= 20 for k in range(frames + 1)])
    quarters = ["a quarter", "half way", "three quarters"]
    assert list(found) == ["reset", "first contact", "before the grasp", "grasp", *quarters, "success"]
    assert list(found.values()) == pytest.approx([0, 20, 286, 400, 500, 600, 700, 800], abs=1)


@pytest.mark.simulation
@pytest.mark.parametrize(("name", "body", "joint"), [("pick_and_lift", "block", None), ("open_drawer", "chest", "drawer_bottom")])
def test_the_task_is_in_the_image(name: str, body: str, joint: str | None) -> None:
    """Moving links, before and after, and small bodies are in the image of the task view, and fill much of it."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        task.reset(seed=0, variation=0)
        world = task.world
        frames, corners = [present_frame(world)], corners_in(world, joint)
        moved = world.body(body)
        if joint is None:
            moved.set_pose(moved.pose + [0.0, 0.1, 0.2, 0.0, 0.0, 0.0, 0.0])
        else:
            moved.joint(joint).set_position(0.15)
        frames.append(present_frame(world))
        corners = np.concatenate([corners, corners_in(world, joint)])
        view = task_view(world, frames, 64)
    u, v, depth = view.to_image @ np.append(corners, np.ones((len(corners), 1)), axis=1).T
    pixels = np.stack([u, v]) / depth
    assert (depth > view.near).all()
    assert pixels.min() > 0.0
    assert pixels.max() < 64.0
    assert np.ptp(pixels, axis=1).max() > 0.5 * 64


@pytest.mark.simulation
def test_the_gripper_is_in_the_image_where_it_holds_an_object() -> None:
    """Fingers and hand, whole, between the first and the last frame."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("pick_and_lift")
        task.reset(seed=0, variation=0)
        world, robot = task.world, task.world.robot
        frames = [present_frame(world)]
        world.body("block").set_pose(robot.tip_pose())
        frames += [present_frame(world), present_frame(world)]
        view = task_view(world, frames, 64)
        shapes = [
            box_corners(bounds(visual_geometry(robot.model.urdf)[link]), robot.link_pose(link))
            for link in (robot.description.hand_link, *robot.description.finger_links)
        ]
    u, v, depth = view.to_image @ np.append(np.concatenate(shapes), np.ones((24, 1)), axis=1).T
    pixels = np.stack([u, v]) / depth
    assert pixels.min() > 0.0
    assert pixels.max() < 64.0


@pytest.mark.simulation
def test_the_camera_stands_on_the_side_from_which_an_object_comes() -> None:
    """It sees the socket into which the charger is plugged, not the back of the wall."""
    name = "plug_charger_in_power_supply"
    _, moments = demo_moments(find_task(name), 0, size=48)
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        task.reset(seed=0, variation=0)
        wall, charger = (task.world.body(body).position[:2] for body in ("panel", "charger"))
    assert (moments[0].view.pose[:2] - wall) @ (charger - wall) > 0.0


def corners_in(world: World, joint: str | None) -> FloatArray:
    """Corners (n, 3) of the boxes around all bodies or, with a joint, around the link that it moves [m]."""
    if joint is None:
        return np.concatenate([box_corners(body.bounds(), body.pose) for body in world.bodies.values()])
    (chest,) = world.bodies.values()
    link = f"{joint}_link"
    return box_corners(bounds(visual_geometry(chest.model.urdf, chest.model.scale)[link]), chest.link_pose(link))


@pytest.mark.simulation
def test_the_moments_of_a_demonstration() -> None:
    """Reset first, 1 s after success last, without the arm; each with the five cameras and the overview."""
    _, moments = demo_moments(find_task("close_drawer"), 0, size=64)
    assert moments[0].label == "reset, arm hidden on the left"
    assert moments[-2].label.startswith("success, ")
    assert moments[-1].label == "1 s after success, arm hidden on the left"
    for moment in moments:
        assert list(moment.cameras) == [*CAMERAS, "clear_robot_side"]
        assert moment_image(moment).height >= 64
    success, after = (np.asarray(moment.task).astype(int) for moment in moments[-2:])
    assert (np.abs(success - after).max(axis=2) > 40).mean() > 0.02
    assert np.array_equal(moments[-2].view.pose, moments[-1].view.pose)


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("name", "note"), [("pick_up_cup", ", object still held"), ("open_wine_bottle", ", object still held"), ("reach_target", "")]
)
def test_the_arm_stays_where_it_matters(name: str, note: str) -> None:
    """The arm is shown at the end where the gripper holds an object, and where nothing else moves."""
    _, moments = demo_moments(find_task(name), 0, size=48)
    assert moments[-1].label == f"1 s after success{note}"
