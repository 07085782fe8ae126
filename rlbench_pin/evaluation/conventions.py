"""Compare the conventions of a policy with those that its mapping or action mode states, by its first actions at known poses.

The first action of a trained policy is near the current pose. Its numbers are decoded in every convention with the same count of
numbers. The policy seems to use the convention whose decoded action is nearest to the current pose. This is a hint, not a proof.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace

import numpy as np

from rlbench_pin.environment.actions import (
    ArmActionMode,
    Discrete,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    GripperJointPosition,
    JointPosition,
    JointVelocity,
    MoveArmThenGripper,
    RelativeFrame,
    calculate_delta_pose,
    unwrapped,
)
from rlbench_pin.environment.actions.pose import PoseMode
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import InvalidActionError, TaskEnvironmentError
from rlbench_pin.evaluation.policies.client import PolicyClient, open_policy
from rlbench_pin.evaluation.policies.mapping import ARMS, ROTATIONS, ActionLayout
from rlbench_pin.evaluation.policies.policy import Policy, PolicyContext, PolicyFault
from rlbench_pin.evaluation.policies.wires import WirePolicy
from rlbench_pin.observation import Observation
from rlbench_pin.robot import RobotModel
from rlbench_pin.robot.description import DEFAULT_ROBOT
from rlbench_pin.spatial import FloatArray, euler_to_quaternion, rotation_distance
from rlbench_pin.tasks import find_task

MOVES = (
    ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), True),
    ((0.05, 0.12, -0.15), (30.0, -30.0, -40.0), False),
    ((0.02, -0.15, -0.08), (-30.0, -20.0, 40.0), True),
)
"""Displacement of the tip from the start pose along world axes [m], its rotation about them (roll, pitch, yaw) [degrees], and
whether the gripper is open. With these rotations, decoding in a wrong layout gives a mean error of 42 degrees or more."""
ABSOLUTE_LIMIT, RELATIVE_LIMIT = (0.5, np.radians(45.0)), (0.1, np.radians(15.0))
"""Largest distance [m] and angle [rad] of a first action that is near the current pose: first for a pose or joint positions, then
for a change of them or a velocity. The next key frame may be far."""
DEGREE = 0.005
"""Distance that counts as much as an angle of one degree when conventions are sorted [m]."""
CLEAR = (0.02, np.radians(4.0))
"""A convention is worse than the best one if its distance or angle exceeds twice that of the best one by this [m], [rad]."""
VELOCITY_TIME = 0.2
"""Time for which a velocity acts here [s]. In one control tick even wrong numbers move the arm little."""
GRIPPERS = ((1.0, 0.0), (0.0, 1.0), (1.0, -1.0), (-1.0, 1.0))
"""Numbers of an open and of a closed gripper."""
GRIPPER_LIMIT, GRIPPER_CLEAR = 0.25, 0.15
"""Largest mean error of a gripper number that follows the gripper, and the difference to a worse convention; 1 is the range from
closed to open."""
MEETING = 0.03
"""Three motions whose lines pass one point within this distance lead to one point [m]."""
SAME = 1e-6
"""Numbers that differ by less are the same."""


@dataclass(frozen=True)
class StatedConvention:
    """Meaning of the numbers of an action, as a mapping or an action mode states it."""

    source: str
    """Source of the statement, such as `the mapping 'libero'`."""
    layout: ActionLayout
    """Layout of the numbers."""
    tells_gripper: bool = True
    """Whether the gripper number is a state; otherwise it is a change."""
    is_twist: bool = False
    """Whether a `delta_pose` is a velocity of the tip, which acts for `VELOCITY_TIME`."""
    in_mapping: bool = False
    """Whether the source is a mapping, whose keys can be changed."""

    def name(self, layout: ActionLayout) -> str:
        """Return a layout in words."""
        if not layout.is_pose:
            return layout.arm
        arm = "tip velocity" if self.is_twist and layout.arm == "delta_pose" else layout.arm
        frame = f", {layout.frame} frame" if layout.arm == "delta_pose" else ""
        return f"{arm}, {layout.rotation}{frame}"


@dataclass(frozen=True, eq=False)
class FirstAction:
    """First action of a policy at a pose, and that pose."""

    joints: FloatArray
    """Joint positions, shape (n,), [rad]."""
    tip: FloatArray
    """Tip pose in the world, shape (7,)."""
    is_open: bool
    """Whether the gripper is open."""
    arm: FloatArray
    """Numbers of the arm."""
    gripper: float
    """Number of the gripper."""


@dataclass(frozen=True, eq=False)
class ArmReading:
    """First actions, decoded in one convention."""

    name: str
    """The convention in words."""
    layout: ActionLayout
    """The convention."""
    targets: tuple[FloatArray, ...]
    """Tip poses (7,) of the actions; empty when the numbers are not a pose."""
    distance: float
    """Mean distance to the current tip position [m]."""
    turn: float
    """Mean angle to the current tip rotation [rad]."""

    @property
    def score(self) -> float:
        """Distance plus weighted angle [m]."""
        return self.distance + DEGREE * float(np.degrees(self.turn))

    @property
    def is_relative(self) -> bool:
        """Whether it is a change or a velocity. Small numbers of these are near the current pose in every layout."""
        return self.layout.arm not in ("absolute_pose", "joint_positions")

    @property
    def is_near(self) -> bool:
        """Whether the actions are near the current pose."""
        distance, turn = RELATIVE_LIMIT if self.is_relative else ABSOLUTE_LIMIT
        return self.distance <= distance and self.turn <= turn

    def is_close_to(self, best: ArmReading) -> bool:
        """Whether it is nearly as good as the best."""
        return self.distance <= 2.0 * best.distance + CLEAR[0] and self.turn <= 2.0 * best.turn + CLEAR[1]


@dataclass(frozen=True)
class GripperReading:
    """Gripper numbers of first actions, decoded in one convention."""

    opened: float
    """Number of an open gripper."""
    closed: float
    """Number of a closed gripper."""
    error: float
    """Mean difference to the current state; 1 is the range from closed to open."""

    @property
    def name(self) -> str:
        """The convention in words."""
        return f"{self.opened:g} open, {self.closed:g} closed"


@dataclass(frozen=True)
class Verdict:
    """Result of the comparison with the stated convention."""

    text: str
    """The result as text."""
    differs: bool = False
    """Whether the policy seems to use another convention."""


@dataclass(frozen=True, eq=False)
class ConventionReport:
    """First actions of a policy in all conventions with the right count of numbers."""

    stated: StatedConvention
    """Convention of the mapping or the action mode."""
    arm: tuple[ArmReading, ...]
    """Conventions of the arm's numbers, best first."""
    gripper: tuple[GripperReading, ...]
    """Conventions of the gripper's number, best first."""
    arm_verdict: Verdict
    """Whether the arm's numbers agree."""
    gripper_verdict: Verdict
    """Whether the gripper's number agrees."""

    @property
    def differs(self) -> bool:
        """Whether the policy seems to use another convention than the stated one."""
        return self.arm_verdict.differs or self.gripper_verdict.differs

    def is_stated(self, reading: ArmReading | GripperReading) -> bool:
        """Whether a convention is the stated one."""
        if isinstance(reading, ArmReading):
            return reading.name == self.stated.name(self.stated.layout)
        return (reading.opened, reading.closed) == (self.stated.layout.gripper_open, self.stated.layout.gripper_closed)


