"""Action modes hold settings only: one object serves several environments, and an action is checked once."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable

import numpy as np
import pytest

from rlbench_pin.environment import (
    ActionMode,
    ArmActionMode,
    Discrete,
    EndEffectorVelocity,
    Environment,
    ERJointViaIK,
    GripperActionMode,
    GripperJointPosition,
    JointPosition,
    JointPositionActionMode,
    JointVelocity,
    MoveArmThenGripper,
    RelativeFrame,
    Runtime,
    SafeArm,
    TaskEnvironment,
)
from rlbench_pin.environment.actions import modes
from rlbench_pin.environment.actions.modes import ActionSpec
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.errors import InvalidActionError, InvalidArgument
from rlbench_pin.spatial import FloatArray

MODES: dict[str, Callable[[], ActionMode]] = {
    "tip velocity": lambda: MoveArmThenGripper(EndEffectorVelocity(), GripperJointPosition()),
    "filtered": lambda: MoveArmThenGripper(SafeArm(JointVelocity()), Discrete()),
    "joint differences": JointPositionActionMode,
}


def task_of(chosen: ActionMode, task: str = "reach_target", **settings: object) -> TaskEnvironment:
    """An episode with an action mode."""
    env = Environment(chosen, obs_config=low_dim_config(), seed=0, **settings)  # type: ignore[arg-type]
    task_env = env.get_task(task)
    task_env.reset(seed=2)
    return task_env


def played(first: TaskEnvironment, second: TaskEnvironment) -> bytes:
    """Play both in turns, with different actions, and return everything that was observed."""
    rng = np.random.default_rng(0)
    seen = []
    for _ in range(8):
        for task_env in (first, second):
            low, high = task_env.action_bounds()
            seen.append(task_env.step(rng.uniform(low, high))[0].get_low_dim_data().tobytes())
    return b"".join(seen)


@pytest.mark.simulation
@pytest.mark.parametrize("make", MODES.values(), ids=MODES)
def test_one_mode_in_two_environments_is_as_two_modes(make: Callable[[], ActionMode]) -> None:
    """Two environments that take turns with one action mode see the same bytes as with one each."""
    shared = make()
    tasks = ("reach_target", "open_drawer")
    together = played(*(task_of(shared, task) for task in tasks))
    assert together == played(*(task_of(make(), task) for task in tasks))


def test_environments_write_nothing_into_the_mode() -> None:
    """Whether grasped bodies are attached is a matter of each environment, even where two share a mode."""
    gripper = GripperJointPosition()
    before = copy.deepcopy(vars(gripper))
    loops = [task_of(MoveArmThenGripper(JointPosition(), gripper), attach_grasped_objects=attach) for attach in (True, False)]
    for task_env in loops:
        task_env.step(np.append(task_env.get_observation().joint_positions, 0.0))
    assert [gripper.attaches(task_env.runtime) for task_env in loops] == [True, False]
    assert vars(gripper) == before
    assert [GripperJointPosition(attach).attaches(loops[1].runtime) for attach in (True, False)] == [True, False]


@pytest.mark.parametrize("make", MODES.values(), ids=MODES)
def test_an_action_is_checked_once_and_needs_no_specification(
    make: Callable[[], ActionMode], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One check for each action, which makes no specification."""
    checks, specs = [], []
    check, made = modes.as_action, ActionSpec.__post_init__

    def counted(*arguments: object) -> FloatArray:
        checks.append(1)
        return check(*arguments)  # type: ignore[arg-type]

    def counted_spec(spec: ActionSpec) -> None:
        specs.append(spec)
        made(spec)

    monkeypatch.setattr(modes, "as_action", counted)
    monkeypatch.setattr(ActionSpec, "__post_init__", counted_spec)
    task_env = task_of(make())
    low, high = task_env.action_bounds()
    specs.clear()
    for _ in range(3):
        task_env.step(0.5 * (low + high))
    assert (len(checks), len(specs)) == (3, 0)


def test_specifications_cannot_be_changed_by_those_who_read_them() -> None:
    """Bounds of a specification are read-only; `action_bounds` gives copies."""
    task_env = task_of(MoveArmThenGripper(JointVelocity(), Discrete()))
    spec = task_env.action_mode.spec(task_env.runtime)
    with pytest.raises(ValueError, match="read-only"):
        spec.low[0] = 0.0
    low, _ = task_env.action_bounds()
    low[0] = 0.0
    assert task_env.action_bounds()[0][0] == spec.low[0] != 0.0


