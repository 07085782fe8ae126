"""A world built again keeps no history: not in its bodies, nor in the order in which PyBullet solves contacts."""

from __future__ import annotations

import gc
import shutil

import numpy as np
import pytest

from rlbench_pin.assets import asset_path
from rlbench_pin.environment.randomization.config import VisualRandomizationConfig
from rlbench_pin.errors import EnvironmentClosed, RlbenchPinError
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.sim import World, read_texture
from rlbench_pin.sim.client import bullet
from rlbench_pin.tasks import task_class, task_scene
from tests.sim.support import PANDA, UPRIGHT, build, close_on_cube, cube, cube_scene, digest, furniture_scene, steps
from tests.sim.test_state import clutter, go_on, wander

PASTS = (1, 4)


def pieces() -> SceneSpec:
    """A board with many loose pieces, which `restore` alone does not repeat after the second of `PASTS`."""
    return task_scene(task_class("setup_checkers"))


def tumble(world: World, rng: np.random.Generator, ticks: int = 40) -> bytes:
    """Throw everything loose about."""
    for body in world.bodies.values():
        if not body.fixed:
            body.set_velocity([*rng.uniform(-0.5, 0.5, 2), 1.0, *rng.uniform(-3.0, 3.0, 3)])
    steps(world, ticks)
    return digest(world)


@pytest.mark.simulation
@pytest.mark.parametrize("scene", [pieces, clutter], ids=["pieces", "clutter"])
def test_what_follows_does_not_depend_on_the_past(scene):
    """The same throw ends in the same bits in a new world and after other throws."""
    with build(scene()) as world:
        ends = [tumble(world, np.random.default_rng(0))]
        for past in PASTS:
            tumble(world, np.random.default_rng(past), ticks=10 * past)
            world.build_again()
            ends.append(tumble(world, np.random.default_rng(0)))
        assert ends[1] == ends[0] and ends[2] == ends[0]


@pytest.mark.simulation
@pytest.mark.parametrize("scene", [cube_scene, furniture_scene, clutter], ids=["cube", "furniture", "clutter"])
def test_a_world_built_again_behaves_like_a_new_one(scene):
    """Motors, locks, friction, springs, filters and colours are those of the first building."""
    with build(scene()) as world:
        expected = go_on(world)
        wander(world)
        for name in [f"{body.name}/{joint}" for body in world.bodies.values() for joint in body.joints]:
            world.joint(name).lock()
        world.build_again()
        assert go_on(world) == expected


def test_everything_is_where_it_was_built():
    """Bodies, joints, colours and the clock are those of the scene file, and bodies made at run time are gone."""
    with build(furniture_scene()) as world:
        before, names = world.snapshot(), list(world.bodies)
        wander(world)
        world.add_body("late", cube("late", 0.4, 0.2, 0.9))
        world.joint("chest/drawer_top").set_state(0.02, 0.0)
        world.build_again()
        assert list(world.bodies) == names and world.ticks == 0
        after = world.snapshot()
        assert [body.name for body in after.bodies] == [body.name for body in before.bodies]
        np.testing.assert_array_equal(digest_of(after), digest_of(before))
        assert world.body("chest").colors == {}


def digest_of(snapshot) -> np.ndarray:
    """Poses of all links, in order."""
    return np.concatenate([np.ravel(body.link_poses) for body in snapshot.bodies])


@pytest.mark.simulation
def test_saved_states_stay_good():
    """A state from before is restored exactly, twice, and one that nobody holds any more costs nothing."""
    with build(cube_scene()) as world:
        steps(world, 3)
        world.add_body("late", cube("late", 0.4, 0.2, 0.9))
        world.body("cube").set_color((0.1, 0.2, 0.3))
        steps(world, 3)
        saved = world.save()
        lost = world.save()
        expected = go_on(world)
        del lost
        gc.collect()
        for _ in range(2):
            world.build_again()
            assert "late" not in world.bodies
            world.restore(saved)
            assert world.body("cube").color[:3] == (0.1, 0.2, 0.3) and "late" in world.bodies
            assert go_on(world) == expected
        assert set(world.saved_states) == {saved, world.origin}


def test_textures_and_changed_physics_are_kept():
    """Domain randomization outlasts the physics server it was made in, and can still be taken back."""
    (path,) = VisualRandomizationConfig().sample(1, np.random.default_rng(0))
    with build(cube_scene()) as world:
        model = world.body("cube").model
        mass = bullet.getDynamicsInfo(model.uid, -1, physicsClientId=world.client.id)[0]
        world.dynamics_overrides.scale(model, mass=2.0)
        world.texture_overrides.set_body("cube", read_texture(path), 4.0)
        world.build_again()
        assert bullet.getDynamicsInfo(model.uid, -1, physicsClientId=world.client.id)[0] == pytest.approx(2.0 * mass)
        assert bullet.getVisualShapeData(model.uid, physicsClientId=world.client.id)[0][7] == (1.0, 1.0, 1.0, 1.0)
        world.dynamics_overrides.clear()
        assert bullet.getDynamicsInfo(model.uid, -1, physicsClientId=world.client.id)[0] == pytest.approx(mass)


