"""The planner's action in any state of an episode, in any action space: labels for learning on-policy (DAgger)."""

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
from rlbench_pin.environment.actions.pose import EndEffectorPoseViaIK, EndEffectorPoseViaPlanning
from rlbench_pin.environment.actions.safe_arm import SafeArm
from rlbench_pin.environment.demos import DemoPlayer, try_play
from rlbench_pin.environment.episode import EpisodeOrigin
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DemoError, InvalidArgument
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Waypoint
from rlbench_pin.values import as_record

SAME = 2e-3
"""A state matches a predicted one if joints, fingers and objects differ by less than this [rad, m]."""
MOST_TRIES = 8
"""Maximum number of waypoints from which the expert tries the remainder of a demonstration."""


def expert_action(task_environment: TaskEnvironment, action_mode: ActionMode | None = None) -> FloatArray:
    """Return the action of the planner in the present state of an episode.

    The expert plans the remainder of a demonstration from the measured state and simulates it, until one reaches the goal. It
    restores the world and returns the first action. It plans again only when the episode deviates from the prediction.

    Args:
        task_environment: The running task, in any state of an episode.
        action_mode: Mode of the action; None is the one of the environment. The arm mode can be `JointPosition`, `JointVelocity`,
            `EndEffectorVelocity`, `EndEffectorPoseViaIK` or `EndEffectorPoseViaPlanning`, also within `SafeArm`; the gripper mode
            `Discrete` or `GripperJointPosition`.

    Returns:
        The action, of the shape (n,) of `action_mode`. With `EndEffectorPoseViaPlanning` and `MoveArmThenGripper` it is the
        next key frame, and the last value is 1 if collisions are ignored, else 0.

    Raises:
        DemoError: No remainder of a demonstration reaches the goal from here.
        InvalidArgument: The action mode is not one of these.
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
    """A predicted moment of an episode."""

    state: FloatArray
    """Joints [rad], fingers [m] and the state of the task, for comparison."""
    observation: Observation
    """Joints, tip and gripper, and the command before this moment."""
    round: int
    """Number of completed rounds through the list of waypoints."""
    position: int
    """Position of the next waypoint in the list."""


@dataclass
class Foresight:
    """The predicted remainder of an episode."""

    episode: EpisodeOrigin | None = None
    """The predicted episode."""
    moments: list[Moment] = field(default_factory=list)
    """The present moment at the last call, and the moments after it."""
    time: float = 0.0
    """Simulated time of the last call [s]."""

    def frames(self, runtime: Runtime, episode: EpisodeOrigin) -> list[Observation]:
        """Return the present frame and the frames that follow it in a demonstration.

        Raises:
            DemoError: No demonstration was found.
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
        """Return the position of the predicted moment that matches the present state; None if none matches, or only the last."""
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
        """Return the round, and the position in the list of the waypoint to continue with."""
        if not self.moments:
            return 0, _after_grasp(runtime)
        near = min(self.moments, key=lambda moment: float(np.abs(moment.state - state).max()))
        return near.round, min(near.position, len(runtime.task.get_waypoints()) - 1)


def _after_grasp(runtime: Runtime) -> int:
    """Return the position of the first waypoint after the grasp of the held object; 0 if nothing is held."""
    waypoints = runtime.task.get_waypoints()
    for place, waypoint in enumerate(waypoints):
        grasps = waypoint.gripper is not None and not waypoint.releases
        if grasps and any(waypoint.frame.moves_with(name) for name in runtime.gripper.held):
            return min(place + 1, len(waypoints) - 1)
    return 0


def _opening_before(waypoints: Sequence[Waypoint], position: int) -> float:
    """Return the opening fraction of the gripper during the motion to the waypoint at a position in the list."""
    return waypoints[position - 1].gripper_amount if position > 0 else 1.0


class _Ahead(DemoPlayer):
    """Plays the remainder of a demonstration from a waypoint, and records its moments."""

    def __init__(self, runtime: Runtime, round_: int, position: int, *, goes_back: bool) -> None:
        super().__init__(runtime)
        self.moments: list[Moment] = []
        self._round, self._first, self._goes_back = round_, position, goes_back
        self._amount = 1.0 if runtime.gripper.is_open else 0.0

    def play(self) -> list[Observation]:
        """Apply the effects without motion of the waypoints before the first one, then play from there."""
        task = self.runtime.task
        for _ in range(self._round):
            task.should_repeat_waypoints()
        for waypoint in task.get_waypoints()[: self._first]:
            waypoint.run_start_hook()
            if waypoint.gripper is not None:
                self._planner.grasp = None if waypoint.releases else waypoint
        return super().play()

    def run_segment(self, waypoint: Waypoint, rest: Sequence[Waypoint], angles: Sequence[float]) -> None:
        """Move the fingers to their expected opening, run the segment, and record the next waypoint."""
        if len(self.moments) == 1:
            self._finish_gripper_action()
        if waypoint.index < self.moments[-1].position:
            self._round += 1
        super().run_segment(waypoint, rest, angles)
        self.moments[-1].position = waypoint.index + 1

    def _finish_gripper_action(self) -> None:
        """Move the fingers to their expected opening before the motion to the first waypoint."""
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
        return np.array(
            [*arm.action_to(np.array(pose), runtime.robot.tip_pose()), *_gripper_values(mode, runtime, gripper), *more]
        )
    command = np.asarray(frames[1].misc["joint_position_action"])
    return np.append(_arm_values(arm, runtime, command[:-1]), _gripper_values(mode, runtime, float(command[-1])))


def _arm_values(mode: ArmActionMode, runtime: Runtime, target: FloatArray) -> FloatArray:
    """Return the values of the arm mode that move the joints to `target` (n,) within one tick [rad]."""
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
        return mode.action_to(runtime.model.tip_pose(target), runtime.robot.tip_pose())
    raise InvalidArgument("action_mode", mode, "has an arm mode that cannot express the action of the expert")


def _gripper_values(mode: ActionMode, runtime: Runtime, amount: float) -> FloatArray:
    """Return the value of the gripper mode for an opening fraction."""
    gripper: GripperActionMode = mode.gripper_action_mode
    if isinstance(gripper, Discrete):
        return np.array([float(amount > 0.5)])
    if isinstance(gripper, GripperJointPosition):
        target = amount * runtime.description.gripper_open
        return np.array([target if gripper.absolute_mode else target - runtime.robot.fingers.mean()])
    raise InvalidArgument("action_mode", gripper, "has a gripper mode that cannot express the action of the expert")
