"""Random places inside boundaries: fit, distance, turns, refusals, and the parts that programs replace."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from pyrep.objects.dummy import Dummy
from pyrep.objects.shape import Shape
from rlbench import Environment, ObservationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.exceptions import BoundaryError
from rlbench.backend.spawn_boundary import BoundaryObject, BoundingBox, SpawnBoundary
from rlbench.tasks import StackBlocks
from rlbench_pin.errors import TaskError

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module", autouse=True)
def blocks() -> Iterator[list[Shape]]:
    """The eight blocks of `stack_blocks`, with its four patches around a square."""
    config = ObservationConfig()
    config.set_all(False)
    env = Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=config, headless=True)
    env.get_task(StackBlocks).reset()
    yield [Shape(f"{kind}{i}") for kind in ("block", "distractor") for i in range(4)]
    env.shutdown()


def test_things_fit_and_keep_their_distance(blocks: list[Shape]) -> None:
    """Every block lies in one of the patches, at its height, 10 cm from the others; larger patches get more."""
    np.random.seed(0)
    patches = [Shape(f"patch{i}") for i in range(4)]
    spawns = SpawnBoundary(patches)
    heights = [block.get_position()[2] for block in blocks]
    for _ in range(3):
        spawns.clear()
        for block in blocks:
            spawns.sample(block, min_distance=0.1)
        places = np.array([block.get_position() for block in blocks])
        gaps = np.linalg.norm(places[:, None] - places[None], axis=-1) + np.eye(8)
        assert gaps.min() >= 0.1 and places[:, 2] == pytest.approx(heights)
        for block in blocks:
            inside = [np.abs(block.get_position(relative_to=p)[:2]) <= np.array(p.get_bounding_box())[[1, 3]] for p in patches]
            assert any(each.all() for each in inside)


def test_rotation_bounds_and_points(blocks: list[Shape]) -> None:
    """No rotation is no rotation; a dummy needs no space; `ignore_collisions` puts one on another."""
    patch = SpawnBoundary([Shape("patch0")])
    before = blocks[0].get_quaternion()
    patch.sample(blocks[0], min_rotation=(0, 0, 0), max_rotation=(0, 0, 0))
    assert np.abs(np.dot(before, blocks[0].get_quaternion())) == pytest.approx(1.0)
    place = blocks[0].get_position()
    dummy = Dummy.create()
    patch.sample(dummy)
    assert np.abs(dummy.get_position(relative_to=Shape("patch0"))[:2]).max() <= 0.15
    boundary = BoundaryObject(Shape("patch0"))
    assert boundary.get_area() == pytest.approx(0.15 * 0.3)
    assert boundary.add(blocks[0]) == 1
    answers = {boundary.add(blocks[1], min_distance=0.5) for _ in range(20)}
    assert answers <= {-2, -3} and boundary.add(blocks[1], ignore_collisions=True) == 1
    boundary.clear()
    assert boundary.contained_objects == [] and not np.array_equal(place, blocks[0].get_position())
    dummy.remove()


def test_refusals(blocks: list[Shape]) -> None:
    """What does not fit and what finds no free place says why; no boundary at all is a mistake."""
    with pytest.raises(BoundaryError, match="100 times it did not fit"):
        SpawnBoundary([Shape("patch0")]).sample(Shape("patch2"))
    crowded = SpawnBoundary([Shape("patch0")])
    crowded.sample(blocks[0])
    with pytest.raises(BoundaryError, match="within 0.5 m"):
        crowded.sample(blocks[1], min_distance=0.5)
    with pytest.raises(TaskError, match="at least one boundary"):
        SpawnBoundary([])


def test_programs_replace_where_things_go(blocks: list[Shape], monkeypatch: pytest.MonkeyPatch) -> None:
    """A replaced `_get_position_within_boundary` decides the place, given the turned box."""
    seen: list[Any] = []

    def middle(self: BoundaryObject, obj: Shape, obj_bbox: BoundingBox) -> list[float]:
        seen.append((obj.get_name(), obj_bbox.max_x))
        return [0.0, 0.01, obj.get_position(relative_to=self._boundary)[2]]

    monkeypatch.setattr(BoundaryObject, "_get_position_within_boundary", middle)
    SpawnBoundary([Shape("patch1")]).sample(blocks[2], min_rotation=(0, 0, 0.785), max_rotation=(0, 0, 0.785))
    assert blocks[2].get_position(relative_to=Shape("patch1"))[:2] == pytest.approx([0.0, 0.01])
    assert seen[0][0] == "block2" and 0.024 < seen[0][1] < 0.036


def test_boxes() -> None:
    """Inside and outside, on planes and in volumes; turned boxes grow."""
    small, large = BoundingBox(-1, 1, -1, 1, -1, 1), BoundingBox(-2, 2, -2, 2, 0, 0)
    assert small.within_boundary(large, True) and not small.within_boundary(large, False)
    turned = BoundingBox(-1, 1, -1, 1, 0, 0).rotate([0, 0, np.pi / 4])
    assert turned.max_x == pytest.approx(np.sqrt(2.0)) and turned.min_y == pytest.approx(-np.sqrt(2.0))
    assert not BoundingBox(-1.5, 1.5, -1.5, 1.5, 0, 0).rotate([0, 0, np.pi / 4]).within_boundary(large, True)
    assert BoundingBox(0, 1, 0, 2, 0, 3).rotate([0.0, 0.0, 0.0, 1.0]).max_z == pytest.approx(3.0)
