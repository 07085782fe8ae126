"""Things that are put into, onto, beside or out of something."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.tasks import COLORS
from tests.tasks.goals.goal import Goal, goal_of
from tests.tasks.running import begin, colors, running


def test_rubbish_stands_in_any_of_three_places() -> None:
    """Each about equally often; the tomatoes take the others."""
    with running("put_rubbish_in_bin") as task:
        clean, counts = task.world.save(), {}
        for seed in range(60):
            task.world.restore(clean)
            begin(task, seed=seed)
            x = round(float(task.rubbish.position[0]), 3)
            counts[x] = counts.get(x, 0) + 1
            assert len({round(float(b.position[0]), 3) for b in (task.rubbish, *task.tomatoes)}) == 3
        assert len(counts) == 3
        assert min(counts.values()) >= 10


@goal_of("put_rubbish_in_bin")
def test_the_paper_has_to_lie_at_the_bottom_of_the_bin(goal: Goal) -> None:
    """A tomato in the bin does not count, nor does paper on the rim, above or beside it."""
    goal.put("tomato0", (0.0, 0.0, 0.04), on="bin")
    for place in ((0.0, 0.0, 0.2), (0.08, 0.0, 0.202), (0.106, 0.0, 0.022), (0.0, -0.106, 0.022)):
        goal.put("rubbish", place, on="bin")
        assert not goal.reached()
    goal.ends("rubbish", (0.0, 0.0, 0.04), on="bin", z=(0.047,))
    goal.counts_while_held("rubbish")


@goal_of("meat_off_grill", 0, 1)
def test_the_asked_meat_has_to_lie_beside_the_grill(goal: Goal) -> None:
    """By either long side: the grasp goes to it at the same height, only it counts, let go, less than 5 cm over the table."""
    meats = goal.task.meats
    meat, other = meats if goal.says(meats[0]) else meats[::-1]
    grasp = goal.task.get_waypoints()[1].pose
    np.testing.assert_allclose(grasp[:2], goal.world.body(meat).position[:2], atol=1e-9)
    with running("meat_off_grill") as task:
        assert grasp[2] == pytest.approx(task.world.frame("waypoint1").position[2])
    goal.put(other, (0.0, -0.16, 0.02))
    assert not goal.reached()
    goal.put(other, (0.08, 0.12, 0.161))
    low, high = goal.world.body(meat).bounds()
    x, y = 0.1 + high[:2]
    goal.ends(meat, (0.0, -0.16, -low[2]), x=(-x, x), y=(-y, y), z=(0.05,))
    goal.needs_release_of(meat)
    goal.ends(meat, (0.0, 0.4, -low[2]), x=(-x, x), y=(-y, y), z=(0.05,))
    goal.needs_release_of(meat)


@goal_of("put_groceries_in_cupboard", 0, 4, 8)
def test_the_asked_item_has_to_be_on_the_lower_shelf(goal: Goal) -> None:
    """Let go, whichever way up; on the upper shelf, under the lower one or in front it does not count, nor does another item."""
    item = goal.task.items[goal.asked(goal.task.items)]
    other = next(name for name in goal.task.items if name != item)
    size = goal.world.body(item).bounds()[1]
    goal.put(other, (0.0, 0.0, 0.265), on="cupboard")
    for place in ((0.0, 0.0, 0.4075 + size[2]), (0.0, 0.0, size[2]), (-0.13 - size[0], 0.0, size[2])):
        goal.put(item, place, on="cupboard")
        assert not goal.reached()
    (x, y), front = np.array([0.0975, 0.19]) + size[:2], -0.0075
    goal.ends(item, (front, 0.0, 0.265), on="cupboard", x=(-x, x), y=(-y, y), z=(-0.08 - size[2], 0.107 + size[2]))
    for rpy in ((np.pi / 2.0, 0.0, 0.0), (0.0, np.pi / 2.0, 0.0), (np.pi, 0.0, 0.0)):
        goal.put(item, (front, 0.0, 0.165 + size.max()), rpy, on="cupboard")
        assert goal.reached()
    goal.needs_release_of(item)


@goal_of("empty_container", 0, 9, 19)
def test_all_three_things_have_to_lie_in_the_asked_tray(goal: Goal) -> None:
    """Each of them, inside its walls and not above; the other tray does not count."""
    asked = next(n for n in ("tray0", "tray1") if goal.world.body(n).color[:3] == asked_color(goal))
    names, other = ("object0", "object1", "object2"), {"tray0": "tray1", "tray1": "tray0"}[asked]
    for tray in (other, asked):
        assert not goal.reached()
        for name in names:
            goal.put(name, (0.0, 0.0, 0.03), on=tray)
        goal.tick()
        assert goal.task.left == ([] if tray == asked else list(names))
    for name in names:
        low, high = goal.world.body(name).bounds()
        goal.ends(name, (0.0, 0.0, 0.03), on=asked, x=(low[0] - 0.07, 0.07 + high[0]), z=(0.005 - low[2],))
        goal.put(name, (0.0, 0.0, 0.03), on="big_tray")
        assert not goal.reached()
        goal.put(name, (0.0, 0.0, 0.03), on=asked)
    goal.counts_while_held(names[-1])


def asked_color(goal: Goal) -> tuple[float, ...]:
    """Return the colour that the instructions name."""
    return COLORS[goal.asked([color.name for color in COLORS])].rgb


@goal_of("weighing_scales", 0, 1, 2)
def test_the_asked_pepper_has_to_be_weighed(goal: Goal) -> None:
    """Let go on the tray, the needle at the weight of one pepper: another pepper, none, or two at a time do not count."""
    asked = f"pepper_{goal.task.colors[goal.asked(goal.task.colors)]}"
    other = next(pepper.name for pepper in goal.task.peppers if pepper.name != asked)

    def load(sunk: float, name: str = asked) -> None:
        """Let the tray sink [m], with a pepper on it."""
        goal.joint("scales/tray", 0.004 + sunk)
        goal.put(name, (0.0, 0.0, 0.05), on="scales/tray_link")
        goal.tick()

    load(0.0083, other)
    assert not goal.reached()
    goal.put(other, (-0.15, 0.2, 0.035))
    for pushed in (0.0, 0.0165):
        load(pushed)
        assert not goal.reached()
    goal.border(load, inside=0.0063, outside=0.0061)
    goal.border(load, inside=0.0097, outside=0.0099)
    load(0.0083)
    assert goal.world.joint("scales/needle").position == pytest.approx(-0.996)
    goal.ends(asked, (0.0, 0.0, 0.05), on="scales/tray_link", x=(-0.108, 0.108), y=(-0.128, 0.128), z=(0.033,))
    goal.needs_release_of(asked)


@goal_of("empty_dishwasher")
def test_the_plate_has_to_be_out_of_the_rack(goal: Goal) -> None:
    """Wherever the rack is; pulled out with the rack it is not. Held in the air it counts."""
    upright = (np.pi / 2.0, 0.0, 0.0)
    place, on = (-0.053, 0.06, 0.0875), "dishwasher/rack_link"
    for rack in (0.24, 0.0):
        goal.joint("dishwasher/rack", rack)
        for axis, border in (("x", -0.207), ("y", -0.2175), ("y", 0.0975), ("z", 0.1125)):
            out, step = np.eye(3)["xyz".index(axis)], np.copysign(0.001, border)
            goal.border(lambda by, u=out: goal.put("plate", place + by * u, upright, on), border + step, border - step)
            goal.put("plate", place, upright, on)
            assert not goal.reached()
    goal.put("plate", (-0.053, 0.06, 0.21), upright, on)
    assert goal.task.gripper.grasp("plate")
    assert goal.reached()


@goal_of("pour_from_cup_to_cup", 0, 10, 19)
def test_all_drops_have_to_be_in_the_target_cup(goal: Goal) -> None:
    """Every one of the twenty, in its lower part; another cup, its outside or the table do not count."""
    source, target = (colors(goal.task, name)[0] for name in ("source", "target"))
    named = [color.rgb for color in COLORS if goal.says(color.name)]
    assert sorted(named) == sorted([source, target])
    for cup in ("distractor0", "target"):
        assert not goal.reached()
        for drop in goal.task.drops:
            goal.put(drop, (0.0, 0.0, 0.02), on=cup)
    assert len(goal.task.drops) == 20
    for drop in goal.task.drops:
        goal.put(drop, (0.045, 0.0, 0.005), on="target")
        assert not goal.reached(), drop
        goal.put(drop, (0.0, 0.0, 0.02), on="target")
    goal.ends(goal.task.drops[-1], (0.0, 0.0, 0.02), on="target", x=(-0.03, 0.03), y=(-0.03, 0.03), z=(0.04,))


DRAWERS = ("bottom", "middle", "top")


def outside_of(drawer: str) -> tuple[tuple[str, tuple[float, float, float]], ...]:
    """Return where a cube is near a drawer and not in it: in the others, above it, before it, on the table under it."""
    link = f"chest/drawer_{drawer}_link"
    others = [(f"chest/drawer_{name}_link", (0.068, 0.0, -0.014)) for name in DRAWERS if name != drawer]
    return (*others, (link, (0.068, 0.0, 0.06)), (link, (-0.03, 0.0, 0.0)), ("chest", (-0.25, 0.0, 0.02)))


@goal_of("put_item_in_drawer", 0, 1, 2)
def test_the_cube_has_to_lie_in_the_asked_drawer(goal: Goal) -> None:
    """Whether that is open or shut; in another drawer, over it, in front of it or on the chest does not count."""
    drawer = DRAWERS[goal.asked(DRAWERS)]
    for opened in (0.17, 0.0):
        for name in DRAWERS:
            goal.joint(f"chest/drawer_{name}", opened)
        assert not goal.reached()
        for on, place in outside_of(drawer):
            goal.put("cube", place, on=on)
            assert not goal.reached(), (on, place)
        place = (0.122, 0.0, -0.014)
        goal.ends("cube", place, on=f"chest/drawer_{drawer}_link", x=(-0.1, 0.1), y=(-0.14, 0.14), z=(0.03,))
        goal.counts_while_held("cube")
        goal.put("cube", (-0.08, 0.0, 0.38), on="chest")


@goal_of("put_items_in_drawer", 0, 1, 2, 4, 5)
def test_three_items_have_to_come_into_the_asked_drawer_in_their_order(goal: Goal) -> None:
    """One that comes too early has to come out again; all must be there at the end, and let go."""
    drawer = DRAWERS[goal.asked(DRAWERS)]
    first, second, last = goal.task.order
    assert goal.says(f"put_the_{first}_then_the_{second}_then_the_{last}_into")
    home = {name: goal.place_of(name) for name in goal.task.order}
    where = {name: (0.122, y, -0.008) for name, y in zip(goal.task.order, (-0.08, 0.0, 0.08), strict=True)}

    def take(*names: str) -> bool:
        for name in names:
            goal.put(name, where[name], on=f"chest/drawer_{drawer}_link")
            goal.task.success()  # as after every control tick
        return goal.reached()

    def take_back() -> None:
        for name, pose in home.items():
            goal.world.body(name).set_pose(pose)
        assert not goal.reached()
        goal.task.reset_conditions()

    for opened in (0.17, 0.0):
        for name in DRAWERS:
            goal.joint(f"chest/drawer_{name}", opened)
        for order in ((last, second, first), (first, last, second), (second, first, last), (first, second)):
            assert not take(*order), order
            take_back()
        assert take(first, second, last)
        goal.ends(last, where[last], on=f"chest/drawer_{drawer}_link", z=(0.028 if last == "star" else 0.024,))
        goal.needs_release_of(last)
        for on, place in outside_of(drawer):
            goal.put(second, place, on=on)
            assert not goal.reached(), (on, place)
        goal.put(second, where[second], on=f"chest/drawer_{drawer}_link")
        assert goal.reached()
        take_back()
    take(second)
    assert not take(first, last)
    goal.world.body(last).set_pose(home[last])
    goal.world.body(second).set_pose(home[second])
    assert not goal.reached()
    assert take(second, last)


@goal_of("take_item_out_of_drawer", 0, 1, 2)
def test_the_cube_has_to_lie_on_the_chest(goal: Goal) -> None:
    """It begins in the asked drawer; pulled out with it, beside the chest or high above the top it does not count."""
    drawer = DRAWERS[goal.asked(DRAWERS)]
    place = goal.place_of(f"inside_{drawer}")
    np.testing.assert_allclose(goal.world.body("cube").position, place[:3], atol=2e-3)
    goal.joint(f"chest/drawer_{drawer}", 0.2)
    for on, where in ((f"inside_{drawer}", (0.0, 0.0, 0.0)), ("chest", (-0.3, 0.0, 0.02)), ("chest", (-0.3, 0.0, 0.38))):
        goal.put("cube", where, on=on)
        assert not goal.reached(), where
    goal.ends("cube", (0.0, 0.0, 0.38), on="chest", x=(-0.13, 0.13), y=(-0.17, 0.17), z=(0.05,))
    goal.counts_while_held("cube")
