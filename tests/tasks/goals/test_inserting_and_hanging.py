"""Things that have to go around, through, into or onto something of their shape."""

from __future__ import annotations

import numpy as np

from rlbench_pin.spatial import compose
from rlbench_pin.tasks import COLORS
from tests.tasks.goals.goal import Goal, goal_of
from tests.tasks.running import running

LIT = (1.0, 0.91, 0.66)


def asked(goal: Goal, names: tuple[str, ...]) -> str:
    """Return the body that shows the colour of the instructions."""
    rgb = COLORS[goal.asked([color.name for color in COLORS])].rgb
    return next(name for name in names if goal.world.body(name).color[:3] == rgb)


@goal_of("insert_onto_square_peg", 0, 10, 19)
def test_the_ring_has_to_lie_around_the_foot_of_the_asked_pillar(goal: Goal) -> None:
    """Any side in front, either face up; half-way down, beside it or around another pillar it does not count."""
    pillars = ("pillar0", "pillar1", "pillar2")
    pillar = asked(goal, pillars)
    for other in set(pillars) - {pillar}:
        goal.put("ring", (0.0, 0.0, 0.01), on=other)
        assert not goal.reached()
    for height in (0.1, 0.05):
        goal.put("ring", (0.0, 0.0, height), on=pillar)
        assert not goal.reached()
    for rpy in ((0.0, 0.0, np.pi / 2.0), (0.0, 0.0, np.pi), (np.pi, 0.0, 0.0), (0.0, 0.0, 0.0)):
        goal.ends("ring", (0.0, 0.0, 0.01), rpy, on=pillar, y=(-0.014, 0.014) if rpy[2] == 0.0 else (), z=(0.015,))
    goal.ends("ring", (0.0, 0.0, 0.01), on=pillar, x=(-0.014, 0.014))
    goal.border(lambda tilt: goal.put("ring", (0.0, 0.0, 0.01), (tilt, 0.0, 0.0), on=pillar), inside=0.59, outside=0.61)
    goal.counts_while_held("ring")


@goal_of("light_bulb_in", 0, 10, 19)
def test_the_asked_bulb_has_to_stand_in_the_socket(goal: Goal) -> None:
    """At its bottom, upright, let go; it glows while it stands there. The other bulb does not count."""
    holder = asked(goal, ("holder0", "holder1"))
    bulb, other = ("bulb0", "bulb1") if holder == "holder0" else ("bulb1", "bulb0")
    seat = (0.0, 0.0, 0.034 + 0.076)
    for name, place in ((other, seat), (bulb, (0.0, 0.0, 0.064 + 0.076))):
        goal.put(name, place, on="lamp")
        goal.tick()
        assert not goal.reached()
        assert LIT not in (color[:3] for body in goal.task.bulbs for color in body.colors.values())
    goal.put(other, (-0.09, 0.0, 0.082))
    goal.ends(bulb, seat, on="lamp", x=(-0.018, 0.018), y=(-0.018, 0.018), z=(0.0085,))
    goal.border(lambda tilt: goal.put(bulb, seat, (tilt, 0.0, 0.0), on="lamp"), inside=0.26, outside=0.27)
    goal.put(bulb, seat, on="lamp")
    goal.needs_release_of(bulb)
    goal.tick()
    assert LIT in (color[:3] for color in goal.world.body(bulb).colors.values())
    goal.task.cleanup()
    assert LIT not in (color[:3] for color in goal.world.body(bulb).colors.values())


@goal_of("place_shape_in_shape_sorter", 0, 2, 4)
def test_the_asked_shape_has_to_lie_in_the_sorter(goal: Goal) -> None:
    """On its floor: beside the box, on its lid or stuck in its hole it does not count, nor does another shape inside."""
    shapes = goal.task.shapes
    shape = shapes[goal.asked(goal.task.words)]
    low, high = goal.world.body(shape).bounds()
    for other in set(shapes) - {shape}:
        goal.put(other, (0.0, 0.0, 0.03), on="sorter")
        assert not goal.reached()
    places = [(0.0, 0.0, 0.099 - low[2]), (-0.0815 - high[0], 0.0, -low[2]), (0.0, 0.0815 - low[1], -low[2])]
    for place, on in (*((place, "sorter") for place in places), ((0.0, 0.0, 0.0), f"hole_{shape}")):
        goal.put(shape, place, on=on)
        assert not goal.reached()
    goal.ends(shape, (0.0, 0.0, 0.004 - low[2]), on="sorter", z=(0.03,))
    goal.put(shape, (0.03, -0.03, 0.004 + high[0]), (0.0, np.pi / 2.0, 0.0), on="sorter")
    goal.counts_while_held(shape)


