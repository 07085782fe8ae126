"""Saving and restoring a world: in memory, and as arrays."""

from __future__ import annotations

import hashlib
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot.description import robot_description
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.sim import World
from rlbench_pin.spatial import TABLE_HEIGHT
from tests.sim.support import (
    ABOVE,
    AROUND,
    HOME,
    UPRIGHT,
    build,
    close_on_cube,
    cube,
    cube_scene,
    digest,
    fingers,
    furniture_scene,
    move,
    steps,
)


def clutter() -> SceneSpec:
    """Hollow things with things in them: many convex parts in contact."""
    heights = {"saucepan": TABLE_HEIGHT, "bin": TABLE_HEIGHT, "grill": TABLE_HEIGHT}
    names = ("saucepan", "bin", "grill", "steak", "chicken", "rubbish")
    places = ((0.25, -0.3), (0.1, 0.25), (0.4, 0.2))
    bodies = [
        BodySpec(name=n, asset=f"objects/{n}/{n}.urdf", parent="world", pose=(*places[i % 3], heights.get(n, 0.9), *UPRIGHT))
        for i, n in enumerate(names)
    ]
    return SceneSpec(format=1, body=tuple(bodies))


def wander(world: World) -> None:
    """Make a history that has nothing to do with what follows."""
    world.robot.set_velocity_targets(0.2 * np.array([1, -1, 0, 1, 0, 1, 0]))
    steps(world, 5)
    for body in world.bodies.values():
        if not body.fixed:
            body.set_pose(body.pose + [0.01, 0.0, 0.02, 0, 0, 0, 0])
        body.set_color((0.3, 0.3, 0.3))
    world.gripper.set_target(0.2, 0.2)
    steps(world, 5)


def go_on(world: World) -> bytes:
    """A few ticks in every mode."""
    parts = []
    for k in range(3):
        world.robot.set_position_targets(world.robot.joint_positions + 0.01 * k)
        world.step()
        parts.append(digest(world))
    world.robot.set_velocity_targets(np.full(7, 0.05))
    steps(world, 2)
    world.robot.set_torques(np.zeros(7))
    steps(world, 2)
    return b"".join([*parts, digest(world)])


@pytest.mark.simulation
@pytest.mark.parametrize("ticks", [0, 2, 15])
def test_restoring_repeats_to_the_last_bit_whatever_happened_before(ticks):
    """Going on after saving, after restoring, and after restoring from elsewhere is the same, also with many parts."""
    with build(clutter()) as world:
        steps(world, ticks)
        saved = world.save()
        first = go_on(world)
        world.restore(saved)
        assert go_on(world) == first
        wander(world)
        world.restore(saved)
        assert go_on(world) == first


@pytest.mark.simulation
def test_a_grasp_is_restored():
    """Attachments, finger commands and collision filters come back, also after a release and another grasp."""
    with build() as world:
        close_on_cube(world)
        free = world.save()
        world.gripper.grasp("cube")
        move(world, ABOVE)
        held = world.save()
        first = go_on(world)
        world.gripper.release()
        steps(world, 10)
        world.restore(held)
        assert world.gripper.grasped == ("cube",)
        assert go_on(world) == first
        world.restore(free)
        assert world.gripper.grasped == ()
        fingers(world, 1.0)
        move(world, ABOVE)
        assert world.body("cube").position[2] < 0.8
        world.restore(held)
        assert go_on(world) == first


def test_everything_beside_the_physics_comes_back():
    """Frames, parents, colours, collisions, locks, graspable flags, time and modes are as they were."""
    with build(furniture_scene()) as world:
        steps(world, 2)
        saved, spot = world.save(), world.frame("spot").pose
        world.frame("spot").set_pose(world.frame("corner").pose)
        world.frame("corner").set_parent("chest", keep_in_place=True)
        world.body("cube").set_collides(False)
        world.body("cube").graspable = True
        world.body("button").set_color((0, 1, 0), "cap")
        world.joint("chest/drawer_middle").unlock()
        world.joint("chest/drawer_top").lock()
        world.robot.set_torques(np.zeros(7))
        steps(world, 3)
        world.restore(saved)
        np.testing.assert_array_equal(world.frame("spot").pose, spot)
        assert world.frame("corner").parent == "world"
        assert world.body("cube").collides and not world.body("cube").graspable
        assert world.body("button").colors == {}
        assert world.joint("chest/drawer_middle").locked and not world.joint("chest/drawer_top").locked
        assert world.robot.mode == "position"
        assert world.time == pytest.approx(0.1)
        steps(world, 5)
        np.testing.assert_allclose(world.robot.joint_positions, HOME, atol=1e-3)
        assert world.body("cube").position[2] > TABLE_HEIGHT + 0.018


def test_bodies_added_later_are_removed_and_missing_ones_come_back():
    """Run-time bodies are part of the state, and going on is exact with them too."""
    with build() as world:
        clean = world.save()
        for i in range(3):
            world.add_body(f"drop{i}", cube("any", 0.0, 0.2 + 0.06 * i, 0.80))
        steps(world, 3)
        three = world.save()
        first = go_on(world)
        world.restore(clean)
        assert list(world.bodies) == ["cube"]
        world.restore(three)
        assert list(world.bodies) == ["cube", "drop0", "drop1", "drop2"]
        assert go_on(world) == first
        world.restore(three)
        world.remove_body("drop1")
        world.restore(three)
        assert list(world.bodies) == ["cube", "drop0", "drop1", "drop2"]
        assert go_on(world) == first
        world.restore(clean)
        assert list(world.masks)[-1] == 61


