"""What is seen is found where it is: clouds, clusters, colours, models."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest

pytest.importorskip("small_gicp")

from rlbench_pin.baselines.perception import (
    PALETTE,
    Cloud,
    KnownModel,
    back_project,
    clusters,
    distances,
    first_of_cells,
    lit_color,
    locate,
    outside,
    rectangle,
    thinned,
)
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray
from rlbench_pin.tasks import COLORS


def _cloud(points: FloatArray) -> Cloud:
    return Cloud(points, np.full_like(points, 0.5))


def _box(middle: tuple[float, float, float], side: float, rng: np.random.Generator) -> FloatArray:
    return np.asarray(middle) + side * (rng.random((600, 3)) - 0.5)


def test_a_pixel_goes_back_to_the_point_it_came_from() -> None:
    """Points that a camera projects to whole pixels come out of its depth image again."""
    intrinsics = np.array([[-60.0, 0.0, 16.0], [0.0, -60.0, 12.0], [0.0, 0.0, 1.0]])
    extrinsics = np.array(pin.SE3(pin.rpy.rpyToMatrix(2.8, 0.3, -0.5), np.array([0.4, -0.2, 1.5])).homogeneous)
    depth = np.random.default_rng(0).uniform(0.5, 2.0, (24, 32))
    points = back_project(depth, intrinsics, extrinsics)
    local = (points - extrinsics[:3, 3]) @ extrinsics[:3, :3]
    pixels = local @ intrinsics.T
    np.testing.assert_allclose(local[:, 2], depth.ravel())
    v, u = np.mgrid[0:24, 0:32]
    np.testing.assert_allclose(pixels[:, :2] / pixels[:, 2:], np.stack([u.ravel(), v.ravel()], axis=1), atol=1e-9)


def test_things_that_stand_apart_are_told_apart() -> None:
    """Two boxes and some dust are two clusters, the larger first."""
    rng = np.random.default_rng(1)
    large, small = _box((0.2, 0.1, 0.8), 0.06, rng), _box((0.2, -0.1, 0.8), 0.03, rng)[:200]
    dust = np.array([[0.5, 0.5, 0.9], [0.5, -0.5, 0.9]])
    found = clusters(_cloud(np.concatenate([small, dust, large])))
    assert [len(c) for c in found] == [600, 200]
    np.testing.assert_allclose(found[1].middle, (0.2, -0.1, 0.8), atol=0.002)


def test_nothing_has_no_clusters() -> None:
    """An empty cloud is no object."""
    assert clusters(_cloud(np.zeros((0, 3)))) == []


def test_thinning_keeps_one_point_of_each_cube() -> None:
    """A dense cloud becomes even, of points that were there."""
    cloud = _cloud(np.random.default_rng(2).random((5000, 3)) * 0.03)
    few = thinned(cloud, 0.01)
    assert len(few) == 27
    assert {tuple(p) for p in few.points} <= {tuple(p) for p in cloud.points}


def test_the_first_of_cells_are_in_the_order_of_the_cells() -> None:
    """Along x, then y, then z, on both sides of the origin; nothing of nothing."""
    points = np.random.default_rng(4).uniform(-0.5, 0.5, (3000, 3))
    cells, first = np.unique(np.floor(points / 0.1).astype(int), axis=0, return_index=True)
    assert len(cells) > 500
    np.testing.assert_array_equal(first_of_cells(points, 0.1), first)
    assert len(first_of_cells(np.zeros((0, 3)), 0.1)) == 0


@pytest.mark.simulation
def test_point_clouds_need_no_registration_library() -> None:
    """Without small_gicp the baselines that only see points work, and the classical one says which extra it needs."""
    program = (
        "import sys; sys.modules['small_gicp'] = None\n"
        "import rlbench_pin.baselines.perception, rlbench_pin.baselines.few_shot\n"
        "from rlbench_pin.errors import MissingExtra\n"
        "try:\n    import rlbench_pin.baselines.classical\n"
        "except MissingExtra as error:\n    sys.stdout.write(error.extra)"
    )
    assert subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout == "classical"


@pytest.mark.parametrize("yaw", [0.0, 0.3, 1.2])
def test_the_rectangle_around_a_block_turns_with_it(yaw: float) -> None:
    """Middle, sides and heading of a block of 4 by 8 cm."""
    flat = (np.random.default_rng(3).random((4000, 2)) - 0.5) * (0.04, 0.08)
    turn = pin.rpy.rpyToMatrix(0.0, 0.0, yaw)[:2, :2]
    middle, heading, sides = rectangle(flat @ turn.T + (0.3, -0.1))
    np.testing.assert_allclose(middle, (0.3, -0.1), atol=0.002)
    assert abs(heading - yaw) < 0.05
    np.testing.assert_allclose(sides, (0.04, 0.08), atol=0.004)


@pytest.mark.parametrize("name", [color.name for color in COLORS])
def test_colours_keep_their_names_in_the_light(name: str) -> None:
    """A surface of which half lies in shade is called by the colour of its lit half, with the noise of light."""
    rng = np.random.default_rng(4)
    rgb = np.array(dict(COLORS)[name])
    shades = np.concatenate([rng.uniform(0.96, 1.0, (100, 1)), rng.uniform(0.4, 0.6, (100, 1))])
    assert min(PALETTE, key=lambda word: distances(lit_color(rgb * shades), word)) == name


@pytest.mark.simulation
@pytest.mark.parametrize("yaw", [-2.0, 0.4, 3.0])
def test_a_known_model_is_found_where_it_stands(yaw: float) -> None:
    """The half of a laptop that is seen from one side is registered to 5 mm and 2 degrees, its screen at the right angle."""
    model, states = KnownModel.named("laptop/laptop"), [{"screen_hinge": 1.5}, {"screen_hinge": 1.9}]
    truth = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, yaw), np.array([0.35, -0.12, TABLE_HEIGHT]))
    points = model.points_at(states[1]) @ truth.rotation.T + truth.translation
    seen = points[points[:, 2] > TABLE_HEIGHT + 0.02]
    found = locate(model, _cloud(seen + np.random.default_rng(5).normal(0.0, 5e-4, seen.shape)), states)
    assert found.joints == states[1]
    assert np.linalg.norm(found.placement.translation - truth.translation) < 0.005
    assert np.linalg.norm(pin.log3(found.placement.rotation.T @ truth.rotation)) < np.deg2rad(2.0)


def test_what_is_inside_of_a_model_is_not_looked_for() -> None:
    """Of a box in a box, the outer sides and the top are kept, none of the inner."""
    rng = np.random.default_rng(6)
    faces = rng.uniform(-0.5, 0.5, (6000, 3))
    faces[np.arange(6000), rng.integers(0, 3, 6000)] = 0.5 * rng.choice([-1.0, 1.0], 6000)
    outer, inner = faces * 0.2, faces * 0.1
    kept = outside(np.concatenate([outer, inner]))
    assert np.abs(kept).max(axis=1).min() > 0.09
    sides = outer[outer[:, 2] > -0.09]
    assert len(kept) > 0.9 * len(sides)


def test_a_chest_is_found_by_what_is_seen_of_it() -> None:
    """Front, top and one side: the walls of the drawers behind the side are not taken for it."""
    model = KnownModel.named("chest/chest")
    truth = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, 0.3), np.array([0.4, 0.1, TABLE_HEIGHT]))
    points = outside(model.points_at())
    seen = points[(points[:, 0] < -0.1) | (points[:, 1] > 0.16) | (points[:, 2] > 0.35)]
    found = locate(model, _cloud(seen @ truth.rotation.T + truth.translation))
    assert np.linalg.norm(found.placement.translation - truth.translation) < 0.004
    assert np.linalg.norm(pin.log3(found.placement.rotation.T @ truth.rotation)) < np.deg2rad(0.5)


def test_a_model_knows_its_joints() -> None:
    """The axis of the fridge's door, and a door that turns about it without coming nearer to it."""
    model = KnownModel.named("fridge/fridge")
    axis = model.axis("upper_door")
    np.testing.assert_allclose(axis.direction, (0.0, 0.0, -1.0), atol=1e-12)
    far = [np.linalg.norm((model.link_points("upper_link", {"upper_door": a}) - axis.origin)[:, :2], axis=1) for a in (0.0, 1.3)]
    np.testing.assert_allclose(far[0], far[1], atol=1e-9)