def test_a_file_that_changed_is_read_anew_by_the_next_world(tmp_path):
    """Models are read once a world, not once a process."""
    urdf = """<robot name="box"><link name="box"><inertial><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
    </inertial><collision><geometry><mesh filename="box.obj"/></geometry></collision></link></robot>"""
    (tmp_path / "box.urdf").write_text(urdf)
    spec = BodySpec(name="box", asset="./box.urdf", pose=(0.0, 0.0, 0.2, *UPRIGHT))
    scene = SceneSpec(format=1, file=str(tmp_path / "scene.toml"), body=(spec,))
    heights = []
    for size in (0.1, 0.2):
        corners = [(x, y, z) for x in (0, size) for y in (0, size) for z in (0, size)]
        faces = "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n"
        (tmp_path / "box.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + faces)
        with build(scene) as world:
            world.build_again()
            low, high = bullet.getAABB(world.body("box").model.uid, physicsClientId=world.client.id)
            heights.append(high[2] - low[2])
    assert heights[1] - heights[0] == pytest.approx(0.1, abs=0.01)


def test_a_call_that_returns_something_else_is_named():
    """When building again gives something else than before, the error says which call, and the world is closed."""
    counts = iter((99, 9))

    def count_bodies(physicsClientId: int) -> int:
        return next(counts)

    with build(cube_scene()) as world:
        world.client.change(count_bodies)
        steps(world, 1)
        with pytest.raises(RlbenchPinError, match="count_bodies.* gave 9 instead of 99"):
            world.build_again()
        with pytest.raises(EnvironmentClosed):
            world.step()


def test_model_files_are_read_once(tmp_path):
    """A world can be built again when its model files are gone."""
    shutil.copytree(asset_path("objects/cube/cube.urdf").parent, tmp_path / "cube")
    spec = BodySpec(name="cube", asset="./cube/cube.urdf", pose=(0.3, 0.0, 0.1, *UPRIGHT))
    with build(SceneSpec(format=1, file=str(tmp_path / "scene.toml"), body=(spec,))) as world:
        expected = go_on(world)
        shutil.rmtree(tmp_path / "cube")
        world.build_again()
        assert go_on(world) == expected


def test_what_pybullet_prints_of_a_model_is_not_printed_at_every_building(tmp_path, capfd):
    """PyBullet complains of a link without inertia on the standard output, where programs read JSON."""
    (tmp_path / "box.urdf").write_text(
        '<robot name="box"><link name="box"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link></robot>'
    )
    spec = BodySpec(name="box", asset="./box.urdf", pose=(0.0, 0.0, 0.2, *UPRIGHT), fixed=True)
    with build(SceneSpec(format=1, file=str(tmp_path / "scene.toml"), body=(spec,))) as world:
        capfd.readouterr()
        world.build_again()
        assert capfd.readouterr() == ("", "")


def test_arrays_of_a_new_world_do_not_disturb_its_building():
    """Asking a world for its arrays, or giving it some, before anything else leaves it able to be built again."""
    with build(cube_scene()) as world:
        before = digest(world)
        world.set_arrays(world.arrays())
        world.build_again()
        assert digest(world) == before


@pytest.mark.simulation
def test_a_state_after_a_grasp_stays_good():
    """Filters and contacts that a grasp changed come back with the state."""
    with build() as world:
        close_on_cube(world)
        world.gripper.grasp("cube")
        steps(world, 3)
        world.gripper.release()
        steps(world, 3)
        saved = world.save()
        expected = go_on(world)
        world.restore(saved)
        assert go_on(world) == expected
        world.build_again()
        world.restore(saved)
        assert go_on(world) == expected


def test_bodies_keep_their_places_when_an_earlier_one_was_removed():
    """A state of the bodies that are left is restored to the same names."""
    with build(cube_scene()) as world:
        steps(world, 1)
        for number, name in enumerate("abc"):
            world.add_body(name, cube(name, 0.2 + 0.1 * number, 0.3))
        steps(world, 2)
        world.remove_body("a")
        saved = world.save()
        places = {name: world.body(name).position.tolist() for name in "bc"}
        world.build_again()
        world.restore(saved)
        assert {name: world.body(name).position.tolist() for name in "bc"} == places


@pytest.mark.simulation
@pytest.mark.parametrize("scene", [pieces, furniture_scene], ids=["pieces", "furniture"])
def test_a_world_in_the_server_of_another_one_behaves_like_a_new_one(scene):
    """Its earlier contents have no effect; the replaced world is closed, and its states cannot be restored."""
    with build(scene()) as new:
        expected = go_on(new)
    before = build(clutter())
    tumble(before, np.random.default_rng(0))
    saved = before.save()
    with World(scene(), PANDA, replaced=before) as world:
        assert before.closed and go_on(world) == expected
        with pytest.raises(EnvironmentClosed):
            before.step()
        with pytest.raises(RlbenchPinError, match="saved by another world"):
            world.restore(saved)
        world.build_again()
        assert go_on(world) == expected
