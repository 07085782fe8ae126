"""Whatever an action is: it runs within the limits, or it is refused and nothing has moved; the environment stays usable."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pytest

from rlbench_pin.environment import (
    ActionMode,
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    Environment,
    ERJointViaIK,
    GripperJointPosition,
    JointPosition,
    JointPositionActionMode,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
    SafeArm,
    TaskEnvironment,
)
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.gym import GymnasiumEnv, LazyAsyncVectorEnv
from tests.fuzz.cases import Case, Tally
from tests.fuzz.doors_world import moved
from tests.fuzz.hostile import ALL, ARRAY, SEVERAL, SINGLE, Hostile, bent

MODES = (
    lambda: MoveArmThenGripper(JointPosition(), Discrete()),
    lambda: MoveArmThenGripper(JointPosition(absolute_mode=False), GripperJointPosition()),
    lambda: MoveArmThenGripper(JointVelocity(), GripperJointPosition(absolute_mode=False)),
    lambda: MoveArmThenGripper(JointTorque(), Discrete()),
    lambda: MoveArmThenGripper(EndEffectorVelocity(), Discrete()),
    lambda: MoveArmThenGripper(EndEffectorPoseViaIK(absolute_mode=False), Discrete()),
    lambda: MoveArmThenGripper(EndEffectorPoseViaPlanning(collision_checking=True), Discrete()),
    lambda: MoveArmThenGripper(ERJointViaIK(), Discrete()),
    lambda: MoveArmThenGripper(SafeArm(JointVelocity()), Discrete()),
    JointPositionActionMode,
)


def good_action(task: TaskEnvironment, rng: np.random.Generator) -> np.ndarray:
    """Draw an action within its bounds, which are brought to 1 where they are none; quaternions have length 1."""
    spec = task.action_mode.spec(task.runtime)
    low, high = np.nan_to_num(spec.low, neginf=-1.0, posinf=1.0), np.nan_to_num(spec.high, neginf=-1.0, posinf=1.0)
    action = rng.uniform(low, high)
    if "qx" in spec.names:
        start = spec.names.index("qx")
        action[start : start + 4] /= np.linalg.norm(action[start : start + 4])
    return action


def hostile_actions(good: np.ndarray, rng: np.random.Generator) -> Iterator[Hostile]:
    """Yield everything but good actions."""
    yield from (*SINGLE, *SEVERAL)
    for value, is_good in bent(good, rng):
        if not is_good:
            yield value


class Watch:
    """Says what a step did wrong."""

    def __init__(self, task: TaskEnvironment) -> None:
        self.task = task
        self.remember()

    def remember(self) -> None:
        """Take the present state as the one before."""
        world = self.task.world
        self.before = {"q": world.robot.joint_positions, **{name: body.pose for name, body in world.bodies.items()}}
        self.ticks, self.stepped = world.ticks, False

    def step(self, action: object) -> object:
        """Take a step and note that it was taken."""
        self.remember()
        result = self.task.step(action)
        self.stepped = True
        return result

    def check(self) -> str:
        """Nothing has moved when the action was refused; otherwise the arm is within its limits, and all is finite."""
        world, model = self.task.world, self.task.runtime.model
        if not self.stepped:
            return moved(world, self.before) or ("time has passed" if world.ticks != self.ticks else "")
        observation = self.task.get_observation()
        if not all(np.isfinite(part).all() for part in (observation.joint_positions, observation.joint_velocities)):
            return "the arm is nowhere"
        if "JointTorque" in type(getattr(self.task.action_mode, "arm_action_mode", None)).__name__:
            return ""  # full torques at random drive the arm into its stops, which give way
        return "" if model.limits.contains(observation.joint_positions, 0.02) else "the arm is beyond its limits"


def try_mode(mode: ActionMode, tally: Tally, rng: np.random.Generator, share: float, good: int) -> None:
    """Step with hostile actions and with good ones."""
    with Environment(mode, obs_config=low_dim_config(), seed=0) as env:
        task = env.get_task("reach_target")
        task.reset(seed=1)
        watch, door = Watch(task), f"step with {type(mode).__name__}({type(getattr(mode, 'arm_action_mode', None)).__name__})"
        for value in hostile_actions(good_action(task, rng), rng):
            if rng.random() < share:
                call = (lambda v: lambda: watch.step(v.make()))(value)
                refuse = bool(value.refused_by & {ARRAY}) or value in SINGLE
                refuse &= value.words != "one number more"  # planning takes one more: whether collisions count
                tally.run(Case(door, value.words, call, check=watch.check, must_refuse=refuse, finite=False))
        for number in range(good):
            action = good_action(task, rng)
            call = (lambda a: lambda: watch.step(a))(action)
            tally.run(Case(door, f"good action {number}: {action.tolist()}", call, check=watch.check, finite=False))
        task.reset(seed=2)


def try_gym(tally: Tally, rng: np.random.Generator, share: float) -> None:
    """Step and reset the environment of gymnasium."""
    env = GymnasiumEnv("reach_target", invalid_action="raise")
    env.reset(seed=1)
    watch = Watch(env.task_environment)
    try:
        for value in hostile_actions(env.action_space.sample().astype(float), rng):
            if rng.random() < share:
                call = (lambda v: lambda: (watch.remember(), env.step(v.make()))[1])(value)
                tally.run(Case("GymnasiumEnv.step", value.words, call, must_refuse=bool(value.refused_by & {ARRAY})))
        for value in (*SINGLE, *SEVERAL):
            if rng.random() < share:
                seed = (lambda v: lambda: env.reset(seed=v.make()))(value)
                options = (lambda v: lambda: env.reset(options=v.make()))(value)
                variation = (lambda v: lambda: env.reset(options={"variation": v.make()}))(value)
                refuse = "whole" in value.refused_by
                tally.run(Case("GymnasiumEnv.reset", f"seed={value.words}", seed, must_refuse=refuse))
                tally.run(Case("GymnasiumEnv.reset", f"options={value.words}", options))
                tally.run(Case("GymnasiumEnv.reset", f"variation={value.words}", variation, must_refuse=refuse))
        env.reset(seed=1)
        assert env.step(env.action_space.sample())[1] == 0.0
    finally:
        env.close()


def try_vector(tally: Tally, rng: np.random.Generator, share: float) -> None:
    """Step many environments at once: what is wrong is refused before their processes are asked."""
    like = GymnasiumEnv("reach_target")
    vector = LazyAsyncVectorEnv([lambda: GymnasiumEnv("reach_target")] * 2, like)
    like.close()
    good = vector.action_space.sample().astype(float)
    for value in hostile_actions(good, rng):
        if rng.random() < share and value.refused_by & ALL:
            call = (lambda v: lambda: vector.step(v.make()))(value)
            tally.run(Case("LazyAsyncVectorEnv.step", value.words, call, must_refuse=True))
        if rng.random() < share and "whole" in value.refused_by:
            call = (lambda v: lambda: vector.reset(seed=v.make()))(value)
            tally.run(Case("LazyAsyncVectorEnv.reset", value.words, call, must_refuse=True))
    assert not vector.is_running


def try_all(tally: Tally, seed: int, share: float, good: int, modes: Sequence = MODES) -> None:
    """Try every mode, gymnasium and vectors, and fail with all that is wrong."""
    for number, make in enumerate(modes):
        try_mode(make(), tally, np.random.default_rng((seed, number)), share, good)
    try_gym(tally, np.random.default_rng((seed, 100)), share)
    try_vector(tally, np.random.default_rng((seed, 101)), share)
    assert not tally.faults, f"seed {seed}:\n{tally.report()}"


@pytest.mark.simulation
def test_actions(tally: Tally, seed: int) -> None:
    """A part of all values in every mode."""
    try_all(tally, seed, 0.3, 2)
    assert tally.cases > 350


@pytest.mark.slow
def test_actions_with_every_value(tally: Tally, seed: int) -> None:
    """All values in every mode, and many good ones."""
    try_all(tally, seed, 1.0, 40)
    assert tally.cases > 1_600
