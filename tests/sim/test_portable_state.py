"""A world as arrays without contact forces: stable bytes, and a way back."""

from __future__ import annotations

import numpy as np

from rlbench_pin.robot.catalogue import robot_description
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.sim import World


def test_arrays_without_contacts_have_stable_bytes_and_bring_back_poses_and_velocities() -> None:
    """Two worlds in the same state give the same bytes; setting them restores what was measured."""
    scene = SceneSpec(format=1, body=(BodySpec(name="cube", asset="objects/cube/cube.urdf", pose=(0.1, 0.1, 0.3, 0, 0, 0, 1)),))
    with World(scene, robot_description("panda")) as one, World(scene, robot_description("panda")) as two:
        for world in (one, two):
            world.robot.set_velocity_targets([0.3] * 7)
            for _ in range(3):
                world.step()
        first, second = one.arrays(exact=False), two.arrays(exact=False)
        assert first.keys() == second.keys()
        assert "physics" not in first
        assert all(first[name].tobytes() == second[name].tobytes() for name in first)
        for _ in range(5):
            two.step()
        two.set_arrays(first)
        again = two.arrays(exact=False)
        for name in ("body_poses", "body_velocities", "joint_states", "frame_poses"):
            assert np.allclose(again[name], first[name], atol=1e-9), name
        assert np.allclose(again["robot_joints"][:2], first["robot_joints"][:2], atol=1e-12)


def test_arrays_without_contacts_bring_back_bodies_that_were_removed_since() -> None:
    """A body of the moment is there again where it was; one that was added since is gone."""
    cube = BodySpec(name="cube", asset="objects/cube/cube.urdf", pose=(0.1, 0.1, 0.3, 0, 0, 0, 1))
    with World(SceneSpec(format=1), robot_description("panda")) as world:
        world.add_body("first", cube)
        moment, pose = world.arrays(exact=False), world.body("first").pose
        world.remove_body("first")
        world.add_body("second", cube)
        world.set_arrays(moment)
        assert list(world.bodies) == ["first"]
        assert np.allclose(world.body("first").pose, pose)
