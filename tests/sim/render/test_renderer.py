"""What the cameras of the benchmark see: exact geometry, stable ids, the same bytes everywhere, both renderers alike."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

from rlbench_pin.environment.observations.config import CameraConfig
from rlbench_pin.environment.observations.observe import camera_view, point_cloud
from rlbench_pin.errors import CameraError, UnknownName
from rlbench_pin.observation import CAMERAS
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import CameraView, EglMissing, Light, Lighting, World, look_at
from rlbench_pin.spatial import TABLE_HEIGHT, pose_at, pose_to_matrix
from tests.sim.support import ABOVE, PANDA, UPRIGHT, BodySpec, build, cube, cube_scene

CUBE = pose_at((0.35, 0.0, 0.95), 0.3, 0.4, 0.5)
SIDE = 0.05


@pytest.fixture(scope="module")
def world():
    """A world with one tilted cube in the air and the arm turned away."""
    with build(cube_scene(cube("cube", 0.35, 0.0, 0.95, fixed=True))) as world:
        world.body("cube").set_pose(CUBE)
        world.robot.reset_configuration(ABOVE + [0.9, 0, 0, 0, 0, 0, 0])
        yield world


def views(world: World, size: tuple[int, int]) -> dict[str, CameraView]:
    """The five cameras; the wrist camera is moved to where it sees the cube."""
    found = {name: camera_view(name, CameraConfig(image_size=size), world, PANDA) for name in CAMERAS}
    wrist = found["wrist"]
    moved = CameraView(pose=look_at((0.25, 0.2, 1.25), CUBE[:3]), fov=wrist.fov, size=size, near=wrist.near, far=wrist.far)
    return {**found, "wrist": moved}


@pytest.mark.parametrize("size", [(256, 256), (320, 240)])
@pytest.mark.parametrize("name", CAMERAS)
def test_a_cube_is_where_its_point_cloud_says(world, name, size):
    """Planes through the visible faces, from the point cloud, meet at the cube's centre within 2 mm."""
    view = views(world, size)[name]
    pictures = world.render(view)
    cloud = point_cloud(pictures.depth, view)[pictures.mask == 61]
    assert len(cloud) > 40
    local = (np.c_[cloud, np.ones(len(cloud))] @ np.linalg.inv(pose_to_matrix(CUBE)).T)[:, :3]
    face = np.argmax(np.abs(local), axis=1)
    center = np.zeros(3)
    for axis in np.unique(face):
        on_face = local[face == axis, axis]
        center[axis] = np.median(on_face) - np.sign(np.median(on_face)) * SIDE / 2.0
    assert np.linalg.norm(center) < 2e-3
    assert np.abs(np.abs(local[np.arange(len(local)), face]) - SIDE / 2.0).max() < 2e-3


@pytest.mark.parametrize("size", [(128, 128), (128, 96)])
@pytest.mark.parametrize("name", CAMERAS)
def test_matrices_reproduce_the_point_cloud(world, name, size):
    """World = extrinsics inverse(intrinsics) (u, v, 1) z, within 0.1 mm of the delivered cloud."""
    view = views(world, size)[name]
    depth = world.render(view).depth
    v, u = np.mgrid[0 : size[1], 0 : size[0]]
    rays = np.linalg.inv(view.intrinsics()) @ np.stack([u.ravel(), v.ravel(), np.ones(u.size)])
    expected = view.extrinsics()[:3] @ np.vstack([rays * depth.ravel(), np.ones(u.size)])
    assert np.abs(point_cloud(depth, view).reshape(-1, 3) - expected.T).max() < 1e-4


def test_the_tip_is_seen_where_it_projects():
    """A small ball at the tip is seen within one pixel of the projection of the tip."""
    ball = BodySpec(
        name="ball", asset="objects/ball_marker/ball_marker.urdf", parent="world", pose=(0, 0, 0, *UPRIGHT), scale=0.4
    )
    with build(SceneSpec(format=1, body=(ball,))) as world:
        world.robot.reset_configuration(ABOVE)
        tip = world.robot.tip_pose()
        world.body("ball").set_pose(tip)
        for name in ("left_shoulder", "overhead", "front", "wrist"):
            view = camera_view(name, CameraConfig(image_size=(256, 256)), world, PANDA)
            local = np.linalg.inv(view.extrinsics()) @ [*tip[:3], 1.0]
            u, v, _ = view.intrinsics() @ (local[:3] / local[2])
            rows, columns = np.nonzero(world.render(view).mask == 61)
            if name in ("front", "wrist"):
                assert len(rows) > 10
            if len(rows) > 10 and name != "left_shoulder":
                assert np.abs([columns.mean() - u, rows.mean() - v]).max() <= 1.0


