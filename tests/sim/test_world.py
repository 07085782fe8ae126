"""A physics world: building, stepping, queries and snapshots."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from rlbench_pin.errors import AssetNotFound, EnvironmentClosed, RlbenchPinError, UnknownName
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.sim import World
from rlbench_pin.spatial import above_table
from tests.sim.support import HOME, PANDA, build, close_on_cube, cube, cube_scene, digest, furniture_scene, steps


@pytest.fixture(scope="module")
def furniture():
    """A world with furniture."""
    with build(furniture_scene()) as world:
        yield world


def test_starts_at_home_with_an_open_hand(furniture):
    """A new world has the arm at home, at rest, and the fingers open."""
    np.testing.assert_allclose(furniture.robot.joint_positions, HOME)
    assert furniture.gripper.is_open
    assert furniture.time == 0.0


@pytest.mark.parametrize(
    ("find", "wrong", "right"),
    [
        (lambda w, n: w.body(n), "chst", "chest"),
        (lambda w, n: w.joint(n), "chest/drawer_tap", "chest/drawer_top"),
        (lambda w, n: w.frame(n), "knub", "knob"),
        (lambda w, n: w.sensor(n), "detektor", "detector"),
        (lambda w, n: w.region(n), "path", "patch"),
        (lambda w, n: w.body("button").link_pose(n), "cup", "cap"),
    ],
)
def test_a_misspelt_name_is_answered_with_the_nearest(furniture, find, wrong, right):
    """Every lookup proposes the name that was probably meant, and finds it."""
    with pytest.raises(UnknownName, match=f"Did you mean '{right}'"):
        find(furniture, wrong)
    assert find(furniture, right) is not None


def test_a_region_is_no_sensor(furniture):
    """Looking for a frame of the wrong kind names those of the right one."""
    with pytest.raises(UnknownName, match="detector"):
        furniture.sensor("patch")


def test_mask_ids_are_stable(furniture):
    """Robot and room stay below 61; objects count on from there in file order, link by link."""
    names = furniture.masks
    assert names[1] == "panda/panda_link0"
    assert max(i for i, n in names.items() if n.startswith(("panda", "table", "floor", "wall"))) < 61
    assert [names[i] for i in range(61, 65)] == ["button/base", "button/cap", "chest/chest", "chest/drawer_bottom_link"]
    assert names[max(names)] == "cube"


def test_time_counts_ticks():
    """Each step is one control tick of twelve physics steps."""
    with build() as world:
        calls = []
        world.on_physics.append(lambda: calls.append(world.time))
        steps(world, 3)
        assert calls[::12] == pytest.approx([0.0, 0.05, 0.10])
        assert (len(calls), world.time) == (36, pytest.approx(0.15))


def test_a_tick_is_a_whole_number_of_physics_steps():
    """A ratio that is not whole is refused."""
    with pytest.raises(ValueError, match="whole number"):
        World(cube_scene(), PANDA, timestep=0.004, control_dt=0.05)
    with World(cube_scene(), PANDA, timestep=0.005, control_dt=0.05) as world:
        world.step()


def test_a_closed_world_says_so():
    """After `close` every use raises EnvironmentClosed; closing twice is harmless."""
    world = build()
    saved, body, view = world.save(), world.body("cube"), world.robot
    world.close()
    world.close()
    for use in (
        world.step,
        lambda: world.restore(saved),
        world.save,
        world.arrays,
        lambda: body.pose,
        view.tip_pose,
        world.snapshot,
    ):
        with pytest.raises(EnvironmentClosed):
            use()


def test_two_worlds_do_not_disturb_each_other():
    """What one world does is the same with another one running beside it."""

    def run(other: World | None) -> bytes:
        with build() as world:
            for k in range(20):
                world.robot.set_position_targets(HOME + 0.01 * k)
                world.step()
                if other:
                    other.robot.set_velocity_targets(np.full(7, 0.3))
                    other.step()
            return digest(world)

    alone = run(None)
    with build(furniture_scene()) as other:
        assert run(other) == alone


def test_a_missing_asset_is_named():
    """A URDF that is not there raises AssetNotFound with the body that needs it."""
    scene = SceneSpec(format=1, body=(BodySpec(name="thing", asset="objects/none/none.urdf"),))
    with pytest.raises(AssetNotFound, match="thing"):
        build(scene)


MESH = "<link name='a'><visual><geometry><mesh filename='gone.obj'/></geometry></visual></link>"
JOINT = "<joint name='j{0}{1}' type='fixed'><parent link='{0}'/><child link='{1}'/></joint>"


@pytest.mark.parametrize(
    "content",
    [
        "",
        "<robot>",
        "<robot name='r'/>",
        "<robot name='r'><link name='a'/><link name='b'/></robot>",
        "<robot name='r'><link name='a'/><link name='a'/></robot>",
        "<robot name='r'><link name='a'/>" + JOINT.format("a", "b") + "</robot>",
        "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>"
        + JOINT.format("b", "c")
        + JOINT.format("c", "b")
        + "</robot>",
        "<robot name='r'>" + MESH + "</robot>",
    ],
)
def test_a_broken_urdf_is_named(tmp_path, content):
    """A URDF that PyBullet cannot read raises one of our errors with the file's name."""
    file = tmp_path / "bad.urdf"
    file.write_text(content)
    scene = SceneSpec(format=1, body=(BodySpec(name="thing", asset="./bad.urdf"),), file=str(tmp_path / "x.toml"))
    with pytest.raises(RlbenchPinError, match=r"bad\.urdf"):
        build(scene)