def compare_conventions(policy: str | Policy, task: str = "reach_target", robot: str = DEFAULT_ROBOT) -> ConventionReport:
    """Request one action from a policy at each of three known poses, and compare its conventions with the stated ones.

    Args:
        policy: Reference, see `find_policy`, or an object with the methods of `Policy`.
        task: Name of a task that the policy was trained on, or a task file.
        robot: Name of the arm, or path of its TOML file.

    Raises:
        PolicyReferenceError: The reference names no policy.
        PolicyFault: The policy failed, or its action has a wrong size.
        PolicyOfAnotherArm: The policy was made for other joints than those of the arm.
        TaskEnvironmentError: The arm cannot reach one of the poses in this task, or the policy's actions are torques.
    """
    chosen = find_task(task)
    with closing(open_policy(policy)) as client:
        client.settings.check_robot(robot)
        mover = MoveArmThenGripper(EndEffectorPoseViaPlanning(absolute_mode=False), Discrete())
        config = client.settings.make_obs_config()
        with Environment(mover, obs_config=config, robot_setup=robot, seed=0) as environment:
            played = environment.get_task(chosen)
            stated = stated_convention(client, played.runtime)
            actions = tuple(_first_actions(client, played, stated.layout, robot))
            return compare_actions(stated, actions, played.runtime.model)


