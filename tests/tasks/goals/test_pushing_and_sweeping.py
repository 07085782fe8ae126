"""Things that are pushed, struck, swept, wiped or pulled straight along the table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from rlbench_pin.spatial import relative
from tests.tasks.goals.goal import Goal, goal_of


@goal_of("slide_block_to_target")
def test_the_block_has_to_reach_the_middle_of_the_square(goal: Goal) -> None:
    """Its side within 2 cm of it, on the table; touching the square is not enough."""
    goal.ends("block", (0.0, 0.0, 0.03), on="square", x=(-0.05, 0.05), y=(-0.05, 0.05), z=(0.03,))
    block, square = goal.task.block.position, goal.task.square.position
    tip = np.linalg.norm(goal.task.robot.tip_pose()[:3] - block)
    assert goal.task.reward() == pytest.approx(-tip - np.linalg.norm(block - square))


@goal_of("hockey")
def test_the_ball_has_to_lie_behind_the_line_while_the_stick_is_held(goal: Goal) -> None:
    """Its middle 2.5 mm behind it at least; beside, behind or on the goal, or with the stick let go, it does not count."""
    goal.put("ball", (0.0, 0.045, 0.0175), on="goal")
    assert not goal.reached()
    assert goal.task.gripper.grasp("stick")
    goal.ends("ball", (0.0, 0.045, 0.0175), on="goal", x=(-0.0775, 0.0775), y=(-0.0425, 0.0425), z=(0.065,))
    for place in ((0.092, 0.045, 0.0175), (-0.092, 0.045, 0.0175), (0.0, 0.102, 0.0175), (0.0, 0.045, 0.112)):
        goal.put("ball", place, on="goal")
        assert not goal.reached()


@goal_of("sweep_to_dustpan")
def test_all_five_crumbs_have_to_lie_in_the_pan(goal: Goal) -> None:
    """Each of them; not over, beside or behind it."""
    for i in range(5):
        goal.put(f"crumb{i}", (0.0, 0.03 * (i - 2), 0.01), on="dustpan")
    for i in range(5):
        goal.ends(f"crumb{i}", (0.0, 0.0, 0.01), on="dustpan", x=(-0.056, 0.056), y=(-0.091, 0.091), z=(0.025,))
        goal.put(f"crumb{i}", (0.02, 0.0, 0.006))
        assert not goal.reached()
        goal.put(f"crumb{i}", (0.0, 0.0, 0.01), on="dustpan")


def wipe(goal: Goal, stain: str, offset: Sequence[float] = (0.0, 0.0, 0.0), roll: float = 0.0) -> bool:
    """Hold the sponge at an offset from where it lies on a stain [m]; say whether that is wiped away."""
    x, y, _ = goal.world.body(stain).position - goal.world.root.position
    goal.put("sponge", np.array([x, y, 0.0175]) + offset, (roll, 0.0, 0.0))
    goal.tick()
    return stain not in goal.world.bodies


@goal_of("wipe_desk")
def test_every_stain_has_to_be_wiped(goal: Goal) -> None:
    """The goal is reached with the last of the fifty, in whatever order."""
    assert len(goal.task.stains) == 50
    while goal.task.stains:
        assert not goal.reached()
        assert wipe(goal, goal.task.stains[-1])
    assert goal.reached()


@goal_of("wipe_desk")
def test_the_sponge_wipes_what_is_under_it(goal: Goal) -> None:
    """Less than 1.5 cm over the table, the edge of a stain within 5 cm along and 3.25 cm across; not on its edge."""
    for stain in goal.task.stains[1:]:
        goal.world.remove_body(stain)
    stain = goal.task.stains[0]
    goal.task.stains[:] = [stain]
    for offset in ((0.0, 0.0, 0.0155), (0.0565, 0.0, 0.0), (-0.0565, 0.0, 0.0), (0.0, 0.039, 0.0), (0.0, -0.039, 0.0)):
        assert not wipe(goal, stain, offset), offset
        assert not goal.reached()
    assert not wipe(goal, stain, (0.0, 0.0, 0.01), roll=np.pi / 2.0)
    assert wipe(goal, stain, (0.0555, 0.0, 0.0145))
    assert goal.reached()


@goal_of("straighten_rope")
def test_both_ends_of_the_rope_have_to_lie_on_their_marks(goal: Goal) -> None:
    """Straight between them; shifted, raised, turned round, bent, or with one end alone it does not count."""
    bent = [goal.world.joint(f"rope/joint{i}") for i in range(1, 18)]
    for joint in bent:
        joint.set_position(0.0)
    length = relative(goal.place_of("tail"), goal.place_of("head"))[0]
    place = np.array([-0.011 - length / 2.0, 0.06, 0.007])
    goal.ends("rope", place, x=(-0.018, 0.018), y=(-0.025, 0.025), z=(0.013,))
    goal.put("rope", place * [-1.0, 1.0, 1.0], (0.0, 0.0, np.pi))
    assert not goal.reached()
    goal.put("rope", place)
    goal.border(lambda angle: bent[7].set_position(angle), inside=0.118, outside=0.122)
    bent[7].set_position(0.5)
    assert not goal.reached()
