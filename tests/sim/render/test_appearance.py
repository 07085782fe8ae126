"""Smooth edges, soft shadows, dark feet, and a bright room; what is left out of a picture to save time changes nothing in it."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment.observations.config import CameraConfig
from rlbench_pin.environment.observations.observe import camera_view
from rlbench_pin.errors import InvalidValue
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.sim import CameraView, Request, look_at
from rlbench_pin.sim.render.backdrop import Canvas
from rlbench_pin.spatial import TABLE_HEIGHT
from tests.sim.support import PANDA, build, cube, cube_scene

SIDE = CameraView(pose=look_at((0.9, 0.5, 1.3), (0.3, 0.0, 0.8)), fov=0.6, size=(96, 72), near=0.05, far=6.0)


@pytest.fixture(scope="module")
def world():
    """A cube on the table, one in the air, and the arm."""
    with build(cube_scene(cube("low", 0.35, 0.0), cube("high", 0.3, 0.15, 1.0, fixed=True))) as world:
        yield world


def test_antialiasing_changes_colours_alone(world):
    """Depth and mask are the same bytes; colours are the means of the picture of twice the size, but for the dark feet."""
    plain, smooth = (world.renderer.render_all([Request(SIDE, antialiasing=wanted)])[0] for wanted in (False, True))
    assert smooth.rgb.shape == plain.rgb.shape and smooth.rgb.dtype == np.uint8
    assert smooth.depth.tobytes() == plain.depth.tobytes() and smooth.mask.tobytes() == plain.mask.tobytes()
    fine = world.render(SIDE.finer, depth=False, mask=False).rgb.astype(int)
    means = (fine[0::2, 0::2] + fine[1::2, 0::2] + fine[0::2, 1::2] + fine[1::2, 1::2] + 2) // 4
    np.testing.assert_array_equal(smooth.rgb, means)
    inside = (plain.mask == 61) & (np.abs(smooth.rgb.astype(int) - plain.rgb).sum(axis=2) == 0)
    assert inside.sum() > 10 and (smooth.rgb != plain.rgb).any()


def test_the_finer_view_looks_around_the_middle_of_each_pixel(world):
    """The mean of two by two rays is the ray of the pixel, for numpy and for PyBullet's matrices alike."""
    rays, fine = SIDE.rays.reshape(72, 96, 3), SIDE.finer.rays.reshape(144, 192, 3)
    means = (fine[0::2, 0::2] + fine[1::2, 0::2] + fine[0::2, 1::2] + fine[1::2, 1::2]) / 4.0
    np.testing.assert_allclose(means, rays, atol=1e-6)
    assert SIDE.finer.key != CameraView(SIDE.pose, SIDE.fov, (192, 144), SIDE.near, SIDE.far).key


def test_antialiasing_is_a_setting_of_cameras_and_off_at_first():
    """Policies' cameras cost what they did; a text is no setting."""
    assert CameraConfig().antialiasing is False
    with pytest.raises(InvalidValue):
        CameraConfig(antialiasing="yes")


def test_walls_are_bright_and_neutral():
    """All four render at 165 to 215 in every channel, and no channel stands out by more than 14: a white arm is seen before them."""
    with build(SceneSpec(format=1)) as world:
        for x, y in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
            view = CameraView(pose=look_at((0.2, 0.0, 1.9), (0.2 + x, y, 1.9)), fov=0.3, size=(32, 24), near=0.05, far=6.0)
            color = world.render(view, depth=False, mask=False).rgb.reshape(-1, 3).mean(axis=0)
            assert color.min() > 165 and color.max() < 215 and np.ptp(color) < 14


def test_the_table_is_no_floor(world):
    """The table is warm, the floor beside it cool and darker, and its sides are darker than its top."""
    view = CameraView(pose=look_at((0.2, 1.9, 1.3), (0.2, 0.6, 0.6)), fov=0.9, size=(96, 96), near=0.05, far=6.0)
    seen = world.render(view)
    ids = {name: i for i, name in world.masks.items()}
    table, floor = (seen.rgb[seen.mask == ids[name]].astype(float) for name in ("table", "floor"))
    top = np.median(table[table.sum(axis=1) > np.median(table.sum(axis=1))], axis=0)
    assert top[0] > 1.2 * top[2] and np.median(floor, axis=0)[0] < np.median(floor, axis=0)[2]
    assert np.median(floor) < 0.75 * np.median(top) and np.percentile(table.sum(axis=1), 3) < 0.8 * top.sum()


def _table_below(world, shadows=True, feet=False):
    """The table around the cubes, from above: brightness (h, w) and whether the table is seen."""
    view = CameraView(pose=look_at((0.3, 0.05, 1.6), (0.3, 0.05, TABLE_HEIGHT)), fov=0.5, size=(256, 256), near=0.05, far=6.0)
    seen = world.renderer.render_all([Request(view, shadows=shadows, feet=feet)])[0]
    table = next(i for i, name in world.masks.items() if name == "table")
    return seen.rgb.astype(int).sum(axis=2), seen.mask == table


def test_shadows_have_soft_edges(world):
    """Between full light and full shadow lie shares of many sizes, not two."""
    (lit, _), (shaded, table) = _table_below(world, shadows=False), _table_below(world)
    drop = np.round(100 * (lit - shaded)[table] / lit[table])
    assert drop.max() > 25
    assert len(np.unique(drop[(drop > 3) & (drop < drop.max() - 3)])) > 12