def test_bodies_come_and_go():
    """A body added at run time takes part; it can be removed, and bodies of the scene cannot."""
    with build() as world:
        extra = world.add_body("extra", cube("any", 0.1, 0.3, above_table(0.148)))
        assert world.masks[62] == "extra"
        steps(world, 20)
        assert extra.position[2] == pytest.approx(above_table(0.025), abs=1e-3)
        with pytest.raises(RlbenchPinError, match="in use"):
            world.add_body("extra", cube("any", 0.1, 0.3))
        world.remove_body("extra")
        assert "extra" not in world.bodies
        assert 62 not in world.masks
        with pytest.raises(RlbenchPinError, match="scene file"):
            world.remove_body("cube")
        steps(world, 2)


def test_contacts_have_names():
    """Resting and touching things are reported with names, and nothing overlaps much."""
    with build() as world:
        steps(world, 5)
        (contact, *_) = world.contacts("cube", "table")
        assert {contact.body, contact.other} == {"cube", "table"}
        assert sum(c.force for c in world.contacts("cube", "table")) == pytest.approx(0.1 * 9.81, rel=0.05)
        assert world.max_penetration() < 1e-3
        assert world.robot.touching() == ()
        close_on_cube(world)
        assert world.robot.touching() == ("cube",)
        assert {c.link for c in world.contacts("panda", "cube")} == {"panda_leftfinger", "panda_rightfinger"}


def test_colours_of_links_and_bodies():
    """A colour is set on one link or on all, read back exactly, and refused when it is none."""
    with build(furniture_scene()) as world:
        button = world.body("button")
        assert button.color == (0.5, 0.0, 0.0, 1.0)
        button.set_color((0.0, 1.0, 0.0), "cap")
        assert button.color == (0.5, 0.0, 0.0, 1.0)
        button.set_color((0.1, 0.2, 0.3, 1.0))
        assert button.color == (0.1, 0.2, 0.3, 1.0)
        with pytest.raises(ValueError, match="colour"):
            button.set_color((2.0, 0.0, 0.0))


def test_a_body_may_pass_through_things():
    """Without collisions a free body falls through the table, with them it rests."""
    high = above_table(0.048)
    with build(cube_scene(cube("solid", 0.2, 0.2, high), cube("ghost", 0.2, -0.2, high, collides=False))) as world:
        steps(world, 10)
        assert world.body("solid").position[2] > above_table(0.018)
        assert world.body("ghost").position[2] < above_table(-0.052)


@pytest.mark.simulation
def test_the_library_is_silent():
    """Importing and running the simulation prints nothing on stdout or stderr."""
    code = (
        "from rlbench_pin.robot.description import robot_description as r; from rlbench_pin.scene.spec import SceneSpec as S;\n"
    )
    code += "from rlbench_pin.sim import World\nwith World(S(format=1), r('panda')) as w: w.step(); w.restore(w.save())"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout == "" and result.stderr == ""


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
