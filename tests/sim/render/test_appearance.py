"""Smooth edges, soft shadows, dark feet, and a bright room; what is left out of an image to save time changes nothing in it."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.assets import ASSETS
from rlbench_pin.environment.observations.config import CameraConfig
from rlbench_pin.environment.randomization.config import images_in
from rlbench_pin.errors import InvalidValue
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.sim import CameraView, Request, look_at, read_texture
from rlbench_pin.sim.render.backdrop import Canvas
from rlbench_pin.sim.render.renderer import Renderer
from rlbench_pin.sim.render.shading import smoothed
from rlbench_pin.spatial import TABLE_HEIGHT
from tests.sim.support import build, cube, cube_scene

SIDE = CameraView(pose=look_at((0.9, 0.5, 1.3), (0.3, 0.0, 0.8)), fov=0.6, size=(96, 72), near=0.05, far=6.0)


def _urdf(folder, name, material):
    """A plate of 20 x 20 cm, 1 cm thick, of some material."""
    shape = '<geometry><box size="0.2 0.01 0.2"/></geometry>'
    visual = f'<visual>{shape}<material name="m">{material}</material></visual>'
    link = f'<link name="plate">{visual}<collision>{shape}</collision></link>'
    (folder / f"{name}.urdf").write_text(f'<robot name="plate">{link}</robot>')
    return str(folder / f"{name}.urdf")


PLATE = CameraView(pose=look_at((0.3, 0.9, 0.9), (0.3, 0.0, 0.9)), fov=0.35, size=(96, 96), near=0.05, far=6.0)


def _plate_scene(asset):
    """A plate on edge before a red cube."""
    where = {"fixed": True, "parent": "world"}
    plate = BodySpec(name="plate", asset=asset, pose=(0.3, 0.2, TABLE_HEIGHT + 0.15, 0.0, 0.0, 0.0, 1.0), **where)
    return cube_scene(cube("a", 0.3, 0.0, TABLE_HEIGHT + 0.12, fixed=True), plate)


def test_one_sees_through_glass(tmp_path):
    """Behind a plate of a third of opacity a cube is seen, paler; depth and mask are those of an opaque plate."""
    seen = {}
    for name, alpha in (("glass", 0.33), ("solid", 1.0)):
        with build(_plate_scene(_urdf(tmp_path, name, f'<color rgba="0.6 0.8 0.9 {alpha}"/>'))) as world:
            world.body("a").set_color((1.0, 0.0, 0.0))
            seen[name] = [_taken(world, PLATE) for _ in range(3)]
            assert all(each.rgb.tobytes() == seen[name][0].rgb.tobytes() for each in seen[name])
    glass, solid = seen["glass"][0], seen["solid"][0]
    assert glass.depth.tobytes() == solid.depth.tobytes() and glass.mask.tobytes() == solid.mask.tobytes()
    middle = glass.rgb[44:52, 44:52].reshape(-1, 3).astype(int)
    assert (middle[:, 0] - middle[:, 2] > 25).any() and not (solid.rgb[44:52, 44:52, 0] > solid.rgb[44:52, 44:52, 2]).any()


def test_a_lamp_shines_in_its_colour_alone(tmp_path):
    """In the colour of its emission it is bright on its dark side and lights the table; in another it does neither."""
    asset = _urdf(tmp_path, "lamp", '<color rgba="1 1 0 1"/><emission rgb="1 1 0" reach="0.3"/>')
    down = CameraView(pose=look_at((0.3, 0.0, 1.9), (0.3001, 0.2, TABLE_HEIGHT)), fov=0.6, size=(64, 64), near=0.05, far=6.0)
    with build(_plate_scene(asset)) as world:
        shining, table = _taken(world, PLATE), _taken(world, down).rgb.astype(int)
        world.body("plate").set_color((0.9, 0.9, 0.0))
        dull, dark = _taken(world, PLATE), _taken(world, down).rgb.astype(int)
    plate = shining.mask == 62
    assert plate.sum() > 200 and np.ptp(shining.rgb[plate], axis=0).max() == 0 and shining.rgb[plate][0, 0] > 235
    assert (shining.rgb[plate].astype(int) - dull.rgb[plate])[:, 0].min() > 10
    assert np.percentile((table - dark).sum(axis=2), 80) > 20


def _brightness_of_plate(asset):
    """Return the mask of the plate, and the brightness of its pixels."""
    with build(_plate_scene(asset)) as world:
        seen = _taken(world, PLATE)
    plate = seen.mask == 62
    assert plate.sum() > 200
    return plate, seen.rgb[plate].astype(float).mean(axis=1)


def test_colours_of_vertices_keep_light_away(tmp_path):
    """Towards a corner with a dark vertex a plate is darker, and nothing else changes; a file without them is evenly bright."""
    corners = [f"{x} 0.005 {z}" for x, z in ((-0.1, -0.1), (-0.1, 0.1), (0.1, 0.1), (0.1, -0.1))]
    seen = {}
    for name, ends in (("plain", [""] * 4), ("dark", [" 0.4 0.4 0.4"] * 2 + [" 1 1 1"] * 2)):
        points = "".join(f"v {corner}{end}\n" for corner, end in zip(corners, ends, strict=True))
        (tmp_path / f"{name}.obj").write_text(points + "f 1 2 3\nf 1 3 4\n")
        asset = _urdf(tmp_path, name, '<color rgba="0.6 0.6 0.6 1"/>')
        (tmp_path / f"{name}.urdf").write_text(
            (tmp_path / f"{name}.urdf").read_text().replace('<box size="0.2 0.01 0.2"/>', f'<mesh filename="{name}.obj"/>', 1)
        )
        seen[name] = _brightness_of_plate(asset)
    assert (seen["plain"][0] == seen["dark"][0]).all()
    share = np.sort(seen["dark"][1] / seen["plain"][1])
    assert share[0] < 0.65 and share[-1] > 0.97 and np.ptp(seen["plain"][1]) < 12.0


def test_a_pattern_changes_brightness_and_keeps_the_mean(tmp_path):
    """A plate of wood has lighter and darker places, and a colour that a task gives it is still seen."""
    wood = ASSETS / "patterns" / "wood.png"
    plain = _brightness_of_plate(_urdf(tmp_path, "plain", '<color rgba="0.6 0.6 0.6 1"/>'))[1]
    asset = _urdf(tmp_path, "wood", f'<color rgba="0.6 0.6 0.6 1"/><pattern filename="{wood}" size="0.2"/>')
    patterned = _brightness_of_plate(asset)[1]
    assert abs(patterned.mean() / plain.mean() - 1.0) < 0.03 and patterned.std() > plain.std() + 1.0
    with build(_plate_scene(asset)) as world:
        world.body("plate").set_color((0.9, 0.1, 0.1))
        seen = _taken(world, PLATE)
    colors = seen.rgb[seen.mask == 62].astype(int)
    assert (colors[:, 0] > 3 * colors[:, 1]).all()


def test_white_in_full_light_keeps_its_shape(world):
    """No more than one in a hundred pixels of the white arm is at 255."""
    view = CameraView(pose=look_at((1.2, 0.8, 1.5), (-0.1, 0.0, 1.1)), fov=0.6, size=(128, 128), near=0.05, far=6.0)
    seen = _taken(world, view)
    arm = (seen.mask > 0) & np.isin(seen.mask, [i for i, name in world.masks.items() if "link" in name])
    assert arm.sum() > 500 and (seen.rgb[arm].min(axis=1) == 255).mean() < 0.01


@pytest.fixture(scope="module")
def world():
    """A cube on the table, one in the air, and the arm."""
    with build(cube_scene(cube("low", 0.35, 0.0), cube("high", 0.3, 0.15, 1.0, fixed=True))) as world:
        yield world


def _taken(world, view, **request):
    """The images of a request with shadows."""
    return world.renderer.render_all([Request(view, shadows=True, **request)])[0]


def test_smooth_edges_change_colours_at_edges_alone(world):
    """Depth and mask are the same bytes; only pixels beside another surface change, towards colours that are around them."""
    plain, smooth = _taken(world, SIDE), _taken(world, SIDE, antialiasing=True)
    assert smooth.depth.tobytes() == plain.depth.tobytes() and smooth.mask.tobytes() == plain.mask.tobytes()
    changed = (smooth.rgb != plain.rgb).any(axis=2)
    assert 30 < changed.sum() < 0.2 * changed.size
    around = np.stack([np.roll(plain.rgb, step, axis) for axis in (0, 1) for step in (-1, 0, 1)])
    inner = np.zeros_like(changed)
    inner[1:-1, 1:-1] = True
    chosen = changed & inner
    assert (smooth.rgb[chosen] >= around.min(axis=0)[chosen]).all() and (smooth.rgb[chosen] <= around.max(axis=0)[chosen]).all()


def test_a_slanting_edge_becomes_a_ramp():
    """An edge that climbs one pixel in eight is a line of shares that grow evenly; steps of one pixel are no more."""
    surfaces = (np.arange(16)[:, None] > 4 + np.arange(64)[None, :] / 8.0).astype(np.uint8)[None]
    images = np.repeat((surfaces * 200)[..., None], 3, axis=3).astype(np.uint8)
    smoothed(images, surfaces)
    share = images[0, :, 8:56, 0].sum(axis=0) / 200.0
    exact = 16.0 - (5.0 + (np.arange(8, 56) + 0.5) / 8.0) + 0.5
    assert np.abs(share - exact).max() < 0.2 and np.abs(np.diff(share)).max() < 0.2


def test_pictures_for_people_are_means_of_two_by_two(world):
    """`fine` takes the means of the image of twice the size."""
    fine = _taken(world, SIDE.finer, antialiasing=True, depth=False, mask=False).rgb.astype(int)
    means = (fine[0::2, 0::2] + fine[1::2, 0::2] + fine[0::2, 1::2] + fine[1::2, 1::2] + 2) // 4
    np.testing.assert_array_equal(_taken(world, SIDE, antialiasing=True, fine=True).rgb, means)
    np.testing.assert_array_equal(world.renderer.image(SIDE), means)


def test_the_finer_view_looks_around_the_middle_of_each_pixel(world):
    """The mean of two by two rays is the ray of the pixel, for numpy and for PyBullet's matrices alike."""
    rays, fine = SIDE.rays.reshape(72, 96, 3), SIDE.finer.rays.reshape(144, 192, 3)
    means = (fine[0::2, 0::2] + fine[1::2, 0::2] + fine[0::2, 1::2] + fine[1::2, 1::2]) / 4.0
    np.testing.assert_allclose(means, rays, atol=1e-6)
    assert SIDE.finer.key != CameraView(SIDE.pose, SIDE.fov, (192, 144), SIDE.near, SIDE.far).key


