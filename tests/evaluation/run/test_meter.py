"""What is counted while an episode is played: collisions with their force, and limits that are violated."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from rlbench_pin.environment import Environment, JointPosition, JointVelocity, MoveArmThenGripper, TaskEnvironment
from rlbench_pin.environment.actions import Discrete
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.evaluation.run.episode import POSITION, VELOCITY, Meter

pytestmark = pytest.mark.simulation


@pytest.fixture
def task() -> Iterator[TaskEnvironment]:
    """A task at the start of an episode."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config(), seed=0) as environment:
        task = environment.get_task("push_button")
        task.reset(seed=1)
        yield task


def drive(task: TaskEnvironment, joint: int, change: float, ticks: int) -> None:
    """Move one joint by `change` [rad] in each of some ticks."""
    q, limits = task.world.robot.joint_positions, task.runtime.model.limits
    for _ in range(ticks):
        q[joint] += change
        q = np.clip(q, limits.lower, limits.upper)
        task.step(np.append(q, 1.0))


def test_pressing_on_the_table_is_one_collision(task: TaskEnvironment) -> None:
    """The force is that of the hit, above all that the fingers press later; after a pause, it counts again."""
    with Meter(task.runtime).running() as meter:
        drive(task, 1, 0.05, 40)
        pressed = sum(task.world.robot.contact_forces().values())
        assert meter.collisions == 1
        assert meter.max_force >= pressed > 10.0
        hit = meter.max_force
        drive(task, 1, -0.05, 20)
        assert task.world.robot.contact_forces() == {}
        drive(task, 1, 0.05, 25)
        assert meter.collisions == 2
        assert meter.max_force >= hit
    drive(task, 1, -0.05, 20)
    drive(task, 1, 0.05, 25)
    assert meter.collisions == 2


def test_holding_still_counts_nothing(task: TaskEnvironment) -> None:
    """No contact, no limit."""
    with Meter(task.runtime).running() as meter:
        drive(task, 0, 0.0, 20)
    assert (meter.collisions, meter.max_force, meter.violations) == (0, 0.0, {})


def test_fingers_may_touch_what_belongs_to_the_task(task: TaskEnvironment) -> None:
    """The demonstration presses the button and collides with nothing, though the fingers were on it."""
    touched: set[str] = set()
    task.runtime.register_step_callback(lambda: touched.update(thing for _, thing in task.world.robot.contact_forces()))
    with Meter(task.runtime).running() as meter:
        outcome = task.try_demo(seed=1, record=False)
    assert outcome.success
    assert touched
    assert (meter.collisions, meter.max_force) == (0, 0.0)


def test_limits_are_counted_by_ticks() -> None:
    """A joint beyond its end and one that is too fast, each tick for itself."""
    mode = MoveArmThenGripper(JointVelocity(), Discrete())
    with Environment(mode, obs_config=low_dim_config(), seed=0) as environment:
        task = environment.get_task("push_button")
        task.reset(seed=1)
        robot, limits = task.world.robot, task.runtime.model.limits
        with Meter(task.runtime).running() as meter:
            q = robot.joint_positions
            q[0] = limits.upper[0] + 0.1
            robot.reset_configuration(q)
            task.step(np.append(np.zeros(7), 1.0))
            assert meter.violations == {POSITION: 1}
            robot.set_joint_states(task.world.robot.joint_states()[0], np.append(np.full(7, 8.0), [0.0, 0.0]))
            task.world.robot.forget_measurements()
            assert np.any(np.abs(robot.joint_velocities) > limits.velocity)
            meter.violations.clear()
            for callback in list(task.runtime.after_tick):
                callback()
            assert meter.violations[VELOCITY] == 1
