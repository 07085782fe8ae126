"""Things are put elsewhere without building anew, and a frame of a recording is drawn without playing it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rlbench_pin.builder.worker.world import TaskWorld, joint_positions, only_moves
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.scene.reader import read_scene
from rlbench_pin.viewer.recording import Frame
from tests.builder.worker.conftest import Copied, Opened

_MOVES = {
    "pan": ('saucepan.urdf"\nfixed = true', 'saucepan.urdf"\nfixed = true\npose = [0.05, -0.1, 0.02]\nrpy = [0.0, 0.0, 0.4]'),
    "lid": ("[0.0, 0.0, 0.1215]", "[0.1, 0.0, 0.2]"),
    "placement": ("[placement]\n", "[placement]\npose = [0.3, 0.1, 0.0]\n"),
    "waypoint": ("[0.0, 0.0, -0.15]", "[0.0, 0.02, -0.1]"),
    "sensor": ("[0.0, 0.0, 0.25]", "[0.0, 0.0, 0.3]"),
    "frame's parent": ('name = "waypoint0"\nparent = "waypoint1"', 'name = "waypoint0"\nparent = "waypoint2"'),
    "grip": ('gripper = "close"', "gripper = 0.2"),
    "body": ("[[sensor]]", '[[body]]\nname = "cube"\nasset = "objects/cube/cube.urdf"\n\n[[sensor]]'),
}


@pytest.mark.parametrize("edit", _MOVES)
def test_an_edit_in_place_is_what_building_gives(copied: Copied, opened: Opened, world: TaskWorld, edit: str) -> None:
    """All poses, verdicts and episodes are those of a task that was opened with the new scene."""
    text = copied("take_lid_off_saucepan")
    changed = replace(text, scene=text.scene.replace(*_MOVES[edit], 1))
    assert changed.scene != text.scene
    opened(text)
    world.reset(3, 0)
    placed = opened(changed, place=True)
    in_place, episode = world.reach(), None
    assert placed == opened(changed)
    built = world.reach()
    for a, b in zip(in_place, built, strict=True):
        assert (a.waypoint, a.standing) == (b.waypoint, b.standing)
        assert np.abs(a.pose - b.pose).max() < 1e-9
    episode = world.reset(4, 0).frames[0]
    opened(text)
    opened(changed, place=True)
    again = world.reset(4, 0).frames[0]
    assert all(np.array_equal(again.poses[name], pose) for name, pose in episode.poses.items())


def test_what_counts_as_a_move(copied: Copied) -> None:
    """Poses and the placement; not what elements are, nor how they hang together."""
    text = copied("take_lid_off_saucepan")
    file = text.folder / "take_lid_off_saucepan.toml"
    before = read_scene(file)
    quick = {}
    for name, (old, new) in _MOVES.items():
        file.write_text(text.scene.replace(old, new, 1), encoding="utf-8")
        quick[name] = only_moves(before, read_scene(file))
    assert quick == {name: name not in ("frame's parent", "grip", "body") for name in _MOVES}


def test_a_scene_that_breaks_and_is_mended(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """What is wrong is said at its line; with the next good text everything goes on."""
    text = copied("take_lid_off_saucepan")
    opened(text)
    broken = replace(text, scene=text.scene.replace("gripper =", "griper ="))
    (problem,) = opened(broken, place=True).problems
    assert problem.line is not None
    assert "griper" in broken.scene.splitlines()[problem.line - 1]
    assert opened(text, place=True).problems == ()
    assert {verdict.standing for verdict in world.reach()} == {"free"}


def test_a_joint_is_moved_in_place(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """A slider of the view, without building anew."""
    text = copied("push_button")
    opened(text)
    pressed = replace(text, scene=text.scene.replace("spring =", "position = 0.005\nspring ="))
    file = text.folder / "push_button.toml"
    before = read_scene(file)
    opened(pressed, place=True)
    assert only_moves(before, read_scene(file))
    frames: list[Frame] = []
    world.reset(0, 0)
    opened(text)
    opened(pressed, place=True)
    world.simulate(0.05, frames.append)
    gap = frames[0].poses["button/base"][2] - frames[0].poses["button/cap"][2]
    opened(text)
    world.simulate(0.05, frames.append)
    assert gap - (frames[-2].poses["button/base"][2] - frames[-2].poses["button/cap"][2]) == pytest.approx(0.005, abs=1e-6)


@pytest.mark.parametrize("name", ["open_drawer", "open_door", "open_washing_machine"])
def test_joints_follow_from_where_links_are(name: str) -> None:
    """For every joint that moves in a demonstration."""
    with make_environment(low_dim_config()) as environment:
        world = environment.get_task(name).world
        for body in world.bodies.values():
            for number, joint in enumerate(body.joints.values(), start=1):
                low, high = max(joint.lower, -2.0), min(joint.upper, 2.0)
                joint.set_position(low + 0.1 * number % 1.0 * (high - low))
            found = joint_positions(body, {link: body.link_pose(link) for link in body.links})
            for joint_name, joint in body.joints.items():
                assert found[joint_name] == pytest.approx(joint.position, abs=1e-6)


@pytest.mark.simulation
def test_a_frame_is_drawn_without_being_played(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """The cameras see it as they saw it when it was played, colours too; the world is as before."""
    opened(copied("push_button"))
    frames: list[Frame] = []
    assert world.demonstrate(2, 4, frames.append).failure is None
    at_the_end = world.images(48)
    assert list(at_the_end) == ["left_shoulder", "right_shoulder", "overhead", "wrist", "front"]
    world.reset(7, 1)
    here = world.images(48)
    drawn = world.images(48, frames[-1])
    for name, image in drawn.items():
        assert image.shape == (48, 48, 3)
        assert image.dtype == np.uint8
        assert np.abs(image.astype(int) - at_the_end[name]).mean() < 1.0
        assert np.array_equal(world.images(48)[name], here[name])
    assert np.abs(drawn["overhead"].astype(int) - here["overhead"]).mean() > 1.0