# Asking -----------------------------------------------------------------------------------------------------------------------


def stated_convention(client: PolicyClient, runtime: Runtime) -> StatedConvention:
    """Return the convention of a mapping, or of an action mode.

    Args:
        client: The policy.
        runtime: World and arm.

    Raises:
        TaskEnvironmentError: The actions are torques, which specify no pose.
    """
    if isinstance(client, WirePolicy):
        return StatedConvention(f"the mapping '{client.mapping.source}'", client.mapping.action, in_mapping=True)
    mode = client.settings.make_action_mode()
    fingers = mode.gripper_action_mode
    is_state = not isinstance(fingers, GripperJointPosition) or fingers.absolute_mode
    opened = runtime.description.gripper_open if isinstance(fingers, GripperJointPosition) else 1.0
    arm = unwrapped(mode.arm_action_mode)
    layout = replace(_arm_layout(arm), joints=runtime.model.size, gripper_open=opened)
    return StatedConvention("the action mode", layout, is_state, isinstance(arm, EndEffectorVelocity))


def _arm_layout(arm: ArmActionMode) -> ActionLayout:
    """Return the layout of the numbers of an arm mode."""
    if isinstance(arm, JointVelocity):
        return ActionLayout("joint_velocities")
    if isinstance(arm, JointPosition):
        return ActionLayout("joint_positions" if arm.absolute_mode else "joint_deltas")
    if isinstance(arm, EndEffectorVelocity):
        return ActionLayout("delta_pose", frame=_frame(arm.frame), scale=VELOCITY_TIME, rotation_scale=VELOCITY_TIME)
    if isinstance(arm, PoseMode):
        kind, frame = ("delta_pose", _frame(arm.frame)) if arm.is_relative else ("absolute_pose", "world")
        return ActionLayout(kind, rotation="quaternion_xyzw", frame=frame)
    problem = f"The policy has the arm action mode {type(arm).__name__}, whose actions specify no pose"
    raise TaskEnvironmentError(f"{problem}. Use a policy with poses, joint positions or velocities as actions.")


def _frame(frame: RelativeFrame) -> str:
    return "tip" if frame is RelativeFrame.EE else "world"


def _first_actions(client: PolicyClient, task: TaskEnvironment, layout: ActionLayout, robot: str) -> Iterator[FirstAction]:
    """Yield the first action of a policy at each pose."""
    runtime, mode = task.runtime, client.settings.make_action_mode()
    low, high = mode.bounds(runtime)
    context = PolicyContext(
        robot=robot,
        joints=runtime.model.size,
        action_low=tuple(low.tolist()),
        action_high=tuple(high.tolist()),
        control_period=task.world.control_dt,
        max_steps=client.settings.max_steps or 100,
        seed=0,
        task=task.get_name(),
    )
    gripper_at = layout.size - 1 if isinstance(client, WirePolicy) else mode.arm_action_mode.shape(runtime)[0]
    for number, (position, angles, is_open) in enumerate(MOVES):
        instructions, seen = task.reset(seed=0, variation=0)
        if any(position):
            delta = np.concatenate([position, euler_to_quaternion(*np.radians(angles)), [float(is_open)]])
            try:
                seen, _, _ = task.step(delta)
            except InvalidActionError as error:
                place = f"the position {position} m from its start pose in '{task.get_name()}'"
                raise TaskEnvironmentError(f"The arm '{robot}' cannot reach {place}: {error} Use another task.") from error
        client.reset(instructions[0], replace(context, seed=number))
        values = _asked(client, seen)
        if len(values) not in (gripper_at + 1, gripper_at + 1 + mode.optional_values):
            raise PolicyFault("wrong answer", f"an action has the shape {values.shape}; it must be ({gripper_at + 1},).")
        arm, tip = values[: layout.size - 1], runtime.robot.tip_pose()
        yield FirstAction(runtime.robot.joint_positions, tip, is_open, arm, float(values[gripper_at]))


def _asked(client: PolicyClient, seen: Observation) -> FloatArray:
    """Return the numbers of the next action as the policy returns them."""
    return client.next_values(seen) if isinstance(client, WirePolicy) else client.act(seen)


# Reading ----------------------------------------------------------------------------------------------------------------------