def test_the_table_is_darker_around_the_feet_of_what_stands_on_it(world):
    """Within 1 cm of the standing cube, on its lit side too; nowhere brighter, and nothing changes 10 cm from it."""
    (before, table), (after, _) = _table_below(world), _table_below(world, feet=True)
    assert (after <= before).all()
    dimmed = ((before - after) > 0.05 * before) & table
    assert 50 < dimmed.sum() < 0.2 * table.sum()
    assert (after[~table] == before[~table]).all()


def test_a_still_scene_does_not_flicker(world):
    """Successive pictures are the same bytes, smooth ones as well, also when layers begin to be kept."""
    for antialiasing in (False, True):
        taken = [world.renderer.render_all([Request(SIDE, shadows=True, antialiasing=antialiasing)])[0].rgb for _ in range(6)]
        assert all(picture.tobytes() == taken[0].tobytes() for picture in taken)


def test_a_rectangle_that_fills_the_picture_is_drawn_as_among_others(world, monkeypatch):
    """The short way for what sees the table alone gives the colours of the long one, but for texels at a rounding border."""
    view = CameraView(pose=look_at((0.3, 0.0, 1.15), (0.32, 0.05, TABLE_HEIGHT)), fov=0.6, size=(64, 64), near=0.05, far=6.0)
    short = world.render(view)
    monkeypatch.setattr(Canvas, "_hides", lambda *_: False)
    long = world.render(CameraView(view.pose, view.fov, view.size, view.near, 5.0))
    np.testing.assert_array_equal(short.depth, long.depth)
    np.testing.assert_array_equal(short.mask, long.mask)
    assert (short.rgb != long.rgb).any(axis=2).mean() < 0.01


def test_links_out_of_sight_are_left_out_and_nothing_else(world):
    """What a narrow view sees of the arm is what a wide one sees there."""
    wide = CameraView(pose=look_at((1.4, 0.9, 1.5), (0.0, 0.0, 1.1)), fov=0.8, size=(200, 200), near=0.05, far=6.0)
    focal = -wide.intrinsics()[0, 0]
    narrow = CameraView(wide.pose, 2.0 * float(np.arctan(20.0 / focal)), (40, 40), wide.near, wide.far)
    whole, part = world.render(wide), world.render(narrow)
    np.testing.assert_array_equal(whole.mask[80:120, 80:120], part.mask)
    assert len(np.unique(part.mask)) < len(np.unique(whole.mask))


def test_pictures_for_people_are_smooth(world):
    """`picture` has shadows, smooth edges and dark feet."""
    view = camera_view("front", CameraConfig(), world, PANDA)
    wanted = world.renderer.render_all([Request(view, shadows=True, antialiasing=True)])[0].rgb
    np.testing.assert_array_equal(world.renderer.image(view), wanted)


def _cans(folder, view, **request):
    """A dull can and one with each finish in turn, of the same grey: the picture, and where each is seen."""
    for name, gloss in (
        ("dull", ""),
        ("metal", '<specular rgb="0.35 0.35 0.35"/>'),
        ("glass", '<specular rgb="0.15 0.15 0.15"/>'),
    ):
        shape = '<geometry><cylinder radius="0.04" length="0.12"/></geometry>'
        look = f'<material name="grey"><color rgba="0.5 0.5 0.5 1"/>{gloss}</material>'
        link = f'<link name="can"><visual>{shape}{look}</visual><collision>{shape}</collision></link>'
        (folder / f"{name}.urdf").write_text(f'<robot name="can">{link}</robot>')
    bodies = tuple(
        BodySpec(
            name=name,
            asset=str(folder / f"{name}.urdf"),
            fixed=True,
            parent="world",
            pose=(0.3, y, TABLE_HEIGHT + 0.06, 0.0, 0.0, 0.0, 1.0),
        )
        for name, y in (("dull", -0.15), ("metal", 0.0), ("glass", 0.15))
    )
    with build(SceneSpec(format=2, body=bodies)) as world:
        seen = [world.renderer.render_all([Request(view, **request)])[0] for _ in range(2)]
        assert seen[0].rgb.tobytes() == seen[1].rgb.tobytes()
        ids = {name: i for i, name in world.masks.items()}
        return seen[0].rgb.astype(int), {name: seen[0].mask == ids[name] for name in ("dull", "metal", "glass")}


def test_metal_and_glass_mirror_the_room(tmp_path):
    """Streaks run along a metal wall and, less, along one of glass; a dull one is even. Without shadows all three are dull."""
    view = CameraView(pose=look_at((0.9, 0.0, 1.0), (0.3, 0.0, 0.8)), fov=0.7, size=(256, 192), near=0.05, far=6.0)
    colors, seen = _cans(tmp_path, view, shadows=True)
    spread = {name: np.std(colors[where].sum(axis=1)) for name, where in seen.items()}
    assert spread["metal"] > 2.0 * spread["dull"] and spread["metal"] > 1.3 * spread["glass"] > 1.3 * spread["dull"]
    plain, seen = _cans(tmp_path, view, shadows=False)
    assert np.ptp([np.std(plain[where].sum(axis=1)) for where in seen.values()]) < 0.3 * spread["dull"]
