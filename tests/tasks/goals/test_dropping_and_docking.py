"""Objects that are dropped through, laid into or drawn out of what has their shape."""

from __future__ import annotations

import numpy as np

from tests.tasks.goals.goal import Goal, goal_of


@goal_of("basketball_in_hoop")
def test_the_ball_has_to_fall_through_the_ring(goal: Goal) -> None:
    """From above and let go; from below, held in the ring or beside it does not count."""

    def shoot(start: float, end: float, x: float = 0.0) -> None:
        """Bring the ball from one height to another, at a distance from the axis of the ring [m]."""
        goal.task.reset_conditions()
        goal.put("ball", (x, 0.0, start), on="hoop")
        assert not goal.reached()
        goal.put("ball", (x, 0.0, end), on="hoop")

    goal.border(lambda end: shoot(0.36, end), inside=0.325, outside=0.332)
    goal.border(lambda end: shoot(0.36, end), inside=0.225, outside=0.222)
    goal.border(lambda start: shoot(start, 0.25), inside=0.379, outside=0.381)
    for side in (-1.0, 1.0):
        goal.border(lambda x, s=side: shoot(0.34, 0.27, s * x), inside=0.049, outside=0.051)
    shoot(0.15, 0.27)
    assert not goal.reached()
    shoot(0.34, 0.27)
    assert goal.reached()
    goal.put("ball", (0.05, 0.0, 0.0325), on="hoop")
    assert goal.reached(), "forgotten when the ball rolls away"
    shoot(0.36, 0.34)
    assert goal.task.gripper.grasp("ball")
    goal.put("ball", (0.0, 0.0, 0.3), on="hoop")
    assert not goal.reached()
    goal.task.gripper.release()
    assert goal.reached()


@goal_of("phone_on_base")
def test_the_contacts_of_the_handset_have_to_lie_in_the_cradle(goal: Goal) -> None:
    """Let go, at the lower end; the wrong way round, on its keys, higher up or beside the trough does not count."""
    docked, slope = np.array((0.01838, 0.0, 0.056)), (0.0, -0.42, 0.0)
    goal.ends("handset", docked, slope, on="base", within=3e-4, x=(-0.01095, 0.00245), y=(-0.01, 0.01), z=(-0.0011, 0.00986))
    goal.needs_release_of("handset")
    up = np.array((np.cos(0.42), 0.0, np.sin(0.42)))
    goal.border(lambda way: goal.put("handset", docked + way * up, slope, on="base"), inside=0.019, outside=0.021)
    goal.border(lambda roll: goal.put("handset", docked, (roll, *slope[1:]), on="base"), inside=1.0, outside=1.1)
    for place, rpy in (
        (docked, (0.0, 0.42, np.pi)),
        (docked, (np.pi, -0.42, 0.0)),
        ((0.0, 0.02, 0.08), slope),
        ((0.0, 0.0, 0.0775), (0.0, 0.0, 0.0)),
        ((-0.14, 0.0, 0.0125), (0.0, 0.0, 0.0)),
    ):
        goal.put("handset", place, rpy, on="base")
        assert not goal.reached()


@goal_of("solve_puzzle")
def test_the_piece_has_to_lie_in_the_gap_with_its_picture_upright(goal: Goal) -> None:
    """On the floor of the gap, let go; turned, face down, askew, on top of the others or beside the tray does not count."""
    gap = (0.02, 0.02, 0.003)
    goal.ends("piece", gap, on="tray", x=(-0.0075, 0.0075), y=(-0.0075, 0.0075), z=(0.003,))
    goal.needs_release_of("piece")
    goal.border(lambda yaw: goal.put("piece", gap, (0.0, 0.0, yaw), on="tray"), inside=0.4, outside=0.6)
    for rpy in ((0.0, 0.0, np.pi / 2.0), (0.0, 0.0, np.pi), (0.0, 0.0, -np.pi / 2.0), (np.pi, 0.0, 0.0)):
        goal.put("piece", (*gap[:2], 0.042 if rpy[0] else 0.003), rpy, on="tray")
        assert not goal.reached()
    for place, rpy in (
        ((0.02, 0.02, 0.018), (0.0, 0.0, 0.0)),
        ((0.02, 0.02, 0.01), (0.0, 0.25, 0.0)),
        ((-0.15, 0.0, 0.0), (0.0, 0.0, 0.0)),
    ):
        goal.put("piece", place, rpy, on="tray")
        assert not goal.reached()


@goal_of("put_umbrella_in_umbrella_stand")
def test_the_tip_of_the_umbrella_has_to_be_at_the_bottom_of_the_stand(goal: Goal) -> None:
    """Let go; half-way in, on its handle, across the rim or beside the stand does not count, leaning does."""
    stands = (0.0, 0.0, 0.007)
    goal.ends("umbrella", stands, on="stand", x=(-0.055, 0.055), y=(-0.055, 0.055), z=(0.034,))
    goal.needs_release_of("umbrella")
    for lean in (-0.35, 0.35):
        goal.put("umbrella", (-np.sign(lean) * 0.03, 0.0, 0.008), (0.0, lean, 0.0), on="stand")
        assert goal.reached()
    for place, rpy in (
        ((0.0, 0.0, 0.1), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.35), (np.pi, 0.0, 0.0)),
        ((-0.17, 0.0, 0.196), (0.0, np.pi / 2.0, 0.0)),
        ((0.08, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((-0.3, 0.0, 0.015), (0.0, np.pi / 2.0, 0.0)),
    ):
        goal.put("umbrella", place, rpy, on="stand")
        assert not goal.reached()


@goal_of("take_umbrella_out_of_umbrella_stand")
def test_the_whole_umbrella_has_to_be_out_of_the_stand(goal: Goal) -> None:
    """Its tip above the rim, or anywhere outside; half-way out or leaning in it does not count."""
    goal.border(lambda tip: goal.put("umbrella", (0.0, 0.0, tip), on="stand"), inside=0.181, outside=0.179)
    for place, rpy in (
        ((0.0, 0.0, 0.1), (0.0, 0.0, 0.0)),
        ((0.045, 0.0, 0.008), (0.0, -0.4, 0.0)),
        ((0.0, 0.0, 0.35), (np.pi, 0.0, 0.0)),
    ):
        goal.put("umbrella", place, rpy, on="stand")
        assert not goal.reached()
    for place, rpy in (
        ((0.12, 0.0, 0.015), (0.0, np.pi / 2.0, 0.0)),
        ((0.08, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.2), (0.0, 0.3, 0.0)),
    ):
        goal.put("umbrella", place, rpy, on="stand")
        assert goal.reached()
    goal.counts_while_held("umbrella")
