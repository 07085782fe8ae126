"""Frames, regions and sensors, and what moves with what."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import rlbench_pin.sim
from rlbench_pin.errors import EnvironmentClosed, RlbenchPinError, UnknownName
from rlbench_pin.robot import geometry
from rlbench_pin.scene.spec import BodySpec, SceneSpec, SensorSpec
from rlbench_pin.sim import Posed, World
from rlbench_pin.sim.client import bullet
from rlbench_pin.spatial import TABLE_HEIGHT, compose, pose_at, relative
from tests.sim.support import ABOVE, UPRIGHT, build, cube, cube_scene, furniture_scene, steps

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


def asked(world: World) -> list[tuple[float, ...]]:
    """Where PyBullet says that cube, drawer and tip are."""
    where = {"physicsClientId": world.client.id}
    chest, arm = world.body("chest").model, world.robot.model
    drawer, tip = chest.link_index("drawer_top_link"), arm.link_index(world.robot.description.tip_frame)
    links = [bullet.getLinkState(m.uid, i, computeForwardKinematics=1, **where)[4] for m, i in ((chest, drawer), (arm, tip))]
    return [bullet.getBasePositionAndOrientation(world.body("cube").model.uid, **where)[0], *links]


def told(world: World) -> list[tuple[float, ...]]:
    """Where the world says that they are."""
    poses = (world.body("cube").pose, world.body("chest").link_pose("drawer_top_link"), world.robot.tip_pose())
    return [tuple(pose[:3].tolist()) for pose in poses]


def pushed(world: World) -> None:
    """One tick with a moving arm, asked before every physics step; the cube falls."""
    world.robot.set_velocity_targets(np.full(7, 0.2))
    world.on_physics.append(lambda: np.testing.assert_array_equal(told(world), asked(world)))
    world.step()


def restored(world: World) -> None:
    """Back to an instant, after some time."""
    saved = world.save()
    steps(world, 3)
    told(world)
    world.restore(saved)


def from_arrays(exact: bool) -> Callable[[World], None]:
    """Back to an instant by arrays, after some time."""

    def change(world: World) -> None:
        arrays = world.arrays(exact)
        steps(world, 3)
        told(world)
        world.set_arrays(arrays)

    return change


def origin(world: World) -> None:
    """Back to the beginning, in a server built again."""
    steps(world, 3)
    told(world)
    world.build_again()


CHANGES: dict[str, Callable[[World], None]] = {
    "a tick": pushed,
    "a pose": lambda world: world.body("cube").set_pose([0.4, 0.1, 1.2, 0, 0, 0, 1]),
    "the root": lambda world: world.place_root(world.root.pose + [0.05, 0, 0, 0, 0, 0, 0]),
    "a joint": lambda world: world.joint("chest/drawer_top").set_position(0.03),
    "the arm": lambda world: world.robot.reset_configuration(ABOVE),
    "joint states": lambda world: world.robot.set_joint_states(np.append(ABOVE, [0.02, 0.02]), np.zeros(9)),
    "another body": lambda world: world.add_body("late", cube("late", 0.5, 0.3)) and None,
    "a state": restored,
    "arrays": from_arrays(exact=True),
    "arrays without contacts": from_arrays(exact=False),
    "the origin": origin,
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_placements_are_those_of_the_present_instant(change):
    """Whatever moves things, the world tells where they are now; after a change each is asked for once."""
    with build(furniture_scene()) as world:
        world.body("cube").set_pose([0.3, 0.0, 1.0, 0, 0, 0, 1])
        np.testing.assert_array_equal(told(world), asked(world))
        change(world)
        np.testing.assert_array_equal(told(world), asked(world))


def test_a_placement_is_the_callers_own():
    """Whoever changes what was returned changes nothing else."""
    with build() as world:
        model = world.body("cube").model
        first = model.placement()
        first.translation = np.zeros(3)
        assert model.placement() != first


def test_a_closed_world_says_so():
    """What was read before is not told any more."""
    world = build()
    assert world.body("cube").pose.shape == (7,)
    world.close()
    with pytest.raises(EnvironmentClosed):
        _ = world.body("cube").pose


def test_only_the_client_lets_things_move_unrecorded():
    """No other module steps or restores a server, which would leave old placements behind."""
    folder = Path(rlbench_pin.sim.__file__).parent
    movers = re.compile(r"bullet\.(stepSimulation|restoreState|resetSimulation)\(")
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*.py") if movers.search(path.read_text())}
    assert found == {"client.py"}


PLACE = np.array([0.3, 0.0, 1.0])


@pytest.fixture(scope="module")
def world_sensor():
    """A world_sensor with one sensor of each shape, a cube and a ball without collision geometry."""

    def sensor(name, shape, size):
        return SensorSpec(name=name, shape=shape, size=size, parent="world", pose=(*PLACE, *UPRIGHT))

    ball = BodySpec(name="ball", asset="objects/ball_marker/ball_marker.urdf", parent="world", fixed=True)
    scene = SceneSpec(
        format=1,
        body=(BodySpec(name="cube", asset="objects/cube/cube.urdf", parent="world", fixed=True), ball),
        sensor=(
            sensor("box", "box", (0.1, 0.2, 0.3)),
            sensor("cylinder", "cylinder", (0.2, 0.1)),
            sensor("sphere", "sphere", (0.2,)),
            SensorSpec(name="on_cube", shape="box", size=(0.01, 0.01, 0.01), parent="cube", pose=(0.0, 0.0, 0.05, *UPRIGHT)),
        ),
    )
    with build(scene) as world_sensor:
        yield world_sensor


@pytest.mark.parametrize("body", ["cube", "ball"])
@pytest.mark.parametrize(
    ("sensor", "direction", "reach"),
    [
        ("box", (1, 0, 0), 0.05),
        ("box", (0, 1, 0), 0.10),
        ("box", (0, 0, 1), 0.15),
        ("cylinder", (1, 0, 0), 0.10),
        ("cylinder", (0, 0, 1), 0.05),
        ("sphere", (0, 0, 1), 0.10),
    ],
)
def test_a_body_is_seen_when_it_reaches_in(world_sensor, body, sensor, direction, reach):
    """Cube (solid) and ball (only seen) are detected up to the volume's surface plus their own half size."""
    for distance, seen in ((reach + 0.024, True), (reach + 0.026, False)):
        world_sensor.body(body).set_pose([*(PLACE + distance * np.array(direction)), *UPRIGHT])
        assert world_sensor.sensor(sensor).detects(body) is seen