@pytest.mark.simulation
def test_pictures_after_restoring_are_equal():
    """What a camera sees after restoring is byte-equal."""
    from tests.sim.render.test_camera import looking

    view = looking((1.35, 0.0, 1.58), (0.15, 0.0, 0.9), fov=40.0, size=(64, 64))
    with build(clutter()) as world:
        steps(world, 3)
        saved, before = world.save(), world.render(view, shadows=True)
        wander(world)
        world.restore(saved)
        after = world.render(view, shadows=True)
        for a, b in ((before.rgb, after.rgb), (before.depth, after.depth), (before.mask, after.mask)):
            np.testing.assert_array_equal(a, b)


def test_contacts_after_restoring_are_those_of_the_state():
    """What touches what is known right after restoring."""
    with build() as world:
        close_on_cube(world)
        saved, touching = world.save(), world.robot.touching()
        assert touching == ("cube",)
        fingers(world, 1.0)
        move(world, ABOVE)
        assert world.robot.touching() == ()
        world.restore(saved)
        assert world.robot.touching() == touching


def test_a_state_of_another_world_is_refused():
    """States belong to their world; arrays belong to their scene."""
    with build() as one, build(furniture_scene()) as other:
        with pytest.raises(RlbenchPinError, match="another world"):
            one.restore(other.save())
        with pytest.raises(RlbenchPinError, match="another scene"):
            one.set_arrays(other.arrays())


def held_in_the_air(world: World) -> None:
    """A state with much in it: an attached cube, an extra body, colours, moved frames."""
    close_on_cube(world)
    world.gripper.grasp("cube")
    move(world, ABOVE)
    world.add_body("drop", cube("any", 0.0, 0.2, 0.79))
    world.body("cube").set_color((0.1, 0.9, 0.1))
    world.root.set_pose([0.2, 0.1, TABLE_HEIGHT, *UPRIGHT])
    world.robot.set_position_targets(AROUND)
    steps(world, 2)


CONTINUE = """
import sys, hashlib, numpy as np
sys.path.insert(0, {tests!r})
from tests.sim import support, test_state
from tests.sim.support import build
world = build((support.cube_scene if {scene!r} == 'cube_scene' else test_state.clutter)())
world.set_arrays(dict(np.load({file!r})))
digest = hashlib.sha256(test_state.go_on(world)).hexdigest()
print(digest, world.gripper.grasped, round(world.time, 6), world.body({body!r}).color)
"""


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["cube_scene", "clutter"])
def test_arrays_continue_in_another_process_to_the_last_bit(tmp_path, scene):
    """A world set from arrays in a fresh process goes on exactly as the one they come from."""
    body = "cube" if scene == "cube_scene" else "steak"
    with build({"cube_scene": cube_scene, "clutter": clutter}[scene]()) as world:
        held_in_the_air(world) if scene == "cube_scene" else steps(world, 6)
        np.savez(tmp_path / "state.npz", **world.arrays())
        digest_here = hashlib.sha256(go_on(world)).hexdigest()
        expected = f"{digest_here} {world.gripper.grasped} {round(world.time, 6)} {world.body(body).color}"
    code = CONTINUE.format(tests=str(Path(__file__).parents[2]), scene=scene, file=str(tmp_path / "state.npz"), body=body)
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == expected


def test_arrays_are_plain():
    """Only arrays of numbers, so that any file format can hold them, and nothing is written into the caller's arrays."""
    with build() as world:
        arrays = world.arrays()
        assert all(a.dtype in (np.float64, np.uint8) for a in arrays.values())
        for array in arrays.values():
            array.setflags(write=False)
        first = go_on(world)
        world.set_arrays(arrays)
        assert go_on(world) == first


@pytest.mark.parametrize("damage", ["missing", "physics", "other"])
def test_damaged_arrays_are_refused(damage):
    """Incomplete or damaged arrays raise one of our errors, and the world stays as it is."""
    with build() as world:
        steps(world, 3)
        arrays, before = world.arrays(), digest(world)
        if damage == "missing":
            del arrays["arm_control"]
        else:
            arrays["physics"] = arrays["physics"][:50] if damage == "physics" else np.frombuffer(zlib.compress(b"none"), np.uint8)
        with pytest.raises(RlbenchPinError, match="physics|arm_control"):
            world.set_arrays(arrays)
        assert digest(world) == before


@pytest.mark.slow
def test_the_same_calls_give_the_same_bytes_in_another_process():
    """A world built and driven twice, in two processes, is in the same state to the last bit."""
    code = """
import sys, hashlib
sys.path.insert(0, {tests!r})
from tests.sim import test_state as t
from tests.sim.support import build, close_on_cube
world = build(t.clutter()); clean = world.save()
print(hashlib.sha256(t.go_on(world)).hexdigest())
if {wander}: t.wander(world)
world.restore(clean)
print(hashlib.sha256(t.go_on(world)).hexdigest())
"""
    outputs = set()
    for wander_first in (False, True):
        script = code.format(tests=str(Path(__file__).parents[2]), wander=wander_first)
        outputs.add(subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout)
    (output,) = outputs
    first, second = output.split()
    assert first == second


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