def test_antialiasing_is_a_setting_of_cameras_and_on_at_first():
    """Cameras have smooth edges unless they are asked not to; a text is no setting."""
    assert CameraConfig().antialiasing is True
    with pytest.raises(InvalidValue):
        CameraConfig(antialiasing="yes")


def test_walls_are_bright_and_neutral():
    """All four render at 165 to 215 in every channel, none of which stands out by more than 14: a white arm is seen there."""
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


def _table_below(world, shadows=True):
    """The table around the cubes, from above: brightness (h, w) and whether the table is seen."""
    view = CameraView(pose=look_at((0.3, 0.05, 1.6), (0.3, 0.05, TABLE_HEIGHT)), fov=0.5, size=(256, 256), near=0.05, far=6.0)
    seen = world.renderer.render_all([Request(view, shadows=shadows)])[0]
    table = next(i for i, name in world.masks.items() if name == "table")
    return seen.rgb.astype(int).sum(axis=2), seen.mask == table


def test_shadows_have_soft_edges(world):
    """Between full light and full shadow lie shares of many sizes, not two."""
    (lit, _), (shaded, table) = _table_below(world, shadows=False), _table_below(world)
    drop = np.round(100 * (lit - shaded)[table] / lit[table])
    assert drop.max() > 25
    assert len(np.unique(drop[(drop > 3) & (drop < drop.max() - 3)])) > 12


