"""Whether the hand gets to each waypoint: free, touching something, out of reach, each with the reason."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from rlbench_pin.builder.contracts import TaskText, WaypointVerdict
from rlbench_pin.builder.worker.world import TaskWorld
from rlbench_pin.spatial import rotation_distance
from tests.builder.worker.conftest import Copied, Opened

_WALLS = "".join(
    f'\n[[body]]\nname = "wall{number}"\nasset = "objects/cube/cube.urdf"\nfixed = true\n'
    f'parent = "saucepan"\npose = [{x}, {y}, 0.27]\nscale = 2.0\n'
    for number, (x, y) in enumerate([(0.09, 0.0), (-0.09, 0.0), (0.0, 0.09), (0.0, -0.09)])
)


def _moved(text: TaskText, x: float) -> TaskText:
    return replace(text, scene=re.sub(r"(saucepan.urdf\"\nfixed = true)", rf"\1\npose = [{x}, 0.0, 0.0]", text.scene))


def _standings(verdicts: tuple[WaypointVerdict, ...]) -> list[str]:
    return [verdict.standing for verdict in verdicts]


def test_free_waypoints_have_a_configuration(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """The tip is at the pose there, which is turned about its own z where the hand is symmetric."""
    opened(copied("take_lid_off_saucepan"))
    verdicts = world.reach()
    assert _standings(verdicts) == ["free"] * 3
    for verdict in verdicts:
        assert verdict.configuration is not None
        tip = world.runtime.model.tip_pose(verdict.configuration)
        assert np.abs(tip[:3] - verdict.pose[:3]).max() < 1e-5
        assert rotation_distance(tip, verdict.pose) < 1e-4


def test_a_waypoint_out_of_reach_is_red(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """With the nearest pose, and how much is missing to it."""
    opened(_moved(copied("take_lid_off_saucepan"), 0.5))
    for verdict in world.reach():
        assert verdict.standing == "unreachable"
        assert verdict.configuration is None
        assert verdict.failure is not None
        assert verdict.failure.nearest is not None
        missing = float(np.linalg.norm(verdict.failure.nearest[:3] - verdict.pose[:3]))
        said = re.search(r"([\d.]+) cm too far", verdict.cause)
        assert said is not None
        assert float(said[1]) == pytest.approx(100.0 * missing, abs=0.5)
        assert 10.0 < 100.0 * missing < 40.0


def test_an_arm_that_touches_something_at_home_is_said(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """By the first waypoint, whose hand gets there all the same; a reset is refused for the same reason."""
    text = copied("take_lid_off_saucepan")
    block = (
        '\n[[body]]\nname = "block"\nasset = "objects/cube/cube.urdf"\nfixed = true\nparent = "world"\npose = [0.28, 0.0, 1.52]\n'
    )
    opened(replace(text, scene=text.scene + block))
    first, *others = world.reach()
    assert (first.standing, _standings(tuple(others))) == ("collides", ["free", "free"])
    assert "at home touches something already" in first.cause
    assert first.failure is not None
    assert any("block" in pair[1] for pair in first.failure.pairs)
    refused = world.reset(0, 0).failure
    assert refused is not None
    assert "arm at home touches block" in refused.cause


def test_a_waypoint_inside_things_is_amber(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """With the pairs that touch, a link of the arm and a body, and where the arm would be; so it is with a layout of a reset."""
    text = copied("take_lid_off_saucepan")
    task = opened(replace(text, scene=text.scene + _WALLS))
    assert task.problems == ()
    first, grasp, lift = world.reach()
    assert (first.standing, grasp.standing, lift.standing) == ("collides", "collides", "free")
    for verdict in (first, grasp):
        assert verdict.configuration is not None
        assert verdict.failure is not None
        assert any(thing.startswith("wall") for pair in verdict.failure.pairs for thing in pair)
        assert "touches something: panda_" in verdict.cause
    assert _standings(opened_reset(world)) == ["collides", "collides", "free"]


def opened_reset(world: TaskWorld) -> tuple[WaypointVerdict, ...]:
    """Lay out an episode and look again."""
    assert world.reset(1, 0).failure is None
    return world.reach()


def test_what_the_hand_has_held_is_not_in_its_way(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """After the lid was grasped the hand may come back to where it lay; otherwise the lid is in the way."""
    text = copied("take_lid_off_saucepan")
    back = '\n[[waypoint]]\nname = "waypoint3"\nparent = "lid"\npose = [0.0, 0.0, -0.06]\nrpy = [3.1415927, 0.0, 3.1415927]\n'
    opened(replace(text, scene=text.scene + back))
    assert world.reach()[3].standing == "free"
    above = text.scene.replace('parent = "lid"\nrpy', 'parent = "lid"\npose = [0.0, 0.0, 0.3]\nrpy')
    opened(replace(text, scene=above + back))
    assert world.reach()[3].standing == "collides"


@pytest.mark.parametrize("name", ["put_item_in_drawer", "open_door", "empty_dishwasher"])
def test_waypoints_of_the_library_are_free(copied: Copied, opened: Opened, world: TaskWorld, name: str) -> None:
    """Doors and drawers that were moved on the way are not in the way afterwards; what is planned leads to every one."""
    opened(copied(name))
    assert set(_standings(opened_reset(world))) == {"free"}
    paths = world.paths(lambda path: None)
    assert [path.cause for path in paths] == [""] * len(paths)
    for path, verdict in zip(paths, world.reach(), strict=True):
        assert path.waypoint == verdict.waypoint
        assert np.abs(path.points[-1] - verdict.pose[:3]).max() < 1e-3
    for before, after in zip(paths, paths[1:]):
        assert np.abs(before.points[-1] - after.points[0]).max() < 1e-3


def test_the_arm_follows_a_dragged_hand(copied: Copied, opened: Opened, world: TaskWorld) -> None:
    """Near poses are reached, far ones come as near as joint limits allow, and the arm never leaves them."""
    opened(copied("push_button"))
    home = np.array(world.runtime.model.home)
    tip = world.runtime.model.tip_pose(home)
    q, error = world.follow(tip + np.array([0.05, 0.03, -0.04, 0, 0, 0, 0]), home)
    assert error < 1e-3
    assert np.abs(world.runtime.model.tip_pose(q)[:3] - tip[:3] - [0.05, 0.03, -0.04]).max() < 1e-3
    far = tip + np.array([1.5, 0.0, 0.0, 0, 0, 0, 0])
    for _ in range(5):
        q, error = world.follow(far, q)
    assert 0.5 < error < 1.5
    assert world.runtime.model.limits.contains(q)
