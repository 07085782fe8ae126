"""The planner's action in any state of an episode, in any action space: labels for learners that act themselves (DAgger)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from rlbench_pin.datasets import key_frame_actions
from rlbench_pin.environment.actions.modes import (
    ActionMode,
    ArmActionMode,
    Discrete,
    EndEffectorVelocity,
    GripperActionMode,
    GripperJointPosition,
    JointPosition,
    JointVelocity,
    RelativeFrame,
    checked_mode,
)
from rlbench_pin.environment.actions.pose import EndEffectorPoseViaIK, EndEffectorPoseViaPlanning, PoseMode
from rlbench_pin.environment.actions.safe_arm import SafeArm
from rlbench_pin.environment.demos import DemoPlayer, try_play
from rlbench_pin.environment.episode import EpisodeOrigin
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DemoError, InvalidArgument
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import FloatArray, compose, inverse, relative
from rlbench_pin.tasks import Waypoint
from rlbench_pin.values import as_record

SAME = 2e-3
"""A state is one that was foreseen when joints, fingers and objects differ by less than this [rad, m]."""
MOST_TRIES = 8
"""Waypoints from which the remainder of a demonstration is tried."""


def expert_action(task_environment: TaskEnvironment, action_mode: ActionMode | None = None) -> FloatArray:
    """Return the action of the planner in the present state of an episode.

    The remainder of a demonstration is planned from the measured state and simulated ahead, until one reaches the goal. Its first
    action is returned, and the world is as before. As long as the episode goes as foreseen, nothing is planned anew.

    Args:
        task_environment: The running task, in any state of an episode.
        action_mode: Mode of the action; None is the one of the environment. The arm mode can be `JointPosition`, `JointVelocity`,
            `EndEffectorVelocity`, `EndEffectorPoseViaIK` or `EndEffectorPoseViaPlanning`, also within `SafeArm`; the gripper mode
            `Discrete` or `GripperJointPosition`.

    Returns:
        The action, shape (n,) with n as `action_mode` says; with `EndEffectorPoseViaPlanning` and `MoveArmThenGripper` it is the
        next key frame, and a last number says whether collisions are ignored.

    Raises:
        DemoError: No remainder of a demonstration reaches the goal from here.
        InvalidArgument: The action mode is none of those.
        NotReset: Before the first reset.
    """
    task_environment = as_record(task_environment, TaskEnvironment, "task_environment", InvalidArgument)
    if action_mode is None:
        action_mode = task_environment.action_mode
    mode = checked_mode(action_mode, "action_mode", ActionMode, "Write `MoveArmThenGripper(JointPosition(), Discrete())`.")
    runtime, episode = task_environment.runtime, task_environment.episode
    return _action(mode, runtime, runtime.kept(expert_action, Foresight).frames(runtime, episode))


@dataclass
class Moment:
    """A foreseen moment of an episode."""

    state: FloatArray
    """Joints [rad], fingers [m] and the state of the task, for comparison."""
    observation: Observation
    """Joints, tip and gripper, and the command that has led here."""
    round: int
    """How often the list of waypoints was finished before."""
    position: int
    """Place in the list of the waypoint that comes next."""


@dataclass
class Foresight:
    """The foreseen remainder of an episode."""

    episode: EpisodeOrigin | None = None
    """The episode that it belongs to."""
    moments: list[Moment] = field(default_factory=list)
    """The present moment of the last call, and those after it."""
    time: float = 0.0
    """Simulated time of the last call [s]."""

    def frames(self, runtime: Runtime, episode: EpisodeOrigin) -> list[Observation]:
        """Return the present frame and those that follow it in a demonstration.

        Raises:
            DemoError: None was found.
        """
        if self.episode is not episode:
            self.episode, self.moments, self.time = episode, [], 0.0
        state = _state(runtime)
        known = self._present(runtime, state)
        if known is None:
            self.moments = self._found(runtime, state)
        else:
            del self.moments[:known]
        self.time = runtime.world.time
        return [moment.observation for moment in self.moments]

    def _present(self, runtime: Runtime, state: FloatArray) -> int | None:
        """Return the place of the foreseen moment that is now; None where there is none, or it is the last."""
        if len(self.moments) < 2:
            return None
        away = np.array([np.abs(moment.state - state).max() for moment in self.moments])
        went_on = runtime.world.time > self.time and away[1] < SAME
        nearest = 1 if went_on else int(away.argmin())
        return nearest if away[nearest] < SAME and nearest + 1 < len(away) else None

    def _found(self, runtime: Runtime, state: FloatArray) -> list[Moment]:
        causes = []
        round_, first = self._likeliest(runtime, state)
        waypoints = runtime.task.get_waypoints()
        order = [*range(first, -1, -1), *range(first + 1, len(waypoints))]
        possible = [p for p in order if not runtime.gripper.is_open or _opening_before(waypoints, p) > 0.5]
        for position in possible[:MOST_TRIES]:
            with runtime.ahead():
                player = _Ahead(runtime, round_, position, goes_back=position < first)
                cause, _ = try_play(player)
            if not cause:
                return player.moments
            causes.append(f"from waypoint {position}: {cause}")
        raise DemoError(f"No remainder of a demonstration reaches the goal from here ({'; '.join(causes)}).", runtime.task)

    def _likeliest(self, runtime: Runtime, state: FloatArray) -> tuple[int, int]:
        """Return the round, and the place in the list of the waypoint to go on with."""
        if not self.moments:
            return 0, _after_grasp(runtime)
        near = min(self.moments, key=lambda moment: float(np.abs(moment.state - state).max()))
        return near.round, min(near.position, len(runtime.task.get_waypoints()) - 1)


def _after_grasp(runtime: Runtime) -> int:
    """Return the place of the first waypoint after the grasp of what is held; 0 where nothing is."""
    waypoints = runtime.task.get_waypoints()
    for place, waypoint in enumerate(waypoints):
        grasps = waypoint.gripper is not None and not waypoint.releases
        if grasps and any(waypoint.frame.moves_with(name) for name in runtime.gripper.held):
            return min(place + 1, len(waypoints) - 1)
    return 0


def _opening_before(waypoints: Sequence[Waypoint], position: int) -> float:
    """Return the opening fraction of the gripper on the way to the waypoint at a place in the list."""
    return waypoints[position - 1].gripper_amount if position > 0 else 1.0


class _Ahead(DemoPlayer):
    """Plays the remainder of a demonstration from a waypoint on, and keeps its moments."""

    def __init__(self, runtime: Runtime, round_: int, position: int, *, goes_back: bool) -> None:
        super().__init__(runtime)
        self.moments: list[Moment] = []
        self._round, self._first, self._goes_back = round_, position, goes_back
        self._amount = 1.0 if runtime.gripper.is_open else 0.0

    def play(self) -> list[Observation]:
        """Do what waypoints before the first would have done without motion, and go on from there."""
        task = self.runtime.task
        for _ in range(self._round):
            task.should_repeat_waypoints()
        for waypoint in task.get_waypoints()[: self._first]:
            waypoint.run_start_hook()
            if waypoint.gripper is not None:
                self._planner.grasp = None if waypoint.releases else waypoint
        return super().play()

    def run_segment(self, waypoint: Waypoint, rest: Sequence[Waypoint], angles: Sequence[float]) -> None:
        """Bring the fingers to where they should be first, and note what comes next afterwards."""
        if len(self.moments) == 1:
            self._finish_gripper_action()
        if waypoint.index < self.moments[-1].position:
            self._round += 1
        super().run_segment(waypoint, rest, angles)
        self.moments[-1].position = waypoint.index + 1

    def _finish_gripper_action(self) -> None:
        """Bring the fingers to where they should be on the way to the first waypoint."""
        gripper, waypoints = self.runtime.gripper, self.runtime.task.get_waypoints()
        first, wanted = waypoints[self._first], _opening_before(waypoints, self._first)
        closes = first.gripper is not None and not first.releases
        opening = gripper.opening
        if wanted > 0.5 and opening.min() < wanted - 0.1 and (self._goes_back or not closes):
            self._move_fingers(wanted, release=True)
            self._frame()
        elif wanted <= 0.5 and not gripper.held and opening.max() > wanted + 0.05:
            self._move_fingers(wanted, release=False)
            self._frame()

    def _frame(self) -> None:
        runtime, robot = self.runtime, self.runtime.robot
        observation = Observation(
            joint_positions=robot.joint_positions,
            joint_velocities=robot.joint_velocities,
            gripper_open=float(runtime.gripper.is_open),
            gripper_pose=robot.tip_pose(),
            ignore_collisions=bool(self._ignores_collisions),
            misc={"joint_position_action": np.append(self._target, self._amount)},
        )
        position = self._first if self.waypoint is None else self.waypoint.index
        self.moments.append(Moment(_state(runtime), observation, self._round, position))
        self.frames.append(observation)


def _state(runtime: Runtime) -> FloatArray:
    low_dim = runtime.task.get_low_dim_state()
    return np.concatenate([runtime.robot.joint_positions, runtime.robot.fingers, low_dim])


# Action spaces -------------------------------------------------------------------------------------------------------


def _action(mode: ActionMode, runtime: Runtime, frames: Sequence[Observation]) -> FloatArray:
    """Return the action that leads from the first frame to the next, or to the next key frame."""
    arm = mode.arm_action_mode
    arm = arm.mode if isinstance(arm, SafeArm) else arm
    if isinstance(arm, EndEffectorPoseViaPlanning):
        *pose, gripper, ignore = key_frame_actions(frames)[0].tolist()
        more = [ignore] if mode.optional_values else []
        return np.array([*_pose_values(arm, runtime, np.array(pose)), *_gripper_values(mode, runtime, gripper), *more])
    command = np.asarray(frames[1].misc["joint_position_action"])
    return np.append(_arm_values(arm, runtime, command[:-1]), _gripper_values(mode, runtime, float(command[-1])))


def _arm_values(mode: ArmActionMode, runtime: Runtime, target: FloatArray) -> FloatArray:
    """Return the numbers that bring the joints to `target` (n,) within one tick [rad]."""
    q, v = runtime.robot.joint_positions, runtime.robot.joint_velocities
    if isinstance(mode, JointPosition):
        return target if mode.absolute_mode else target - q
    velocity = (target - q) / runtime.world.control_dt
    if isinstance(mode, JointVelocity):
        return velocity if mode.absolute_mode else velocity - v
    if isinstance(mode, EndEffectorVelocity):
        jacobian = runtime.model.jacobian(q, "tip" if mode.frame is RelativeFrame.EE else "world")
        return jacobian @ (velocity if mode.absolute_mode else velocity - v)
    if isinstance(mode, EndEffectorPoseViaIK):
        return _pose_values(mode, runtime, runtime.model.tip_pose(target))
    raise InvalidArgument("action_mode", mode, "has an arm mode that the expert's action cannot be expressed in")


def _pose_values(mode: PoseMode, runtime: Runtime, pose: FloatArray) -> FloatArray:
    """Return a tip pose (7,) as a pose mode takes it."""
    if not mode.is_relative:
        return pose
    here = runtime.robot.tip_pose()
    if mode.frame is RelativeFrame.EE:
        return relative(pose, here)
    turn = compose([0.0, 0.0, 0.0, *pose[3:]], inverse([0.0, 0.0, 0.0, *here[3:]]))
    return np.concatenate([pose[:3] - here[:3], turn[3:]])


def _gripper_values(mode: ActionMode, runtime: Runtime, amount: float) -> FloatArray:
    """Return the number that brings the fingers to an opening fraction."""
    gripper: GripperActionMode = mode.gripper_action_mode
    if isinstance(gripper, Discrete):
        return np.array([float(amount > 0.5)])
    if isinstance(gripper, GripperJointPosition):
        target = amount * runtime.description.gripper_open
        return np.array([target if gripper.absolute_mode else target - runtime.robot.fingers.mean()])
    raise InvalidArgument("action_mode", gripper, "has a gripper mode that the expert's action cannot be expressed in")