@pytest.mark.parametrize(
    ("sensor", "inside", "outside"),
    [("box", (0.049, 0.099, 0.149), (0.051, 0, 0)), ("sphere", (0.05, 0.05, 0.05), (0.06, 0.06, 0.06))],
)
def test_points(world_sensor, sensor, inside, outside):
    """A point is inside or outside."""
    assert world_sensor.sensor(sensor).contains(PLACE + inside)
    assert not world_sensor.sensor(sensor).contains(PLACE + outside)


def test_a_sensor_moves_with_its_parent(world_sensor):
    """A sensor on the cube sees the ball only where the cube takes it."""
    world_sensor.body("cube").set_pose([0.1, 0.1, 1.0, *UPRIGHT])
    world_sensor.body("ball").set_pose([0.1, 0.1, 1.05, *UPRIGHT])
    assert world_sensor.sensor("on_cube").detects("ball")
    world_sensor.body("cube").set_pose([0.2, 0.1, 1.0, *UPRIGHT])
    assert not world_sensor.sensor("on_cube").detects("ball")


def test_a_body_far_away_is_not_compared_and_one_nearby_is(world_sensor):
    """Wherever a turned cube lies, a sensor says what Coal says of the shapes themselves."""
    cube, sensor, rng = world_sensor.body("cube"), world_sensor.sensor("cylinder"), np.random.default_rng(0)
    ((box, _),) = geometry.solid_geometry(cube.model.urdf)["cube"]
    volume, answers = geometry.volume("cylinder", sensor.size), []
    for _ in range(300):
        quaternion = rng.normal(size=4)
        cube.set_pose([*(PLACE + rng.uniform(-0.16, 0.16, 3)), *(quaternion / np.linalg.norm(quaternion))])
        touches = geometry.overlaps(volume, sensor.placement(), [(box, pin.SE3.Identity())], cube.model.placement())
        answers.append(touches)
        assert sensor.detects("cube") == touches
    assert 50 < sum(answers) < 250
