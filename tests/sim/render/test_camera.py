"""Images agree with the stored matrices to a small part of a pixel."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import CameraError
from rlbench_pin.sim import CameraView
from rlbench_pin.spatial import matrix_to_pose, pose_at, pose_to_matrix
from tests.sim.support import ABOVE, build, cube, cube_scene, furniture_scene

CUBE = pose_at((0.3, 0.1, 1.0), 0.3, 0.4, 0.5)


def looking(eye, target, fov=20.0, size=(128, 128), far=4.5) -> CameraView:
    """A camera at `eye` that looks at `target`: z forward, x left, y up."""
    z = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    x = np.cross([0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3] = np.column_stack([x, np.cross(z, x), z, eye])
    return CameraView(pose=matrix_to_pose(matrix), fov=np.radians(fov), size=size, near=0.01, far=far)


@pytest.fixture(scope="module")
def world():
    """A world with one cube in the air."""
    scene = cube_scene(cube("cube", 0.3, 0.1, 1.0, fixed=True))
    with build(scene) as world:
        world.body("cube").set_pose(CUBE)
        yield world


@pytest.mark.parametrize("size", [(128, 128), (128, 96), (64, 128), (65, 33)])
def test_back_projection_lands_on_the_cube(world, size):
    """The formula extrinsics inverse(intrinsics) (u, v, 1) z puts every pixel of a side of the cube on it, within 20 um."""
    view = looking((0.9, 0.6, 1.3), (0.3, 0.12, 1.0), size=size)
    pictures = world.render(view)
    rows, columns = np.nonzero(pictures.mask == 61)
    assert len(rows) > 50
    pixels = np.stack([columns, rows, np.ones_like(rows)]).astype(float)
    points = np.linalg.inv(view.intrinsics()) @ pixels * pictures.depth[rows, columns]
    world_points = view.extrinsics() @ np.vstack([points, np.ones(len(rows))])
    local = (np.linalg.inv(pose_to_matrix(CUBE)) @ world_points)[:3]
    outwards = np.abs(local)
    on_side = (outwards < 0.0229).sum(axis=0) == 2  # the others are on the bevelled edges, 2 mm wide
    assert on_side.sum() > 0.7 * len(rows)
    assert np.abs(outwards[:, on_side].max(axis=0) - 0.025).max() < 2e-5
    assert np.abs(outwards.max(axis=0) - 0.025).max() < 2e-3


def test_intrinsics_are_signed_and_belong_to_the_longer_side():
    """Focal lengths are negative; the field of view is that of the longer side; the principal point is half the resolution."""
    k = looking((1, 0, 1), (0, 0, 1), fov=40.0).intrinsics()
    assert k[0, 0] == k[1, 1] == pytest.approx(-175.84, abs=0.01)
    assert (k[0, 2], k[1, 2]) == (64.0, 64.0)
    wide = looking((1, 0, 1), (0, 0, 1), fov=40.0, size=(128, 96)).intrinsics()
    assert wide[1, 1] == pytest.approx(-175.84, abs=0.01) and wide[1, 2] == 48.0


def test_pictures_have_the_documented_form(world):
    """Types, shapes and order are as documented; what is not asked for is None; the top row is up."""
    view = looking((1.35, 0.0, 1.58), (0.15, 0.0, 0.9), fov=40.0, size=(96, 64))
    pictures = world.render(view)
    assert pictures.rgb.shape == (64, 96, 3) and pictures.rgb.dtype == np.uint8
    assert pictures.depth.shape == (64, 96) and pictures.depth.dtype == np.float32
    assert pictures.mask.shape == (64, 96) and pictures.mask.dtype == np.int32
    assert set(np.unique(pictures.mask)) <= {0, *world.masks}
    names = {world.masks[i] for i in np.unique(pictures.mask) if i}
    assert {"table", "wall_back", "cube"} <= names
    assert world.masks[pictures.mask[0, 48]] != "table" and world.masks[pictures.mask[-1, 48]] == "table"
    only = world.render(view, rgb=False, depth=True, mask=False)
    assert only.rgb is None and only.mask is None
    np.testing.assert_array_equal(only.depth, pictures.depth)


def test_nothing_is_seen_beyond_the_far_plane(world):
    """Where nothing is seen, depth is the far distance and the mask is 0."""
    view = looking((1.35, 0.0, 1.58), (1.55, 0.0, 3.9), size=(32, 32), far=1.0)
    pictures = world.render(view)
    assert (pictures.mask == 0).all()
    np.testing.assert_allclose(pictures.depth, 1.0)


def test_recoloured_bodies_look_recoloured(world):
    """A colour that is set shows, and restoring shows the old one again, byte for byte."""
    view = looking((0.9, 0.6, 1.3), (0.3, 0.12, 1.0), size=(64, 64))
    saved, before = world.save(), world.render(view)
    world.body("cube").set_color((0.0, 0.0, 1.0))
    after = world.render(view)
    inside = before.mask == 61
    assert after.rgb[inside][:, 2].mean() > after.rgb[inside][:, 0].mean() + 50
    world.restore(saved)
    np.testing.assert_array_equal(world.render(view).rgb, before.rgb)


def test_pictures_show_what_was_just_set():
    """Joints and arms that were set, and not simulated since, are seen where they are."""
    with build(furniture_scene()) as world:
        view = looking((-0.2, 0.2, 1.4), (0.4, 0.2, 0.9), fov=50.0, size=(64, 64))
        pictures = [world.render(view).mask]
        world.joint("chest/drawer_top").set_position(0.2)
        pictures.append(world.render(view).mask)
        world.robot.reset_configuration(ABOVE + [0.8, 0, 0, 0, 0, 0, 0])
        pictures.append(world.render(view).mask)
        world.step()
        later = world.render(view).mask
    assert (pictures[0] != pictures[1]).sum() > 20
    assert (pictures[1] != pictures[2]).sum() > 20
    assert (pictures[2] != later).sum() < 5


def test_shadows_only_darken(world):
    """Shadows change colours, not geometry."""
    view = looking((1.35, 0.0, 1.58), (0.15, 0.0, 0.9), fov=40.0)
    plain, shaded = world.render(view), world.render(view, shadows=True)
    np.testing.assert_array_equal(plain.depth, shaded.depth)
    assert (plain.rgb != shaded.rgb).any()


@pytest.mark.parametrize("change", [{"fov": 0.0}, {"near": 0.0}, {"far": 0.005}, {"size": (0, 5)}])
def test_impossible_cameras_are_refused(change):
    """A camera that cannot exist raises CameraError."""
    values = {"pose": CUBE, "fov": 1.0, "size": (8, 8), "near": 0.01, "far": 1.0}
    with pytest.raises(CameraError):
        CameraView(**{**values, **change})