def test_the_table_is_darker_around_the_feet_of_what_stands_on_it(world):
    """Within 1 cm of the standing cube, also on the side that faces the light, where no shadow falls."""
    view = CameraView(pose=look_at((0.35, 0.0, 1.3), (0.3501, 0.0, TABLE_HEIGHT)), fov=0.6, size=(128, 128), near=0.05, far=6.0)
    seen, lit = _taken(world, view), world.render(view)
    table = next(i for i, name in world.masks.items() if name == "table")
    points = view.rays.reshape(128, 128, 3) * seen.depth[..., None] + view.pose[:3]
    half = 0.5 * np.ptp(points[seen.mask == 61][:, 0])
    towards = (points[..., 0] - 0.35 - half > 0.001) & (np.abs(points[..., 1]) < 0.02) & (seen.mask == table)
    near, far = (towards & (np.abs(points[..., 0] - 0.35 - half - away) < 0.006) for away in (0.007, 0.10))
    drop = (lit.rgb.astype(float) - seen.rgb).sum(axis=2)
    assert drop[near].mean() > drop[far].mean() + 20.0


def test_shadows_are_softer_below_what_is_high():
    """The edge of the shadow of a cube that floats 40 cm above the table is more than twice as wide as of one at 5 cm."""
    widths = []
    for height in (0.05, 0.40):
        with build(cube_scene(cube("a", 0.3, 0.0, TABLE_HEIGHT + height, fixed=True))) as world:
            world.robot.reset_configuration(np.array([2.5, 0.0, 0.0, -1.6, 0.0, 1.6, 0.8]))
            spot = 0.3 - 0.6 / 1.6 * height, -0.4 / 1.6 * height
            pose = look_at((spot[0] - 0.3, spot[1] - 0.3, 1.2), (*spot, TABLE_HEIGHT))
            view = CameraView(pose=pose, fov=0.3, size=(256, 256), near=0.02, far=6.0)
            lit, seen = world.render(view).rgb.astype(float).sum(axis=2), _taken(world, view).rgb.astype(float).sum(axis=2)
            share = 1.0 - seen / lit
            full = share.max()
            widths.append(((share > 0.2 * full) & (share < 0.8 * full)).sum())
    assert widths[1] > 1.5 * widths[0]