def test_an_arm_mode_with_a_check_of_its_own_replaces_the_numbers() -> None:
    """A check may return other numbers, or refuse them, behind a filter too."""
    given: list[FloatArray] = []

    class Halved(JointVelocity):
        def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
            if values[0] >= 1.0:
                raise InvalidActionError("too fast")
            given.append(values)
            return 0.5 * values

    for arm in (Halved(), SafeArm(Halved())):
        task_env = task_of(MoveArmThenGripper(arm, Discrete()))
        before = task_env.get_observation().joint_positions
        after = task_env.step([0.5] + [0.0] * 6 + [1.0])[0].joint_positions
        assert given.pop().tolist() == [0.5] + [0.0] * 6
        assert after[0] - before[0] == pytest.approx(0.25 * 0.05, abs=2e-3)
        with pytest.raises(InvalidActionError, match="too fast"):
            task_env.step([1.0] + [0.0] * 6 + [1.0])


def test_a_whole_mode_may_have_an_action_and_a_shape_alone() -> None:
    """A whole mode may take its arm and gripper modes apart itself; these still refuse what they cannot do."""

    class ArmAlone(ActionMode):
        def action(self, runtime: Runtime, action: object) -> None:
            self.arm_action_mode.action(runtime, action)

        def shape(self, runtime: Runtime) -> tuple[int]:
            return self.arm_action_mode.shape(runtime)

    with Environment(ArmAlone(JointPosition(), Discrete()), obs_config=low_dim_config(), seed=0) as env:
        task_env = env.get_task("reach_target")
        _, start = task_env.reset(seed=0)
        assert env.action_shape == (7,)
        task_env.step(list(start.joint_positions))
        with pytest.raises(InvalidActionError, match=r"JointPosition takes an array of shape \(7,\), not \(8,\)"):
            task_env.step(np.zeros(8))


def test_modes_that_know_their_shape_and_act_are_enough() -> None:
    """An arm mode and a gripper mode need no specification to run."""
    given: list[list[float]] = []

    class Still(ArmActionMode):
        def shape(self, runtime: Runtime) -> tuple[int]:
            return (2,)

    class Grip(GripperActionMode):
        def shape(self, runtime: Runtime) -> tuple[int]:
            return (1,)

        def steps(self, runtime: Runtime, values: FloatArray) -> None:
            given.append(values.tolist())

    task_env = task_of(MoveArmThenGripper(Still(), Grip()))
    began = task_env.world.time
    task_env.step([0.0, 0.0, 1.0])
    assert task_env.world.time - began == pytest.approx(0.05)
    assert given == [[1.0]]
    with pytest.raises(InvalidActionError, match=r"shape \(3,\)"):
        task_env.step(np.zeros(8))
    with pytest.raises(NotImplementedError, match="spec"):
        task_env.action_bounds()


def test_a_motion_behind_the_filter_is_filtered_in_every_tick() -> None:
    """Also a mode that claims one tick, and takes more."""

    class Long(JointVelocity):
        def steps(self, runtime: Runtime, values: FloatArray) -> None:
            for _ in range(5):
                runtime.step()

    class LongMotion(Long):
        ticks = None

    for inner in (Long(), LongMotion()):
        arm = SafeArm(inner)
        task_env = task_of(MoveArmThenGripper(arm, Discrete()))
        task_env.step([0.1] * 7 + [1.0])
        assert arm.counts.ticks == 5


def test_settings_that_are_replaced_take_effect_at_once() -> None:
    """Specification, bounds and shape follow the settings of a mode that was used before, and of its parts."""
    arm, gripper = ERJointViaIK(), GripperJointPosition()
    task_env = task_of(MoveArmThenGripper(arm, gripper))
    chosen, first = task_env.action_mode, task_env.action_mode.spec(task_env.runtime)
    arm.commanded_joints, arm.absolute_mode, arm.frame = (0, 6), False, RelativeFrame.EE
    gripper.absolute_mode = False
    spec = chosen.spec(task_env.runtime)
    assert (first.size, spec.size, chosen.shape(task_env.runtime)) == (9, 10, (10,))
    assert (first.frame, spec.frame) == ("world", "end effector")
    assert (first.low[-1], spec.low[-1]) == (0.0, -spec.high[-1])
    chosen.arm_action_mode = JointVelocity()
    assert task_env.action_bounds()[1][:-1].tolist() == task_env.runtime.model.limits.velocity.tolist()