def test_the_room_is_exact():
    """The table top that the backdrop draws lies at z = TABLE_HEIGHT within 10 um, and no camera sees emptiness."""
    with build(SceneSpec(format=1)) as world:
        table = next(i for i, name in world.masks.items() if name == "table")
        for view in views(world, (128, 96)).values():
            pictures = world.render(view)
            assert (pictures.mask > 0).all()
            seen = point_cloud(pictures.depth, view)[pictures.mask == table]
            top = np.abs(seen[:, 2] - TABLE_HEIGHT) < 1e-5
            assert top.mean() > 0.9


def test_moving_things_hide_the_room_and_the_room_hides_them():
    """A cube above the table is seen, and one below the table is not."""
    with build(cube_scene(cube("above", 0.3, 0.0, 0.80), cube("below", 0.3, 0.1, 0.65))) as world:
        pictures = world.render(camera_view("overhead", CameraConfig(), world, PANDA))
        assert 61 in pictures.mask and 62 not in pictures.mask


def test_ids_are_integers_of_the_table_and_stable():
    """Robot and room have ids up to 60, objects from 61, all of them in the table, also when images come from a new world."""
    tables, seen = [], []
    for _ in range(2):
        with build(cube_scene(cube("a", 0.3, 0.1), cube("b", 0.3, -0.1))) as world:
            tables.append(dict(world.masks))
            masks = [world.render(view).mask for view in views(world, (64, 64)).values()]
            seen.append(np.concatenate([mask.ravel() for mask in masks]))
    assert tables[0] == tables[1]
    np.testing.assert_array_equal(seen[0], seen[1])
    assert set(np.unique(seen[0])) <= set(tables[0])
    assert {tables[0][61], tables[0][62]} == {"a", "b"} and max(i for i in tables[0] if i < 61) <= 60


def picture_digest() -> str:
    """Bytes of all products of the five cameras, with and without shadows, and of the table of ids and names."""
    digest = hashlib.sha256()
    with build(cube_scene(cube("a", 0.3, 0.1), cube("b", 0.3, -0.1))) as world:
        digest.update(repr(sorted(world.masks.items())).encode())
        for name in CAMERAS:
            view = camera_view(name, CameraConfig(image_size=(64, 48)), world, PANDA)
            for shadows in (False, True):
                pictures = world.render(view, shadows=shadows)
                for product in (pictures.rgb, pictures.depth, pictures.mask):
                    digest.update(product.tobytes())
    return digest.hexdigest()


@pytest.mark.simulation
def test_pictures_have_the_same_bytes_in_another_process():
    """All products of all cameras, with and without shadows, and the names of the ids."""
    code = "from tests.sim.render.test_renderer import picture_digest; print(picture_digest())"
    paths = os.pathsep.join(path for path in sys.path if path)
    other = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": paths},
    )
    assert other.stdout.strip().splitlines()[-1] == picture_digest()


def test_shadows_fall_on_the_table_and_nowhere_without_things():
    """Under a floating cube the table is darker; where nothing stands in the light it is not."""
    with build(cube_scene(cube("cube", 0.3, 0.0, 1.0, fixed=True))) as world:
        view = camera_view("overhead", CameraConfig(image_size=(256, 256)), world, PANDA)
        lit, shaded = world.render(view), world.render(view, shadows=True)
        table = (lit.mask == shaded.mask) & (lit.mask == next(i for i, n in world.masks.items() if n == "table"))
        drop = lit.rgb[table].astype(int).sum(axis=1) - shaded.rgb[table].astype(int).sum(axis=1)
        assert 0.005 < (drop > 40).mean() < 0.3
        np.testing.assert_array_equal(shaded.rgb, world.render(view, shadows=world.renderer.shadow_map()).rgb)