def test_a_still_scene_does_not_flicker(world):
    """Successive images are the same bytes, smooth ones as well, also when layers begin to be kept."""
    for antialiasing in (False, True):
        taken = [world.renderer.render_all([Request(SIDE, shadows=True, antialiasing=antialiasing)])[0].rgb for _ in range(6)]
        assert all(picture.tobytes() == taken[0].tobytes() for picture in taken)


@pytest.mark.simulation
def test_what_rests_is_drawn_once_and_nothing_changes_by_that():
    """The arm moves, cubes move, are painted and stop, links hide: images with shadows are those of a renderer without a past."""
    above = CameraView(pose=look_at((0.2, -0.5, 1.6), (0.3, 0.0, 0.8)), fov=0.8, size=(64, 64), near=0.05, far=6.0)
    requests = [Request(view, shadows=True, antialiasing=True) for view in (SIDE, above)]
    with build(cube_scene(cube("a", 0.3, 0.1, fixed=True), cube("b", 0.35, -0.1, 0.9, fixed=True))) as world:
        old, angles = world.renderer, world.robot.joint_positions.copy()
        kept, pattern = [], read_texture(images_in(ASSETS / "textures")[0])

        def wait():
            angles[0] += 0.02
            world.robot.reset_configuration(angles)

        changes = [
            *[wait] * 8,
            lambda: world.body("b").set_pose((0.3, 0.0, 0.95, 0.0, 0.0, 0.0, 1.0)),
            *[wait] * 8,
            lambda: world.body("a").set_color((1.0, 0.0, 0.0)),
            *[wait] * 4,
            lambda: world.texture_overrides.set_body("a", pattern, 6.0),
            *[wait] * 4,
            lambda: world.texture_overrides.set_robot_link(4, pattern, 6.0),
            *[wait] * 4,
            lambda: world.texture_overrides.clear_body("a"),
            *[wait] * 4,
            lambda: world.texture_overrides.show_robot_link(3, False),
            *[wait] * 4,
            lambda: world.body("table").set_color((0.2, 0.3, 0.9)),
            *[wait] * 4,
        ]
        for change in changes:
            change()
            appearance = old._rasterizer._stage._appearance
            fresh = Renderer(old._client, old._room, old._room_ids, old._ids, appearance)
            fresh._link_textures = old._link_textures
            for ours, expected in zip(old.render_all(requests), fresh.render_all(requests), strict=True):
                for name in ("rgb", "depth", "mask"):
                    assert getattr(ours, name).tobytes() == getattr(expected, name).tobytes()
            kept.append(old._stationary_links is not None)
        assert sum(kept) > 20 and not kept[8]


def test_what_rests_is_kept_for_one_set_of_cameras(world):
    """With a first camera that moves, of one size or another, with or without colours, a stationary camera sees the same."""
    expected = world.renderer.render_all([Request(SIDE, shadows=True)])[0].rgb.tobytes()
    for k in range(24):
        size = (64, 48) if k < 8 else (40, 40)
        eye = (0.9, 0.5 + 0.01 * k, 1.3)
        moving = CameraView(pose=look_at(eye, (0.3, 0.0, 0.8)), fov=0.6, size=size, near=0.05, far=6.0)
        requests = [Request(moving, rgb=k < 16, shadows=True), Request(SIDE, shadows=True)]
        assert world.renderer.render_all(requests)[1].rgb.tobytes() == expected


def test_a_camera_near_the_table_does_not_change_what_others_see(world):
    """One whose pixels are smaller than those of the shadows sees these smooth; shadows in other images stay as they are."""
    expected = world.renderer.render_all([Request(SIDE, shadows=True)])[0].rgb.tobytes()
    for height in (0.05, 0.4):
        pose = look_at((0.3, 0.0, TABLE_HEIGHT + height), (0.31, 0.0, TABLE_HEIGHT))
        near = CameraView(pose=pose, fov=0.6, size=(64, 64), near=0.01, far=6.0)
        assert world.renderer.render_all([Request(near, shadows=True), Request(SIDE, shadows=True)])[1].rgb.tobytes() == expected


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


def _cans(folder, view, **request):
    """A dull can and one with each finish in turn, of the same grey: the image, and where each is seen."""
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
    assert spread["metal"] > 1.7 * spread["dull"] and spread["metal"] > 1.3 * spread["glass"] > 1.3 * spread["dull"]
    plain, seen = _cans(tmp_path, view, shadows=False)
    assert np.ptp([np.std(plain[where].sum(axis=1)) for where in seen.values()]) < 0.3 * spread["dull"]
