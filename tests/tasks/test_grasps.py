"""Grasps from above and free directions."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from rlbench_pin.errors import BoundaryError
from rlbench_pin.tasks import Tray, easiest_top_grasp, free_direction
from rlbench_pin.tasks.boxes import OrientedBox
from tests.tasks.stand_ins import FakeBody

TRAY = Tray(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), np.array([0.165, 0.135]))


@dataclass
class Block(FakeBody):
    """A box that says its extent along any axes."""

    box: tuple[float, float, float] = field(default=(0.05, 0.03, 0.04))

    def extent_along(self, directions: np.ndarray) -> np.ndarray:
        """How far it reaches along directions of the world, from its origin."""
        heights = OrientedBox.of(self.bounds(), self.pose).corners() @ directions.T
        return np.stack([heights.min(axis=0), heights.max(axis=0)])


def at(x: float, y: float, **more: object) -> Block:
    """A block in the tray."""
    return Block(pose=np.array([x, y, 0.02, 0.0, 0.0, 0.0, 1.0]), **more)  # type: ignore[arg-type]


def test_a_block_alone_is_gripped_in_its_middle_across_its_narrow_side() -> None:
    """The gripper points down at its height, or at another one that is asked for."""
    block = at(0.02, 0.01)
    grasp = easiest_top_grasp([block], [block], TRAY)
    np.testing.assert_allclose(grasp.position, block.position, atol=1e-9)
    assert grasp.cost == pytest.approx(0.03)
    assert grasp.angle == 0.0
    np.testing.assert_allclose(grasp.tip_pose(), [0.02, 0.01, 0.02, 0.0, 1.0, 0.0, 0.0], atol=1e-9)
    assert grasp.tip_pose(0.3)[2] == 0.3


def test_fingers_keep_out_of_walls_and_of_other_bodies() -> None:
    """At a wall the gripper turns; the body that lies free is taken first."""
    at_wall = at(0.0, 0.115, name="at_wall")
    assert easiest_top_grasp([at_wall], [at_wall], TRAY).angle != 0.0
    free = at(0.0, -0.05, name="free")
    grasp = easiest_top_grasp([at_wall, free], [at_wall, free], TRAY)
    np.testing.assert_allclose(grasp.position, free.position, atol=1e-9)
    beside = at(0.0, -0.005, name="beside")
    assert easiest_top_grasp([free], [free, beside], TRAY).cost > grasp.cost


def test_only_wanted_bodies_are_gripped_and_nothing_wanted_is_an_error() -> None:
    """The easier one is left alone when it is not wanted."""
    wide, narrow = at(-0.08, 0.0, name="wide", box=(0.06, 0.05, 0.04)), at(0.08, 0.0, name="narrow")
    assert easiest_top_grasp([wide], [wide, narrow], TRAY).position[0] == pytest.approx(-0.08)
    with pytest.raises(BoundaryError, match="no body to grasp"):
        easiest_top_grasp([], [wide], TRAY)


def test_the_first_direction_without_anything_in_its_lane_is_taken() -> None:
    """What stands behind the place, beside the lane or farther off does not count; a place is not in its own way."""
    place = np.array([0.5, 0.0])
    directions = (0.0, np.pi / 2.0)
    assert free_direction(place, directions, [place], 0.1, 0.3) == 0.0
    assert free_direction(place, directions, [np.array([0.3, 0.05])], 0.1, 0.3) == pytest.approx(np.pi / 2.0)
    harmless = [np.array([0.7, 0.0]), np.array([0.3, 0.11]), np.array([0.1, 0.0])]
    assert free_direction(place, directions, harmless, 0.1, 0.3) == 0.0
    assert free_direction(place, (0.0,), [np.array([0.3, 0.05])], 0.1, 0.3) is None
