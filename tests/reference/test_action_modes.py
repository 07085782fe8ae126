"""What docs/reference/action_modes.md says of sizes, ticks and bounds holds in a running environment."""

from __future__ import annotations

import numpy as np
import pytest
from reference_lib.action_modes import ARM, GRIPPER, WHOLE

from rlbench_pin import environment
from rlbench_pin.environment import ActionMode, Discrete, Environment, JointVelocity, MoveArmThenGripper, TaskEnvironment
from rlbench_pin.environment.actions.modes import Mode
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.errors import InvalidActionError
from tests.reference.support import part, rows

LISTED = {row[0]: row[1:] for row in rows(part("action_modes", "overview"))}
"""Mode -> numbers, units, frame, ticks, by the page."""


def running(mode: ActionMode) -> Environment:
    """Return an environment without images."""
    return Environment(mode, obs_config=low_dim_config())


def whole(name: str) -> tuple[ActionMode, int, int | None]:
    """Return the mode of the page inside a whole one, and the size and the ticks of the whole."""
    size, ticks = int(LISTED[name][0]), None if LISTED[name][3] == "as the motion takes" else int(LISTED[name][3])
    if name in ARM:
        return MoveArmThenGripper(ARM[name], Discrete()), size + 1, ticks  # type: ignore[arg-type]
    if name in GRIPPER:  # after a tick of the arm
        return MoveArmThenGripper(JointVelocity(), GRIPPER[name]), size + 7, None if ticks is None else ticks + 1  # type: ignore[arg-type]
    mode = WHOLE[name]
    assert isinstance(mode, ActionMode)
    return mode, size, ticks


def stay(task: TaskEnvironment, mode: ActionMode) -> np.ndarray:
    """Return an action that asks for what is there, by the names of its numbers."""
    low, high = task.action_bounds()
    names = mode.spec(task.runtime).names
    absolute = getattr(mode.arm_action_mode, "absolute_mode", True) and getattr(mode.arm_action_mode, "frame", 0) == 0
    robot = task.world.robot
    pose = dict(
        zip(("x", "y", "z", "qx", "qy", "qz", "qw"), robot.tip_pose() if absolute else (0, 0, 0, 0, 0, 0, 1), strict=True)
    )
    joints = dict(zip(task.runtime.description.arm_joints, robot.joint_positions if absolute else np.zeros(7), strict=True))
    known = {**joints, **pose, "gripper": 1.0, "finger": 0.04}
    return np.clip([known.get(name, 0.0) for name in names], low, high)


def test_every_mode_is_on_the_page() -> None:
    """Each class at the front door that has a specification, abstract ones apart."""
    public = {n for n in environment.__all__ if isinstance(c := getattr(environment, n), type) and issubclass(c, Mode)}
    assert public - {name.split("(")[0] for name in LISTED} == {"ActionMode", "ArmActionMode", "GripperActionMode"}


@pytest.mark.simulation
@pytest.mark.parametrize("name", LISTED)
def test_a_mode_takes_the_numbers_and_the_ticks_of_the_page(name: str) -> None:
    """An action of that size within the bounds is run, in that time; one number fewer or more is refused."""
    mode, size, ticks = whole(name)
    with running(mode) as env:
        task = env.get_task("reach_target")
        task.reset(seed=0)
        low, high = task.action_bounds()
        assert low.shape == high.shape == (size,)
        before, action = task.world.time, stay(task, mode)
        for wrong in (action[:-1], np.append(action, [0.0, 0.0])):
            with pytest.raises(InvalidActionError, match="shape"):
                task.step(wrong)
        assert task.world.time == before
        task.step(action)
        if ticks is not None:
            assert task.world.time - before == pytest.approx(0.05 * ticks)


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("name", "change", "why"),
    [
        ("JointPosition()", {0: np.nan}, "NaN"),
        ("JointPosition()", {7: 1.5}, "between 0"),
        ("EndEffectorPoseViaPlanning()", {0: 5.0}, "workspace"),
        ("EndEffectorPoseViaPlanning()", {3: 2.0}, "quaternion"),
        ("EndEffectorPoseViaIK()", {0: 5.0}, "reach"),
        ("ERJointViaIK()", {0: 5.0}, "reach"),
    ],
)
def test_what_the_page_calls_refused_is_refused(name: str, change: dict[int, float], why: str) -> None:
    """And nothing has moved."""
    mode, _, _ = whole(name)
    with running(mode) as env:
        task = env.get_task("reach_target")
        task.reset(seed=0)
        action, before = stay(task, mode), task.world.time
        for index, value in change.items():
            action[index] = value
        with pytest.raises(InvalidActionError, match=why):
            task.step(action)
        assert task.world.time == before


@pytest.mark.simulation
@pytest.mark.parametrize("name", ["JointVelocity()", "JointPosition()", "JointTorque()", "GripperJointPosition()"])
def test_what_the_page_calls_capped_is_capped(name: str) -> None:
    """Ten times the bounds do what the bounds do, to the last bit."""
    mode, _, _ = whole(name)
    ends = []
    for factor in (1.0, 10.0):
        with running(mode) as env:
            task = env.get_task("reach_target")
            task.reset(seed=0)
            low, high = task.action_bounds()
            own = np.arange(len(low)) < 7 if name in ARM else np.arange(len(low)) >= 7
            action = np.where(own, high + (factor - 1.0) * np.abs(high), np.zeros(len(low)))
            ends.append(task.step(action)[0].get_low_dim_data())
    np.testing.assert_array_equal(*ends)