def test_a_subclass_whose_bounds_follow_its_own_setting() -> None:
    """A mode that overrides `bounds` is asked again when its own setting is replaced."""

    class Scaled(JointVelocity):
        scale = 1.0

        def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
            low, high = super().bounds(runtime)
            return low / self.scale, high / self.scale

    arm = Scaled()
    task_env = task_of(MoveArmThenGripper(arm, Discrete()))
    before = task_env.action_bounds()[1]
    arm.scale = 2.0
    assert np.array_equal(2.0 * task_env.action_bounds()[1][:-1], before[:-1])


@pytest.mark.parametrize("make", MODES.values(), ids=MODES)
def test_a_mode_that_was_used_can_be_sent_to_another_process(make: Callable[[], ActionMode]) -> None:
    """Modes keep no solvers, so they can be pickled and copied at any time."""
    task_env = task_of(make())
    task_env.step(0.5 * sum(task_env.action_bounds()))
    copied = pickle.loads(pickle.dumps(task_env.action_mode))
    assert copied.shape(task_env.runtime) == task_env.action_mode.shape(task_env.runtime)


RIGHT = r"Write `MoveArmThenGripper\(JointVelocity\(\), Discrete\(\)\)`"
WRONG_PARTS: dict[str, tuple[Callable[[], object], str]] = {
    "classes": (lambda: MoveArmThenGripper(JointVelocity, Discrete), "arm_action_mode.*not the class JointVelocity.*" + RIGHT),  # type: ignore[arg-type]
    "a class of a gripper": (
        lambda: MoveArmThenGripper(JointPosition(), Discrete),  # type: ignore[arg-type]
        r"gripper_action_mode.*not the class Discrete.*MoveArmThenGripper\(JointPosition\(\), Discrete\(\)\)",
    ),
    "swapped": (lambda: MoveArmThenGripper(Discrete(), JointVelocity()), "arm_action_mode.*a gripper mode.*" + RIGHT),  # type: ignore[arg-type]
    "two arms": (lambda: MoveArmThenGripper(JointVelocity(), JointVelocity()), "gripper_action_mode.*an arm mode.*" + RIGHT),  # type: ignore[arg-type]
    "text": (lambda: MoveArmThenGripper("JointVelocity", Discrete()), "arm_action_mode.*'JointVelocity'.*" + RIGHT),  # type: ignore[arg-type]
    "None": (lambda: MoveArmThenGripper(JointVelocity(), None), "gripper_action_mode.*None.*" + RIGHT),  # type: ignore[arg-type]
    "nested": (
        lambda: MoveArmThenGripper(MoveArmThenGripper(JointVelocity(), Discrete()), Discrete()),  # type: ignore[arg-type]
        "arm_action_mode.*a whole action mode.*" + RIGHT,
    ),
    "a filtered class": (
        lambda: SafeArm(JointVelocity),
        r"mode .*not the class JointVelocity.*Write `SafeArm\(JointVelocity\(\)\)`",
    ),  # type: ignore[arg-type]
    "a filtered gripper": (lambda: SafeArm(Discrete()), r"mode .*a gripper mode.*Write `SafeArm\(JointVelocity\(\)\)`"),  # type: ignore[arg-type]
    "a filtered whole": (
        lambda: SafeArm(MoveArmThenGripper(JointVelocity(), Discrete())),  # type: ignore[arg-type]
        r"mode .*a whole action mode.*Write `SafeArm\(JointVelocity\(\)\)`",
    ),
}


@pytest.mark.parametrize("name", WRONG_PARTS)
def test_what_is_no_part_is_refused_at_construction(name: str) -> None:
    """Classes, swapped or nested parts, names and nothing: the error names the argument and shows the right call."""
    make, says = WRONG_PARTS[name]
    with pytest.raises(InvalidArgument, match=says):
        make()