def compare_actions(stated: StatedConvention, actions: Sequence[FirstAction], model: RobotModel) -> ConventionReport:
    """Decode first actions in all conventions with the right count of numbers, and compare the best with the stated one.

    Args:
        stated: Convention of the mapping or the action mode.
        actions: First actions at known poses.
        model: The arm, for the tip poses of joint positions.
    """
    layouts = _fitting(stated.layout, len(actions[0].arm), model.size)
    readings = [_read(stated.name(layout), layout, actions, model) for layout in layouts]
    told = _told_frame(readings, actions)
    readings.sort(
        key=lambda reading: (round(reading.score, 4), reading.layout.frame != told, len(_changes(stated.layout, reading.layout)))
    )
    grippers = _read_gripper(stated.layout, actions)
    return ConventionReport(
        stated,
        tuple(readings),
        tuple(grippers),
        _arm_verdict(stated, readings, told, actions),
        _gripper_verdict(stated, grippers, actions),
    )


def _fitting(stated: ActionLayout, count: int, joints: int) -> Iterator[ActionLayout]:
    """Yield all layouts with a count of arm numbers. The stated arm keeps its scales; other layouts are in [m] and [rad]."""
    for arm in ARMS:
        base = stated if arm == stated.arm else ActionLayout(arm, joints=joints)
        if not base.is_pose:
            if joints == count:
                yield base
            continue
        for rotation in (rotation for rotation, size in ROTATIONS.items() if 3 + size == count):
            for frame in ("world", "tip") if arm == "delta_pose" else ("world",):
                yield replace(base, rotation=rotation, frame=frame)


def _read(name: str, layout: ActionLayout, actions: Sequence[FirstAction], model: RobotModel) -> ArmReading:
    try:
        targets = tuple(_target(layout, action, model) for action in actions)
    except ValueError:  # numbers that are no rotation
        return ArmReading(name, layout, (), np.inf, np.inf)
    pairs = [(target, action.tip) for target, action in zip(targets, actions, strict=True)]
    distance = float(np.mean([np.linalg.norm(target[:3] - tip[:3]) for target, tip in pairs]))
    return ArmReading(name, layout, targets, distance, float(np.mean([rotation_distance(*pair) for pair in pairs])))


def _target(layout: ActionLayout, action: FirstAction, model: RobotModel) -> FloatArray:
    """Return the tip pose (7,) of an action; for a velocity, the pose after `VELOCITY_TIME`."""
    arm = layout.decode(np.append(action.arm, layout.gripper_open))[:-1]
    if layout.arm == "absolute_pose":
        return arm
    if layout.arm == "delta_pose":
        return calculate_delta_pose(action.tip, arm, RelativeFrame.EE if layout.frame == "tip" else RelativeFrame.WORLD)
    change = arm * (VELOCITY_TIME if layout.arm == "joint_velocities" else 1.0)
    return model.tip_pose(change if layout.arm == "joint_positions" else action.joints + change)


def _read_gripper(stated: ActionLayout, actions: Sequence[FirstAction]) -> list[GripperReading]:
    pairs = dict.fromkeys((*GRIPPERS, (stated.gripper_open, stated.gripper_closed)))
    readings = []
    for opened, closed in pairs:
        errors: dict[bool, list[float]] = {True: [], False: []}
        for action in actions:
            errors[action.is_open].append(abs(action.gripper - (opened if action.is_open else closed)) / abs(opened - closed))
        readings.append(GripperReading(opened, closed, float(np.mean([np.mean(some) for some in errors.values()]))))
    return sorted(readings, key=lambda reading: reading.error)


def _told_frame(readings: Sequence[ArmReading], actions: Sequence[FirstAction]) -> str:
    """Return the frame in which the motions of a delta pose lead to one point; empty if this is undecided.

    A delta has the same length in both frames, so the distance does not distinguish them.
    """
    deltas = [reading for reading in readings if reading.layout.arm == "delta_pose" and reading.targets and reading.is_near]
    if not deltas:
        return ""
    nearest = min(deltas, key=lambda reading: reading.score).layout.rotation
    starts = np.array([action.tip[:3] for action in actions])
    misses = {r.layout.frame: _miss(starts, np.array(r.targets)[:, :3]) for r in deltas if r.layout.rotation == nearest}
    best, other = sorted(misses, key=lambda frame: misses[frame])
    return best if misses[best] <= MEETING and misses[other] >= 3.0 * misses[best] + MEETING else ""


