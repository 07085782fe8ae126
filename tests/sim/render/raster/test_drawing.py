"""What numpy draws is what TinyRenderer draws, pixel by pixel, near the camera and far from it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import CameraView, Lighting, World, look_at
from rlbench_pin.sim.render.raster.drawing import CameraGroup
from rlbench_pin.sim.render.raster.meshes import Triangles
from rlbench_pin.sim.render.raster.stage import Appearance, Layers, Placed, join
from rlbench_pin.sim.render.shading import colors_in_light
from rlbench_pin.sim.render.shots import BulletRasterizer, NumpyRasterizer, Shot
from tests.sim.support import ABOVE, BodySpec, build, cube, cube_scene

PRODUCTS = ("pixels", "colors", "inverse", "depth", "segments", "segment", "normals")
HOME = ABOVE + [0.4, -0.3, 0.2, 0.1, 0.5, 0.2, 0.3]


def view_from(eye: tuple[float, float, float], size: tuple[int, int] = (128, 96), near: float = 0.01) -> CameraView:
    """A camera that looks at the gripper from somewhere."""
    return CameraView(pose=look_at(eye, (0.2, 0.0, 1.0)), fov=0.7, size=size, near=near, far=4.0)


def shots(world: World, views: list[CameraView]) -> tuple[list[Shot], list[Shot]]:
    """What both see without the room."""
    room = frozenset(body.model.uid for body in world.room.values())
    camera_groups = [CameraGroup([v], True, Lighting().ambient + Lighting().mean_fill) for v in views]
    limits = [np.full(v.size[0] * v.size[1], v.far, dtype=np.float32) for v in views]
    shootings = [
        rasterizer.shoot(camera_groups, Lighting(), None)
        for rasterizer in (NumpyRasterizer(world.client, room, Appearance()), BulletRasterizer(world.client, room))
    ]
    ours, theirs = ([shooting.shot(n, limit) for n, limit in enumerate(limits)] for shooting in shootings)
    return ours, [_nearer(shot, view) for shot, view in zip(theirs, views, strict=True)]


def _nearer(shot: Shot, view: CameraView) -> Shot:
    """TinyRenderer draws some of what lies before the near plane."""
    kept = shot.depth >= view.near
    parts = {name: getattr(shot, name)[..., kept] for name in ("pixels", "inverse", "depth", "segment", "colors")}
    return replace(shot, **parts)


def ids(shot: Shot) -> np.ndarray:
    """Segmentation values of all pixels."""
    return shot.segments.take(shot.segment)


def lit(shot: Shot) -> np.ndarray:
    """Colours (3, n) of our shot in the ambient and key light without shadows."""
    assert shot.normals is not None
    return np.minimum(colors_in_light(replace(shot, colors=shot.colors.copy()), shot.normals, Lighting(), None, ()), 255.0)


@pytest.fixture(scope="module")
def world():
    """The arm over two cubes and a ball that is a mesh."""
    ball = BodySpec(
        name="ball", asset="objects/ball_marker/ball_marker.urdf", parent="world", pose=(0.3, 0.2, 0.9, 0, 0, 0, 1), scale=0.4
    )
    with build(SceneSpec(format=1, body=(cube("a", 0.3, 0.1, 0.9, fixed=True), cube("b", 0.35, -0.1), ball))) as world:
        world.robot.reset_configuration(HOME)
        yield world


EYES = [(1.3, 0.0, 1.5), (-0.2, 0.4, 1.9), (0.2, 1.5, 0.8), (0.2, 0.001, 2.4), (0.5, 0.3, 1.1)]


def test_both_draw_the_same_pixels(world: World) -> None:
    """Pixels and ids agree but for one in a thousand at edges, depth within 50 um, colours within 3 of 255."""
    views = [view_from(eye) for eye in EYES]
    for eye, ours, theirs in zip(EYES, *shots(world, views), strict=True):
        both, a, b = np.intersect1d(ours.pixels, theirs.pixels, return_indices=True)
        assert len(both) > 300, eye
        assert len(both) >= 0.998 * max(len(ours.pixels), len(theirs.pixels)), eye
        same = ids(ours)[a] == ids(theirs)[b]
        assert same.mean() > 0.998
        assert np.quantile(np.abs(ours.depth[a] - theirs.depth[b])[same], 0.999) < 5e-5
        assert ours.normals is not None
        faces_light = Lighting().key.unit @ ours.normals[:, a] > 0.0  # TinyRenderer has highlights on the other side, too
        apart = np.abs(lit(ours)[:, a] - theirs.colors[:, b])[:, same & faces_light]
        assert np.quantile(apart, 0.999) <= 3.0


def test_what_crosses_the_near_plane_is_cut_there(world: World) -> None:
    """With planes through the arm, nothing nearer than the plane is drawn; the rest agrees."""
    views = [view_from((1.3, 0.0, 1.5), near=1.0), view_from((-0.2, 0.4, 1.9), near=0.9)]
    for view, ours, theirs in zip(views, *shots(world, views), strict=True):
        assert len(ours.pixels) > 150 and (ours.depth >= view.near * 0.9999).all()
        both, a, b = np.intersect1d(ours.pixels, theirs.pixels, return_indices=True)
        close = np.abs(ours.depth[a] - theirs.depth[b]) < 1e-4
        assert close.mean() > 0.98


def test_a_picture_does_not_depend_on_other_cameras(world: World) -> None:
    """Alone, with others of other sizes, and in another order: the same bytes."""
    views = [
        view_from(eye, size) for eye, size in zip(EYES, [(128, 96), (64, 64), (200, 100), (33, 47), (128, 128)], strict=True)
    ]
    together = shots(world, views)[0]
    backwards = shots(world, views[::-1])[0][::-1]
    for i, view in enumerate(views):
        alone = shots(world, [view])[0][0]
        for name in PRODUCTS:
            np.testing.assert_array_equal(getattr(together[i], name), getattr(alone, name))
            np.testing.assert_array_equal(getattr(together[i], name), getattr(backwards[i], name))


def test_nothing_in_sight_is_an_empty_shot(world: World) -> None:
    """A camera that looks away sees no pixel of a moving thing."""
    away = CameraView(pose=look_at((1.0, 0.0, 1.0), (5.0, 0.0, 1.0)), fov=0.7, size=(32, 32), near=0.01, far=4.0)
    (shot,), _ = shots(world, [away])
    assert len(shot.pixels) == shot.colors.shape[1] == len(shot.depth) == 0


def test_colours_and_hidden_links_follow_at_once() -> None:
    """A body painted red is drawn red, a hidden link of the arm not at all."""
    with build(cube_scene(cube("a", 0.3, 0.1, 0.9, fixed=True))) as world:
        world.robot.reset_configuration(HOME)
        view, uid = view_from(EYES[1]), world.body("a").model.uid
        world.body("a").set_color((1.0, 0.0, 0.0))
        (shot,), (theirs,) = shots(world, [view])
        seen = shot.colors[:, ids(shot) & 0xFFFFFF == uid]
        assert seen.shape[1] > 20 and (seen[0] > 100).all() and (seen[1:] == 0).all()
        for link in world.texture_overrides.robot_links:
            world.texture_overrides.show_robot_link(link, False)
        (shot,), (theirs,) = shots(world, [view])
        assert set(ids(shot) & 0xFFFFFF) == set(ids(theirs) & 0xFFFFFF) == {uid}


def test_what_was_drawn_before_changes_no_byte() -> None:
    """Things rest, move, rest again, are painted and hidden: images are those of a renderer that has drawn nothing yet."""
    with build(cube_scene(cube("a", 0.3, 0.1, 0.9, fixed=True), cube("b", 0.35, -0.1, 0.9, fixed=True))) as world:
        room = frozenset(body.model.uid for body in world.room.values())
        views = [view_from(eye) for eye in EYES[:2]]
        camera_groups = [CameraGroup([view], True) for view in views] + [CameraGroup(views, True)]
        old = NumpyRasterizer(world.client, room, Appearance())
        rest = np.zeros(7)

        def turn() -> None:
            rest[0] += 0.1
            world.robot.reset_configuration(HOME + rest)

        def nothing() -> None:
            pass

        changes = [
            *[nothing] * 5,
            turn,
            *[nothing] * 4,
            lambda: world.body("a").set_pose((0.32, 0.1, 0.92, 0.0, 0.0, 0.0, 1.0)),
            turn,
            *[nothing] * 3,
            lambda: world.body("b").set_color((1.0, 0.0, 0.0)),
            lambda: world.texture_overrides.show_robot_link(3, False),
            *[nothing] * 3,
            lambda: world.texture_overrides.show_robot_link(3, True),
            turn,
        ]
        for change in changes:
            change()
            fresh = NumpyRasterizer(world.client, room, Appearance()).shoot(camera_groups, Lighting(), None)
            again = old.shoot(camera_groups, Lighting(), None)
            for number in range(len(camera_groups)):
                ours, expected = again.shot(number, None), fresh.shot(number, None)
                for name in PRODUCTS:
                    np.testing.assert_array_equal(getattr(ours, name), getattr(expected, name))


def test_layers_are_few_and_hold_only_what_rests() -> None:
    """A camera has one from its second look on; forty cameras leave twelve; what moves again leaves all of them."""
    views, layers = [view_from((1.3, 0.01 * i, 1.5), (8, 8)) for i in range(40)], Layers()
    shown, still = np.ones(5, dtype=np.bool_), np.array([True, False])
    assert layers.of(views[:1], shown, still) == [None]
    (layer,) = layers.of(views[:1], shown, still)
    assert layer is not None and not layer.links.any()
    layer.nearest[:], layer.links[0] = 7, True
    assert layers.of(views[:1], shown, still)[0] is layer and (layer.nearest == 7).all()
    layers.of(views[:1], shown, np.array([False, False]))
    assert not layer.links.any() and (layer.nearest == 0).all()
    layers.of(views, shown, still)
    assert sum(layer is not None for layer in layers.of(views[-12:], shown, still)) == 12
    assert layers.of(views[:1], shown, still) == [None]


def test_what_trembles_again_has_to_rest_longer() -> None:
    """A link is still after two instants; one that then moves after four, and so on."""
    parts = join({(0, -1): [(0, Triangles(np.eye(3)[None], np.eye(3)[None]))]}, [0])
    placed, frame = Placed(parts), np.eye(4)
    waits: list[int] = []
    for _ in range(3):
        frame[0, 3] += 0.1
        placed.place({(0, -1): frame})
        waits.append(0)
        while not placed.still[0]:
            placed.place({(0, -1): frame})
            waits[-1] += 1
    assert waits == [2, 4, 8]


def test_a_ball_is_shaded_smoothly_and_a_cube_has_edges(world: World) -> None:
    """Normals of the ball are within six degrees of those of a sphere; a cube has three sides and edges."""
    center = np.array([0.3, 0.2, 0.9])
    view = CameraView(pose=look_at((0.9, 0.5, 1.4), (0.3, 0.15, 0.9)), fov=0.35, size=(320, 320), near=0.01, far=4.0)
    (shot,), _ = shots(world, [view])
    assert shot.normals is not None
    body = ids(shot) & 0xFFFFFF
    ball, side = (body == world.body(name).model.uid for name in ("ball", "a"))
    points = view.rays[shot.pixels] * shot.depth[:, None] + view.pose[:3]
    outwards = (points - center)[ball] / np.linalg.norm((points - center)[ball], axis=1, keepdims=True)
    assert ball.sum() > 300 and np.einsum("ij,ji->i", outwards, shot.normals[:, ball]).min() > np.cos(np.radians(6.0))
    _, counts = np.unique(shot.normals[:, side].round(3), axis=1, return_counts=True)
    assert side.sum() > 300 and np.sort(counts)[-3:].sum() > 0.8 * side.sum()
