"""A snapshot says what planning needs."""

from __future__ import annotations

import numpy as np

from rlbench_pin.scene.spec import BodySpec, SceneSpec
from tests.sim.support import HOME, build, close_on_cube, furniture_scene


def test_snapshot_of_furniture():
    """Room and bodies with collision geometry are there, with the frames of their colliding links and the robot's joints."""
    with build(furniture_scene()) as world:
        snapshot = world.snapshot()
        assert [b.name for b in snapshot.bodies] == ["table", "floor", "button", "chest", "cube"]
        assert [b.name for b in snapshot.bodies if b.in_room] == ["table", "floor"]
        chest = snapshot.body("chest")
        assert chest.link_names[0] == "chest" and "drawer_top_link" in chest.link_names
        row = chest.link_names.index("drawer_top_link")
        np.testing.assert_allclose(chest.link_poses[row], world.body("chest").link_pose("drawer_top_link"))
        assert chest.fixed and not snapshot.body("cube").fixed
        np.testing.assert_allclose(snapshot.configuration(), [*HOME, 0.04, 0.04])


def test_bodies_that_are_only_seen_are_left_out():
    """Markers have nothing to collide with."""
    ball = BodySpec(name="ball", asset="objects/ball_marker/ball_marker.urdf", fixed=True)
    with build(SceneSpec(format=1, body=(ball,))) as world:
        assert "ball" not in [b.name for b in world.snapshot().bodies]


def test_what_the_hand_holds():
    """A grasped body is named."""
    with build() as world:
        close_on_cube(world)
        world.gripper.grasp("cube")
        assert world.snapshot().attached == ("cube",)