def _miss(starts: FloatArray, ends: FloatArray) -> float:
    """Return the root mean square distance of straight motions (k, 3) from one point ahead of all of them [m]."""
    lengths = np.linalg.norm(ends - starts, axis=1)
    if lengths.min() < 1e-3:
        return np.inf
    ways = (ends - starts) / lengths[:, None]
    across = np.eye(3) - ways[:, :, None] * ways[:, None, :]
    point = np.linalg.lstsq(across.sum(axis=0), np.einsum("kij,kj->i", across, starts), rcond=None)[0]
    if ((point - starts) * ways).sum(axis=1).min() <= 0.0:
        return np.inf
    return float(np.sqrt(np.mean(np.sum(np.einsum("kij,kj->ki", across, point - starts) ** 2, axis=1))))


# Verdicts ---------------------------------------------------------------------------------------------------------------------


def _changes(old: ActionLayout, new: ActionLayout) -> dict[str, str]:
    """Return key -> new value, for the keys that differ between two layouts."""
    keys = ["arm", *(["rotation"] if new.is_pose else []), *(["frame"] if new.arm == "delta_pose" else [])]
    return {key: getattr(new, key) for key in keys if getattr(new, key) != getattr(old, key)}


def _arm_verdict(stated: StatedConvention, readings: Sequence[ArmReading], told: str, actions: Sequence[FirstAction]) -> Verdict:
    """Compare sorted readings with the stated convention."""
    if np.ptp([action.arm for action in actions], axis=0).max() < SAME:
        return Verdict(f"undecided: the policy returns the same numbers at all {len(actions)} poses.")
    near = [reading for reading in readings if reading.is_near]
    if any(reading.layout.arm == "absolute_pose" for reading in near):  # numbers of a pose near the tip are not small changes
        near = [reading for reading in near if not reading.is_relative]
    if not near:
        nearest = f"{readings[0].name} is the nearest"
        return Verdict(f"undecided: the first actions are far from the current pose in each convention; {nearest}.")
    best = near[0]
    close = [reading for reading in near if reading.is_close_to(best)]
    if told:
        close = [reading for reading in close if reading.layout.arm != "delta_pose" or reading.layout.frame == told]
    rivals = [reading for reading in close if not (reading.is_relative and best.is_relative) and reading is not best]
    if rivals:
        return Verdict(f"undecided: {best.name}, or {rivals[0].name}.")
    name = stated.name(stated.layout)
    chosen = next((reading for reading in close if reading.name == name), best)
    others = [_changes(chosen.layout, reading.layout) for reading in close if reading is not chosen]
    words = dict.fromkeys(f"{key} {value}" for other in others for key, value in list(other.items())[:1])
    note = f" Not distinguished from: {', '.join(words)}." if words else ""
    if chosen.name == name:
        return Verdict(f"agrees: {name}.{note}")
    hint = _advice(stated, _changes(stated.layout, best.layout))
    return Verdict(f"seems to be {best.name}, but {stated.source} states {name}: {hint}.{note}", differs=True)


def _gripper_verdict(stated: StatedConvention, readings: Sequence[GripperReading], actions: Sequence[FirstAction]) -> Verdict:
    """Compare sorted readings with the stated convention."""
    best, numbers = readings[0], ", ".join(f"{action.gripper:.3g}" for action in actions)
    if not stated.tells_gripper:
        return Verdict("undecided: the gripper number is a change, not a state.")
    if best.error > GRIPPER_LIMIT:
        states = ", ".join("open" if action.is_open else "closed" for action in actions)
        return Verdict(f"undecided: the gripper number ({numbers}) does not follow the gripper ({states}).")
    wanted = (stated.layout.gripper_open, stated.layout.gripper_closed)
    (own,) = (reading for reading in readings if (reading.opened, reading.closed) == wanted)
    if own.error <= best.error + GRIPPER_CLEAR:
        return Verdict(f"agrees: {own.name}.")
    hint = _advice(stated, {"gripper_open": best.opened, "gripper_closed": best.closed})
    return Verdict(f"seems to be {best.name}, but {stated.source} states {own.name}: {hint}.", differs=True)


def _advice(stated: StatedConvention, changes: Mapping[str, str | float]) -> str:
    if not stated.in_mapping:
        return "convert the numbers in the policy's `act`, or use another action mode"
    entries = (f'`{key} = "{value}"`' if isinstance(value, str) else f"`{key} = {value:g}`" for key, value in changes.items())
    return f"set {', '.join(entries)}"