def test_lights_are_a_setting():
    """Lights change colours and not geometry; the old ones bring the old image back."""
    with build() as world:
        view = camera_view("front", CameraConfig(image_size=(64, 64)), world, PANDA)
        before = world.render(view, shadows=True)
        world.renderer.lighting = Lighting(key=Light((-1.0, 0.5, 1.0), 0.3, (1.0, 0.5, 0.5)), ambient=0.4)
        other = world.render(view, shadows=True)
        assert (other.rgb != before.rgb).mean() > 0.5
        np.testing.assert_array_equal(other.depth, before.depth)
        world.renderer.lighting = Lighting()
        np.testing.assert_array_equal(world.render(view, shadows=True).rgb, before.rgb)
    with pytest.raises(CameraError):
        Light((0.0, 0.0, 0.0), 0.3)


def test_the_room_can_be_recoloured_and_moved():
    """Bodies of the room obey set_color and set_pose, and restore brings them back."""
    with build(SceneSpec(format=1)) as world:
        view = camera_view("front", CameraConfig(image_size=(64, 64)), world, PANDA)
        saved, before = world.save(), world.render(view)
        world.body("table").set_color((0.1, 0.2, 1.0))
        blue = world.render(view)
        assert blue.rgb[..., 0].mean() < before.rgb[..., 0].mean() - 50
        world.body("table").set_pose((0.0, 0.0, -0.3, *UPRIGHT))
        assert (world.render(view).depth != before.depth).any()
        world.restore(saved)
        again = world.render(view)
        np.testing.assert_array_equal(again.rgb, before.rgb)
        np.testing.assert_array_equal(again.depth, before.depth)


@pytest.mark.simulation
def test_both_renderers_agree():
    """EGL and TinyRenderer: depth within 2 mm where masks agree, masks within 1 % of the pixels; neither is black."""
    scene = cube_scene(cube("a", 0.3, 0.1), cube("b", 0.3, -0.1))
    try:
        hardware = World(scene, PANDA, renderer="egl")
    except EglMissing as error:
        pytest.skip(str(error))
    with hardware, build(scene) as software:
        for name in CAMERAS:
            view = camera_view(name, CameraConfig(), software, PANDA)
            ours, theirs = software.render(view, shadows=True), hardware.render(view, shadows=True)
            same = ours.mask == theirs.mask
            assert same.mean() > 0.99 and theirs.rgb.mean() > 20
            close = np.abs(ours.depth - theirs.depth)[same] < 2e-3
            assert close.mean() > 0.999


def test_renderers_are_chosen_by_name(monkeypatch):
    """An unknown renderer is refused; without EGL it is an error that says what to do, unless falling back was allowed."""
    with pytest.raises(UnknownName, match="'egl'"):
        World(SceneSpec(format=1), PANDA, renderer="elg")
    monkeypatch.setattr("rlbench_pin.sim.client.importlib.util.find_spec", lambda name: None)
    with pytest.raises(CameraError, match="doctor"):
        World(SceneSpec(format=1), PANDA, renderer="egl")
    with World(SceneSpec(format=1), PANDA, renderer="auto") as world:
        assert not world.client.hardware


def test_links_of_the_robot_can_be_hidden(world):
    """Hidden links are neither seen nor cast a shadow; afterwards every byte is as before."""
    view = views(world, (128, 128))["front"]
    before = world.render(view, shadows=True)
    world.robot.show(["panda_hand"])
    hand = world.render(view, shadows=True)
    world.robot.show([])
    nothing = world.render(view, shadows=True)
    world.robot.show()
    after = world.render(view, shadows=True)
    names = {number: name for number, name in world.masks.items() if name.startswith("panda/")}
    assert {names[number] for number in np.unique(hand.mask) if number in names} == {"panda/panda_hand"}
    assert not np.isin(nothing.mask, list(names)).any()
    is_table = nothing.mask == before.mask
    assert (nothing.rgb[is_table].astype(int).sum(axis=1) >= before.rgb[is_table].astype(int).sum(axis=1) - 6).all()
    assert np.array_equal(before.rgb, after.rgb) and np.array_equal(before.mask, after.mask)
