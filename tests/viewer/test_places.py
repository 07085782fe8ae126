"""Places at rest are those of a world that has just been built."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.robot import robot_description
from rlbench_pin.scene import BodySpec, FrameSpec, JointSpec, SceneSpec, read_scene
from rlbench_pin.sim.world import World
from rlbench_pin.spatial import FloatArray, rotation_distance, se3_to_pose
from rlbench_pin.tasks.registry import LIBRARY
from rlbench_pin.viewer.places import places_at_rest

TOLERANCE = 1e-6


def _apart(a: FloatArray, b: FloatArray) -> float:
    return max(float(np.abs(a[:3] - b[:3]).max()), rotation_distance(a, b))


@pytest.mark.simulation
@pytest.mark.parametrize("task", ["close_box", "open_wine_bottle", "straighten_rope", "weighing_scales", "light_bulb_out"])
def test_places_are_those_of_the_simulation(task: str) -> None:
    """Every link and every frame, through joints, scales and chains of parents."""
    spec = read_scene(LIBRARY / f"{task}.toml")
    places = places_at_rest(spec)
    with World(spec, robot_description("panda")) as world:
        links = {f"{b.name}/{link}": world.body(b.name).link_pose(link) for b in spec.body for link in world.body(b.name).links}
        frames = {name: se3_to_pose(frame.placement()) for name, frame in world.frames.items()}
    assert set(places.links) == set(links)
    assert set(frames) <= set(places.elements)
    assert max(_apart(pose, places.links[name]) for name, pose in links.items()) < TOLERANCE
    assert max(_apart(pose, places.elements[name]) for name, pose in frames.items()) < TOLERANCE


@pytest.mark.simulation
def test_a_scaled_drawer_opens_by_as_much_as_in_simulation() -> None:
    """Positions of sliding joints are not scaled, lengths of the file are."""
    chest = BodySpec(name="chest", asset="objects/chest/chest.urdf", fixed=True, scale=0.5)
    source = read_scene(LIBRARY / "open_drawer.toml")
    joint = JointSpec(name="chest/drawer_top", position=0.05)
    asset = next(body.asset for body in source.body if body.name == "chest")
    spec = SceneSpec(format=2, body=(chest.model_copy(update={"asset": asset}),), joint=(joint,))
    places = places_at_rest(spec)
    with World(spec, robot_description("panda")) as world:
        pose = world.body("chest").link_pose("drawer_top_link")
    assert _apart(pose, places.links["chest/drawer_top_link"]) < TOLERANCE


def test_what_has_no_place_is_told(tmp_path: Path) -> None:
    """A body without a file keeps its place, what hangs on its links has none."""
    body = BodySpec(name="thing", asset="./gone.urdf")
    frames = FrameSpec(name="mark", parent="thing"), FrameSpec(name="lost", parent="thing/lid")
    places = places_at_rest(SceneSpec(format=2, body=(body,), frame=frames, file=str(tmp_path / "scene.toml")))
    assert set(places.missing) == {"thing", "lost"}
    assert "gone.urdf" in places.missing["thing"]
    assert "thing/lid" in places.missing["lost"]
    assert places.of("mark") is not None
    assert places.of("lost") is None


def test_a_thing_moved_by_hand_takes_its_children_along() -> None:
    """Given poses replace those of the file, and children follow."""
    body = BodySpec(name="cube", asset="objects/cube/cube.urdf")
    top = FrameSpec(name="top", parent="cube", pose=(0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0))
    places = places_at_rest(SceneSpec(format=2, body=(body,), frame=(top,)), {"cube": np.array([1.0, 2.0, 3.0, 0, 0, 0, 1])})
    assert places.elements["top"][:3].tolist() == pytest.approx([1.0, 2.0, 3.1])
    assert places.links["cube/cube"][:3].tolist() == [1.0, 2.0, 3.0]
