"""What numpy draws is what TinyRenderer draws, pixel by pixel, near the camera and far from it."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import CameraView, Lighting, World, look_at
from rlbench_pin.sim.render.shots import BulletRasterizer, NumpyRasterizer, Shot, Sight
from tests.sim.support import ABOVE, BodySpec, build, cube, cube_scene

HOME = ABOVE + [0.4, -0.3, 0.2, 0.1, 0.5, 0.2, 0.3]


def view_from(eye: tuple[float, float, float], size: tuple[int, int] = (128, 96), near: float = 0.01) -> CameraView:
    """A camera that looks at the hand from somewhere."""
    return CameraView(pose=look_at(eye, (0.2, 0.0, 1.0)), fov=0.7, size=size, near=near, far=4.0)


def shots(world: World, views: list[CameraView]) -> tuple[list[Shot], list[Shot]]:
    """What both see without the room."""
    room = frozenset(body.model.uid for body in world.room.values())
    sights = [Sight(v, np.full(v.size[0] * v.size[1], v.far, dtype=np.float32), Lighting().key, 0.5) for v in views]
    ours, theirs = NumpyRasterizer(world.client, room, dict).shoot(sights), BulletRasterizer(world.client, room).shoot(sights)
    return ours, [_nearer(shot, view) for shot, view in zip(theirs, views, strict=True)]


def _nearer(shot: Shot, view: CameraView) -> Shot:
    """TinyRenderer draws some of what lies before the near plane."""
    kept = shot.depth >= view.near
    return Shot(*(getattr(shot, name)[kept] for name in ("pixels", "colors", "inverse", "depth", "segments")))


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
    """Pixels and ids agree but for one in a thousand at edges, depth within 50 um, colours within 2 of 255."""
    for eye, ours, theirs in zip(EYES, *shots(world, [view_from(eye) for eye in EYES]), strict=True):
        both, a, b = np.intersect1d(ours.pixels, theirs.pixels, return_indices=True)
        assert len(both) > 300, eye
        assert len(both) >= 0.998 * max(len(ours.pixels), len(theirs.pixels)), eye
        same = ours.segments[a] == theirs.segments[b]
        assert same.mean() > 0.998
        assert np.quantile(np.abs(ours.depth[a] - theirs.depth[b])[same], 0.999) < 5e-5
        assert np.quantile(np.abs(ours.colors[a] - theirs.colors[b])[same], 0.999) <= 2.0


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
        for name in ("pixels", "colors", "inverse", "depth", "segments"):
            np.testing.assert_array_equal(getattr(together[i], name), getattr(alone, name))
            np.testing.assert_array_equal(getattr(together[i], name), getattr(backwards[i], name))


def test_nothing_in_sight_is_an_empty_shot(world: World) -> None:
    """A camera that looks away sees no pixel of a moving thing."""
    away = CameraView(pose=look_at((1.0, 0.0, 1.0), (5.0, 0.0, 1.0)), fov=0.7, size=(32, 32), near=0.01, far=4.0)
    (shot,), _ = shots(world, [away])
    assert len(shot.pixels) == len(shot.colors) == len(shot.depth) == 0


def test_colours_and_hidden_links_follow_at_once() -> None:
    """A body painted red is drawn red, a hidden link of the arm not at all."""
    with build(cube_scene(cube("a", 0.3, 0.1, 0.9, fixed=True))) as world:
        world.robot.reset_configuration(HOME)
        view, uid = view_from(EYES[1]), world.body("a").model.uid
        world.body("a").set_color((1.0, 0.0, 0.0))
        (shot,), (theirs,) = shots(world, [view])
        seen = shot.colors[shot.segments & 0xFFFFFF == uid]
        assert len(seen) > 20 and (seen[:, 0] > 100).all() and (seen[:, 1:] == 0).all()
        for link in world.texture_overrides.robot_links:
            world.texture_overrides.show_robot_link(link, False)
        (shot,), (theirs,) = shots(world, [view])
        assert set(shot.segments & 0xFFFFFF) == set(theirs.segments & 0xFFFFFF) == {uid}
