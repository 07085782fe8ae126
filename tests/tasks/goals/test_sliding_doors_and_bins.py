"""A cabinet with sliding doors, a tree that mugs hang on, and two bins."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from rlbench_pin.tasks import BodySpec
from tests.tasks.goals.goal import Goal, goal_of
from tests.tasks.running import begin, running

LYING, UPSIDE_DOWN = (0.0, np.pi / 2.0, 0.0), (np.pi, 0.0, 0.0)
CUP, FLOOR = 0.09, 0.055
"""Height of the cup, and of the floor of the cabinet [m]."""


def side_of(goal: Goal) -> tuple[str, str, float]:
    """Return the side that the first instruction names, the other one, and the sign of y where the asked one is."""
    asked = ("left", "right")[goal.asked(("left", "right"))]
    return (asked, "right", 1.0) if asked == "left" else (asked, "left", -1.0)


@goal_of("slide_cabinet_open", 0, 1)
def test_the_asked_door_has_to_slide(goal: Goal) -> None:
    """By 6 cm; the grasp goes to its handle, the other door does not count, pushed back is undone, and nothing is held."""
    side, other, sign = side_of(goal)
    np.testing.assert_allclose(goal.task.get_waypoints()[1].pose, goal.place_of(f"{side}_handle"), atol=1e-9)
    assert sign * goal.place_of(f"{side}_handle")[1] > 0.2
    goal.joint(f"cabinet/{other}_door", 0.2)
    assert not goal.reached()
    goal.border(lambda way: goal.joint(f"cabinet/{side}_door", way), inside=0.0605, outside=0.0595)
    goal.world.add_body("held", BodySpec(name="held", asset="objects/cube_small/cube_small.urdf"))
    goal.needs_release_of("held")


@pytest.mark.parametrize("name", ["slide_cabinet_open", "slide_cabinet_open_and_place_cups", "take_cup_out_from_cabinet"])
def test_the_frames_at_the_handles_are_on_the_bars(name: str) -> None:
    """Both bars lie 12.45 cm out of the middle of their doors, 5.75 cm before it."""
    with running(name) as task:
        for side, y in (("left", 0.1245), ("right", -0.1245)):
            link, bar = task.world.placement(f"cabinet/{side}_link"), task.world.placement(f"{side}_handle")
            np.testing.assert_allclose(link.actInv(bar).translation, [-0.0575, y, 0.0], atol=1e-6)


@goal_of("slide_cabinet_open_and_place_cups", 0, 1)
def test_the_cup_has_to_stand_behind_the_asked_door(goal: Goal) -> None:
    """Upright on the floor, let go, its door open by 6 cm: not on the other side, in the rail, on top, in the air or tilted."""
    side, other, sign = side_of(goal)
    place = (-0.053, sign * 0.1725, FLOOR)
    goal.joint(f"cabinet/{side}_door", 0.24)
    outside = [(-0.053, -sign * 0.1725, FLOOR), (-0.112, sign * 0.1725, FLOOR), (0.0, sign * 0.1725, 0.31), (-0.3, 0.0, 0.0)]
    for there in [*outside, (*place[:2], FLOOR + 0.015)]:
        goal.put("cup", there, on="cabinet")
        assert not goal.reached()
    for rpy, up in ((LYING, 0.0325), (UPSIDE_DOWN, CUP), ((0.4, 0.0, 0.0), 0.012)):
        goal.put("cup", (*place[:2], FLOOR + up), rpy, on="cabinet")
        assert not goal.reached()
    goal.ends("cup", place, on="cabinet", x=(-0.022,), z=(0.01,))
    goal.border(lambda way: goal.joint(f"cabinet/{side}_door", way), inside=0.0605, outside=0.0595)
    goal.joint(f"cabinet/{side}_door", 0.0)
    goal.joint(f"cabinet/{other}_door", 0.24)
    assert not goal.reached()
    goal.joint(f"cabinet/{side}_door", 0.24)
    goal.needs_release_of("cup")


@goal_of("take_cup_out_from_cabinet", 0, 1)
def test_the_cup_has_to_stand_on_the_table(goal: Goal) -> None:
    """Let go: not in either half, on top, in the air, lying, upside down or tilted; an open door alone is nothing."""
    side, _, sign = side_of(goal)
    assert sign * goal.world.body("cup").position[1] == pytest.approx(0.1725)
    goal.joint(f"cabinet/{side}_door", 0.24)
    for there in ((-0.053, -sign * 0.1725, FLOOR), (0.0, 0.0, 0.31), (-0.112, sign * 0.1725, FLOOR), (-0.3, 0.0, 0.02)):
        assert not goal.reached()
        goal.put("cup", there)
    for rpy, up in ((LYING, 0.0325), (UPSIDE_DOWN, CUP), ((0.4, 0.0, 0.0), 0.012)):
        goal.put("cup", (-0.3, 0.0, up), rpy)
        assert not goal.reached()
    goal.ends("cup", (-0.3, 0.0, 0.0), z=(0.01,), x=(0.1386,))
    goal.needs_release_of("cup")


@goal_of("remove_cups", 0, 1)
def test_as_many_mugs_as_asked_have_to_stand_on_the_table(goal: Goal) -> None:
    """Whichever, carried there, upright and let go; one fewer does not count, nor one that fell, lies, or is on the foot."""
    count = 1 + goal.asked(("one", "two"))
    hung = [goal.world.body(f"mug{i}").pose for i in range(3)]
    for mugs in combinations(range(3), count):
        for k, mug in enumerate(mugs):
            for height, held in ((0.0, False), (0.04, True), (0.02, True)):  # knocked off, dropped, set down
                goal.put(f"mug{mug}", (-0.15, 0.12 * k, height))
                assert not held or goal.task.gripper.grasp(f"mug{mug}")
                assert not goal.reached()
                goal.task.gripper.release()
            goal.put(f"mug{mug}", (-0.15, 0.12 * k, 0.0))
        last = f"mug{mugs[-1]}"
        goal.needs_release_of(last)
        for rpy, up in ((LYING, 0.0325), (UPSIDE_DOWN, 0.08), ((0.4, 0.0, 0.0), 0.012)):
            goal.put(last, (-0.15, 0.12 * (count - 1), up), rpy)
            assert not goal.reached()
        goal.put(last, (0.08, 0.03, 0.016))
        assert not goal.reached()
        goal.ends(last, (-0.15, 0.12 * (count - 1), 0.0), z=(0.01,))
        for mug in mugs:
            goal.world.body(f"mug{mug}").set_pose(hung[mug])
        goal.task.reset_conditions()


def test_mugs_rest_where_they_hang() -> None:
    """They move by less than 1 mm in 2 s: hung by hand, they neither slide to the stem nor swing."""
    with running("remove_cups") as task:
        begin(task)
        before = [task.world.body(f"mug{i}").position for i in range(3)]
        for _ in range(40):
            task.world.step()
        after = [task.world.body(f"mug{i}").position for i in range(3)]
    assert np.linalg.norm(np.subtract(before, after), axis=1).max() < 1e-3


def test_the_paper_and_the_bins_change_places() -> None:
    """The paper lies in each of three places about equally often, and each bin on either side."""
    with running("put_rubbish_in_color_bin") as task:
        clean, papers, bins = task.world.save(), [], []
        for seed in range(60):
            task.world.restore(clean)
            begin(task, seed=seed)
            middle = task.world.root.position[0]
            papers.append(round(float(task.rubbish.position[0] - middle), 3))
            bins.append(float(np.sign(task.world.body("green_bin").position[0] - middle)))
    assert sorted(set(papers)) == [-0.1, 0.0, 0.1]
    assert min(papers.count(x) for x in set(papers)) >= 10
    assert min(bins.count(side) for side in (-1.0, 1.0)) >= 20


@goal_of("put_rubbish_in_color_bin", 0, 1)
def test_the_paper_has_to_lie_in_the_bin_of_the_asked_color(goal: Goal) -> None:
    """At its bottom, let go: the other bin, the rim, a place above or beside it, or a tomato in the bin do not count."""
    colors = ("green", "blue")
    asked = f"{colors[goal.asked(colors)]}_bin"
    other = next(f"{color}_bin" for color in colors if color not in asked)
    np.testing.assert_allclose(goal.task.get_waypoints()[3].pose[:2], goal.place_of(asked)[:2], atol=1e-9)
    goal.put("tomato0", (0.0, 0.0, 0.04), on=asked)
    for place in ((0.0, 0.0, 0.2), (0.08, 0.0, 0.202), (0.0, -0.106, 0.022)):
        goal.put("rubbish", place, on=asked)
        assert not goal.reached()
    goal.put("rubbish", (0.0, 0.0, 0.04), on=other)
    assert not goal.reached()
    goal.ends("rubbish", (0.0, 0.0, 0.04), on=asked, z=(0.047,))
    goal.needs_release_of("rubbish")
