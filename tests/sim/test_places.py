"""Frames have parents, and bodies move with theirs."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import RlbenchPinError, UnknownName
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.sim import Posed
from rlbench_pin.spatial import TABLE_HEIGHT, compose, pose_at, relative
from tests.sim.support import UPRIGHT, build, cube_scene, furniture_scene, steps

NEW_ROOT = pose_at((0.2, 0.1, TABLE_HEIGHT), 0.0, 0.0, 0.7)


@pytest.fixture
def world():
    """A world with furniture."""
    with build(furniture_scene()) as world:
        yield world


def test_place_root_takes_everything_along(world):
    """Bodies and frames keep their pose relative to the root; joints stay, velocities vanish, the rest of the world stays."""
    world.body("cube").set_velocity([0.1, 0, 0, 0, 0, 1.0])
    names = ("button", "chest", "cube")
    before = {n: relative(world.body(n).pose, world.root.pose) for n in names}
    knob, corner = relative(world.frame("knob").pose, world.root.pose), world.frame("corner").pose
    world.place_root(NEW_ROOT)
    np.testing.assert_allclose(world.root.pose, NEW_ROOT, atol=1e-12)
    for name in names:
        np.testing.assert_allclose(relative(world.body(name).pose, NEW_ROOT), before[name], atol=1e-9)
    np.testing.assert_allclose(relative(world.frame("knob").pose, NEW_ROOT), knob, atol=1e-6)
    np.testing.assert_allclose(world.frame("corner").pose, corner)
    np.testing.assert_allclose(world.body("cube").velocity, 0.0)
    assert world.joint("chest/drawer_top").position == pytest.approx(0.1)
    steps(world, 5)
    assert world.max_penetration() < 1e-3
    assert relative(world.body("cube").pose, NEW_ROOT)[:3] == pytest.approx(before["cube"][:3], abs=1e-3)


def test_a_frame_on_a_link_follows_the_joint(world):
    """The knob moves along -x when its drawer opens."""
    before = world.frame("knob").position
    world.joint("chest/drawer_top").set_position(0.2)
    np.testing.assert_allclose(world.frame("knob").position - before, [-0.1, 0.0, 0.0], atol=1e-6)


def test_a_moved_frame_takes_its_bodies_along(world):
    """The spot is the parent of the cube; sensors whose parent it is follow as well."""
    before = relative(world.body("cube").pose, world.frame("spot").pose)
    world.frame("spot").set_pose(pose_at((0.1, -0.1, TABLE_HEIGHT), 0.0, 0.0, 0.3))
    np.testing.assert_allclose(relative(world.body("cube").pose, world.frame("spot").pose), before, atol=1e-9)
    np.testing.assert_allclose(world.sensor("detector").position, [0.1, -0.1, TABLE_HEIGHT + 0.01], atol=1e-9)


def test_a_moved_body_takes_what_hangs_on_it():
    """A lid whose parent is a pan moves with the pan."""
    pan = BodySpec(name="pan", asset="objects/saucepan/saucepan.urdf")
    lid = BodySpec(name="lid", asset="objects/saucepan_lid/saucepan_lid.urdf", parent="pan", pose=(0.0, 0.0, 0.15, *UPRIGHT))
    with build(SceneSpec(format=1, body=(lid, pan))) as world:
        before = relative(world.body("lid").pose, world.body("pan").pose)
        world.body("pan").set_pose(pose_at((0.3, 0.2, TABLE_HEIGHT), 0.0, 0.0, 1.0))
        np.testing.assert_allclose(relative(world.body("lid").pose, world.body("pan").pose), before, atol=1e-9)


def test_frames_move_and_change_parents(world):
    """`move_to` takes bodies, frames, names and poses; a new parent keeps the place or the relative pose."""
    spot = world.frame("corner")
    spot.move_to("chest/drawer_top_link")
    np.testing.assert_allclose(spot.pose, world.body("chest").link_pose("drawer_top_link"), atol=1e-12)
    spot.move_to(world.frame("knob"))
    np.testing.assert_allclose(spot.pose, world.frame("knob").pose, atol=1e-12)
    spot.move_to(world.body("button"))
    np.testing.assert_allclose(spot.pose, world.body("button").pose, atol=1e-12)
    spot.move_to((0.1, 0.2, 0.9, *UPRIGHT))
    np.testing.assert_allclose(spot.pose, [0.1, 0.2, 0.9, *UPRIGHT], atol=1e-12)
    spot.set_position([0.1, 0.2, 0.9])
    np.testing.assert_allclose(spot.position, [0.1, 0.2, 0.9])
    pose, local = spot.pose, spot.local
    spot.set_parent("button", keep_in_place=True)
    np.testing.assert_allclose(spot.pose, pose, atol=1e-9)
    spot.set_parent("world")
    assert not np.allclose(spot.pose, pose)
    np.testing.assert_allclose(compose(world.body("button").pose, spot.pose), pose, atol=1e-9)
    assert local.shape == (7,)


def test_bodies_and_frames_are_posed_alike(world):
    """What handles a `Posed` moves a body and a frame with the same calls."""

    def lift(thing: Posed) -> None:
        thing.set_pose([*thing.position[:2], 1.2, *thing.quaternion])

    body, frame = world.body("cube"), world.frame("corner")
    lift(body)
    lift(frame)
    assert body.position[2] == pytest.approx(1.2) and frame.position[2] == pytest.approx(1.2)


def test_impossible_parents_are_refused(world):
    """Unknown parents and cycles raise."""
    with pytest.raises(UnknownName, match="button"):
        world.frame("spot").set_parent("buton")
    with pytest.raises(RlbenchPinError, match="descendant"):
        world.frame("spot").set_parent("detector")
    with pytest.raises(RlbenchPinError, match="descendant"):
        world.root.set_parent("chest/drawer_top_link")


@pytest.mark.parametrize("pose", [np.zeros(7), np.full(7, np.nan), np.zeros(3), [0, 0, 0, 0, 0, 0, 2.0]])
def test_bad_poses_are_refused(world, pose):
    """A pose has seven finite numbers and a unit quaternion."""
    for thing in (world.body("cube"), world.frame("spot")):
        with pytest.raises(ValueError):
            thing.set_pose(pose)


def test_a_body_is_posed_by_its_base_frame_whatever_its_inertia(tmp_path):
    """An inertial offset and tilted principal axes do not show in poses."""
    shape = '<origin xyz="0.01 0.02 0.03" rpy="0.1 0.2 0.3"/><geometry><box size="0.05 0.06 0.07"/></geometry>'
    inertia = '<mass value="0.1"/><inertia ixx="1e-4" ixy="1e-5" ixz="0" iyy="2e-4" iyz="0" izz="3e-4"/>'
    (tmp_path / "odd.urdf").write_text(
        f'<robot name="odd"><link name="b"><inertial><origin xyz="0.02 0.01 0.03" rpy="0.3 0.2 0.1"/>{inertia}</inertial>'
        f"<visual>{shape}</visual><collision>{shape}</collision></link></robot>"
    )
    pose = pose_at((0.3, 0.1, 1.0), 0.3, -0.2, 0.9)
    spec = BodySpec(name="odd", asset="./odd.urdf", parent="world", pose=tuple(pose))
    with build(SceneSpec(format=1, body=(spec,), file=str(tmp_path / "scene.toml"))) as world:
        np.testing.assert_allclose(world.body("odd").pose, pose, atol=1e-9)
        moved = compose(pose, pose_at((0.1, 0.0, 0.0), 1.0, 0.0, 0.0))
        world.body("odd").set_pose(moved)
        np.testing.assert_allclose(world.body("odd").pose, moved, atol=1e-9)
        world.step()
        assert world.body("odd").position[2] < moved[2]


def test_bounds_are_those_of_the_geometry(world):
    """The local box of a cube is its size; an open drawer lengthens the chest."""
    np.testing.assert_allclose(world.body("cube").aabb_size(), 0.05, atol=1e-6)
    np.testing.assert_allclose(world.body("cube").bounds(), [[-0.025] * 3, [0.025] * 3], atol=1e-6)
    before = world.body("chest").aabb_size()[0]
    world.joint("chest/drawer_top").set_position(0.2)
    assert world.body("chest").aabb_size()[0] - before == pytest.approx(0.1, abs=1e-6)


def test_scale():
    """A scaled body has scaled bounds and rests at the scaled height."""
    spec = BodySpec(
        name="big", asset="objects/cube/cube.urdf", parent="world", pose=(0.3, 0.2, TABLE_HEIGHT + 0.048, *UPRIGHT), scale=1.5
    )
    with build(cube_scene(spec)) as world:
        np.testing.assert_allclose(world.body("big").aabb_size(), 0.075, atol=1e-6)
        steps(world, 10)
        assert world.body("big").position[2] == pytest.approx(TABLE_HEIGHT + 0.0375, abs=1e-3)


def test_another_parent(world):
    """A body moves with its new parent only; its own descendants are refused."""
    world.places.set_parent("cube", "corner")
    before = world.body("cube").position
    world.frame("spot").set_position([0.2, 0.2, 0.9])
    assert np.array_equal(world.body("cube").position, before) and world.places.parent("cube") == "corner"
    corner = world.frame("corner")
    corner.set_position(corner.position + [0.0, 0.0, 0.1])
    assert np.allclose(world.body("cube").position - before, [0.0, 0.0, 0.1])
    world.places.set_parent("cube", "root")
    corner.set_parent("cube", keep_in_place=True)
    with pytest.raises(RlbenchPinError, match="descendant"):
        world.places.set_parent("cube", "corner")
