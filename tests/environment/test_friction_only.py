"""With `attach_grasped_objects=False` friction alone holds, in demonstrations as in actions, and conditions mean the fingers."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment import Discrete, Environment, JointPosition, MoveArmThenGripper
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.spatial import relative, rotation_distance

pytestmark = pytest.mark.simulation


def friction_only(by_mode: bool = False) -> Environment:
    """Return an environment in which nothing is fixed to the gripper, by its own setting or by that of its gripper mode."""
    mode = MoveArmThenGripper(JointPosition(), Discrete(attach_grasped_objects=False if by_mode else None))
    return Environment(mode, obs_config=low_dim_config(), attach_grasped_objects=by_mode, seed=0)


@pytest.mark.parametrize("by_mode", [False, True], ids=["environment", "gripper mode"])
def test_a_lifted_block_is_held_by_friction(by_mode: bool) -> None:
    """`Grasped` holds although nothing is attached, so that the demonstration succeeds."""
    with friction_only(by_mode) as environment:
        task = environment.get_task("pick_and_lift")
        attached: list[str] = []
        task.runtime.register_step_callback(lambda: attached.extend(task.runtime.gripper.grasped))
        outcome = task.try_demo(seed=0, variation=0)
        assert outcome.success, outcome.cause
        assert not attached and task.runtime.gripper.held == ("block",)


def test_a_broom_is_held_while_it_sweeps() -> None:
    """The broom swings by less than 5 degrees between the pads while it pushes crumbs over the edge of the pan."""
    with friction_only() as environment:
        task = environment.get_task("sweep_to_dustpan")
        world, in_hand = task.runtime.world, []

        def measure() -> None:
            if task.runtime.gripper.squeezes:
                in_hand.append(relative(world.body("broom").pose, world.robot.link_pose("panda_hand")))

        task.runtime.register_step_callback(measure)
        outcome = task.try_demo(seed=0, variation=0)
        assert outcome.success, outcome.cause
        assert max(rotation_distance(pose, in_hand[0]) for pose in in_hand) < np.radians(5.0)


@pytest.mark.parametrize(("name", "seed"), [("straighten_rope", 4), ("take_frame_off_hanger", 9)], ids=["squeeze", "release"])
def test_nothing_is_flung_away_or_sticks(name: str, seed: int) -> None:
    """A chain of light links stays between the fingers, and a frame does not stick to them when they open."""
    with friction_only() as environment:
        outcome = environment.get_task(name).try_demo(seed=seed, variation=0)
        assert outcome.success, outcome.cause


@pytest.mark.parametrize("name", ["meat_on_grill", "close_jar"])
def test_success_needs_an_open_gripper(name: str) -> None:
    """`NothingGrasped` does not hold while the fingers are closed on the object, in its place already."""
    with friction_only() as environment:
        task = environment.get_task(name)
        gripper, closed_on_it = task.runtime.gripper, []
        task.runtime.register_step_callback(
            lambda: closed_on_it.append(bool(gripper.between_fingers()) and bool(task.task.success()[0]))
        )
        outcome = task.try_demo(seed=0, variation=0)
        assert outcome.success, outcome.cause
        assert closed_on_it and not any(closed_on_it)