@goal_of("plug_charger_in_power_supply")
def test_both_pins_have_to_reach_the_bottom_of_their_holes(goal: Goal) -> None:
    """Within 3.5 mm, let go; half-way in, tilted, one hole off or upside down does not count."""
    in_holes = (0.0085 - 0.0425, 0.0, 0.15)
    goal.ends("charger", in_holes, on="panel", within=2e-4, x=(-0.003, 0.003), y=(-0.003, 0.003), z=(-0.003, 0.003))
    goal.needs_release_of("charger")
    for turn in np.eye(3):
        goal.border(lambda angle, u=turn: goal.put("charger", in_holes, angle * u, on="panel"), inside=0.065, outside=0.31)
    goal.border(lambda yaw: goal.put("charger", in_holes, (0.0, 0.0, yaw), on="panel"), inside=0.068, outside=0.0695)
    for side in (-0.01, 0.01):  # one pin stays in its hole

        def roll(angle: float, y: float = side) -> None:
            """Turn the charger about a pin [rad]."""
            goal.put("charger", (in_holes[0], y - y * np.cos(angle), 0.15 - y * np.sin(angle)), (angle, 0.0, 0.0), on="panel")

        goal.border(roll, inside=0.14, outside=0.16)
    for place in ((-0.042, 0.0, 0.15), (in_holes[0], 0.02, 0.15), (in_holes[0], -0.02, 0.15)):
        goal.put("charger", place, on="panel")
        assert not goal.reached()


@goal_of("hang_frame_on_hanger")
def test_the_bar_of_the_frame_has_to_lie_on_the_hook(goal: Goal) -> None:
    """Its middle within 1 cm, let go; hung the wrong way round, below the hook or beside it does not count."""
    hung = (-0.0405, 0.0, 0.351)
    goal.ends("frame", hung, on="wall", x=(-0.01, 0.01), y=(-0.01, 0.01), z=(-0.01, 0.01))
    goal.needs_release_of("frame")
    for rpy in ((0.0, 0.0, np.pi), (np.pi, 0.0, 0.0)):
        goal.put("frame", hung, rpy, on="wall")
        assert not goal.reached()


HUNG = (0.0408, -0.0174, -0.0619, -0.2605, -0.3968, -0.7406, 0.4756)
"""A mug at rest by its handle on a spoke, in the axes of that, where a demonstration has left it."""


def hang(goal: Goal, mug: int, spoke: int, out: float = 0.0, up: float = 0.0) -> None:
    """Hang a mug on a spoke, farther out or higher by so much [m]."""
    pose = np.array(HUNG) + [out, 0.0, up, 0.0, 0.0, 0.0, 0.0]
    pose[3:] /= np.linalg.norm(pose[3:])
    goal.world.body(f"mug{mug}").set_pose(compose(goal.place_of(f"spoke{spoke}"), pose))


@goal_of("place_cups", 0, 1, 2)
def test_as_many_mugs_as_asked_have_to_hang(goal: Goal) -> None:
    """Whichever mugs on whichever spokes, let go; one fewer does not count, nor does one that is off the spoke."""
    count = 1 + goal.asked(("one", "two", "three"))
    beside = [goal.world.body(f"mug{i}").pose for i in range(3)]
    for start in range(3):
        mugs = [(start + k) % 3 for k in range(count)]
        for k, mug in enumerate(mugs):
            assert not goal.reached()
            hang(goal, mug, spoke=(2 * start + k) % 4)
        goal.needs_release_of(f"mug{mugs[-1]}")
        spoke = (2 * start + count - 1) % 4
        goal.border(lambda out, m=mugs[-1], s=spoke: hang(goal, m, s, out=out), inside=0.0204, outside=0.0224)
        goal.border(lambda up, m=mugs[-1], s=spoke: hang(goal, m, s, up=up), inside=-0.02, outside=-0.022)
        for mug in mugs:
            goal.world.body(f"mug{mug}").set_pose(beside[mug])


def test_only_the_frame_shows_a_picture() -> None:
    """The wall has none of its colours: only the frame shows an image."""
    with running("hang_frame_on_hanger") as task:
        frame, wall = (
            {color for visuals in task.world.body(name).mixed_colors.values() for color in visuals} for name in ("frame", "wall")
        )
    assert not frame & wall and len(frame) > 4
