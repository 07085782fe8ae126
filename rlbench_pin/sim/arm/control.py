"""Control of the simulated arm: commands of its motors."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.robot.fingers import fingers_of
from rlbench_pin.sim.body import ContactReader, LoadedModel
from rlbench_pin.sim.client import PASSES, bullet
from rlbench_pin.spatial import FloatArray, pose_to_se3
from rlbench_pin.urdf import CONTINUOUS
from rlbench_pin.values import action_vector, as_flag, as_names, finite_vector

DriveMode = Literal["position", "velocity", "torque"]
"""Control mode of the arm's motors."""


@dataclass(frozen=True, eq=False)
class ArmControl:
    """Command of the arm's motors, complete enough for an exact continuation."""

    mode: DriveMode
    target: FloatArray
    """Positions [rad], velocities [rad/s] or torques [N m], shape (n,)."""
    reference: FloatArray
    """How far the interpolation towards a position target has come [rad], shape (n,)."""
    torques: FloatArray | None = None
    """Torques of the last tick where they were commanded, for the simulator does not report those [N m], shape (n,)."""


@dataclass(frozen=True)
class Effort:
    """Commands of the motors of n joints in a physics step."""

    torques: list[float]
    """Feed-forward torques, always applied (n,) [N m]."""
    spare: list[float]
    """Most that a motor adds to reach its goal (n,) [N m]."""


class JointMotors:
    """Motors of some joints of the loaded robot.

    Args:
        model: The loaded robot.
        joints: PyBullet's numbers of the n joints.
    """

    def __init__(self, model: LoadedModel, joints: Sequence[int]) -> None:
        self._model, self._client, self._joints = model, model.client, list(joints)
        self._ones = [1.0] * len(joints)

    def follow(self, positions: list[float], velocities: list[float], gain: float, forces: list[float]) -> None:
        """Track a motion from the next physics step on.

        Args:
            positions: Target joint positions (n,) [rad].
            velocities: Target joint velocities (n,) [rad/s].
            gain: Share of the position error that a motor removes in one physics step.
            forces: Largest torques (n,) [N m].
        """
        bullet.setJointMotorControlArray(
            self._model.uid,
            self._joints,
            bullet.POSITION_CONTROL,
            targetPositions=positions,
            targetVelocities=velocities,
            positionGains=[gain] * len(positions),
            velocityGains=self._ones,
            forces=forces,
            physicsClientId=self._client.id,
        )

    def turn(self, velocities: list[float], forces: list[float]) -> None:
        """Move at joint velocities (n,) [rad/s] from the next physics step on, with torques of at most `forces` (n,) [N m]."""
        bullet.setJointMotorControlArray(
            self._model.uid,
            self._joints,
            bullet.VELOCITY_CONTROL,
            targetVelocities=velocities,
            forces=forces,
            physicsClientId=self._client.id,
        )


class Motors(JointMotors):
    """Motors of the arm.

    Inverse dynamics gives the torques for the weight and inertia of the arm in advance. PyBullet's solver has no warm start; with
    these torques it only solves for the rest, in a few iterations instead of fifty.

    Args:
        model: The loaded robot, at its final base pose.
        joints: PyBullet's numbers of the n joints.
        efforts: Largest torques (n,) [N m].

    Attributes:
        movable: PyBullet's numbers of all movable joints of the robot, fingers included.
    """

    def __init__(self, model: LoadedModel, joints: Sequence[int], efforts: FloatArray) -> None:
        super().__init__(model, joints)
        self._efforts = efforts.tolist()
        self.movable = sorted(info.index for info in model.joints.values())
        self._places = [self.movable.index(joint) for joint in joints]
        self._still = [0.0] * len(self.movable)
        self._zeros = [0.0] * len(joints)
        # PyBullet keeps the masses of the first call until its server is built again: those of the robot's file.
        self._client.change(bullet.calculateInverseDynamics, model.uid, self._still, self._still, self._still)

    def efforts(self, positions: list[float], now: FloatArray, wanted: FloatArray, timestep: float) -> tuple[Effort, Effort]:
        """Return the motor commands of the first physics step, which changes the joint velocities, and of the following ones.

        If the change needs more than the largest torques, the solver computes it.

        Args:
            positions: Positions of the `movable` joints.
            now: Measured joint velocities (n,) [rad/s].
            wanted: Target joint velocities (n,) [rad/s].
            timestep: Physics step [s].
        """
        velocities = now.tolist()
        later = self._within(self._dynamics(positions, velocities, self._zeros))
        first = self._dynamics(positions, velocities, ((wanted - now) / timestep).tolist())
        if any(abs(torque) > most for torque, most in zip(first, self._efforts, strict=True)):
            first = later
        return Effort(first, self._left(first)), Effort(later, self._left(later))

    def _dynamics(self, positions: list[float], velocities: list[float], accelerations: list[float]) -> list[float]:
        """Torques (n,) [N m] for the weight and inertia of the robot alone."""
        v, a = self._still.copy(), self._still.copy()
        for place, velocity, acceleration in zip(self._places, velocities, accelerations, strict=True):
            v[place], a[place] = velocity, acceleration
        torques = bullet.calculateInverseDynamics(self._model.uid, positions, v, a, physicsClientId=self._client.id)
        return [torques[place] for place in self._places]

    def _within(self, torques: list[float]) -> list[float]:
        """Return torques, limited to the largest torques of the motors."""
        return [min(max(torque, -most), most) for torque, most in zip(torques, self._efforts, strict=True)]

    def _left(self, torques: list[float]) -> list[float]:
        """Return the torques that the motors can add to `torques`."""
        return [most - abs(torque) for torque, most in zip(torques, self._efforts, strict=True)]

    def release(self) -> None:
        """Exert no torque from the next physics step on."""
        self.turn(self._zeros, self._zeros)

    def push(self, torques: list[float]) -> None:
        """Apply torques (n,) [N m] in the next physics step only, in addition to the motors."""
        bullet.setJointMotorControlArray(
            self._model.uid, self._joints, bullet.TORQUE_CONTROL, forces=torques, physicsClientId=self._client.id
        )


POSITION_GAIN = 0.2
"""Share of the position error that a motor removes in one physics step."""
_PASSES_WITHOUT_PATH = 60
"""Most passes of the solver while the arm follows velocities or torques: their changes are not planned, and joints that drag each
other need more to get there."""
_CATCH_UP = 0.1
"""Share of the velocity limits that a lagging joint may add to full speed."""
_FAST_CHANGE = 0.5
"""Change of speed in a tick, as a share of the velocity limits, above which the motors are watched in every physics step."""


class SimRobot:
    """Arm and fingers of the simulated robot; returned arrays belong to the caller.

    Args:
        model: The loaded robot.
        description: Joint order, tip, gripper and fingers.
        contacts: Reader of contact points.
        timestep: Physics step [s].
        substeps: Physics steps in a control tick.

    Attributes:
        tick: Length of a control tick [s].
        lower: Lower joint limits (n,) [rad].
        upper: Upper joint limits (n,) [rad].
        velocity_limits: Largest joint speeds (n,) [rad/s].
        effort_limits: Largest motor torques (n,) [N m].
        position_gain: Share of the position error that a motor removes in one physics step.
        grip: The fingers.
        on_reset: Functions that `reset_configuration` calls; the argument is whether it set the fingers too.
        hidden_links: Links that are not drawn in images, by PyBullet's numbers of body and link; see `show`.
    """

    def __init__(
        self, model: LoadedModel, description: RobotDescription, contacts: ContactReader, timestep: float, substeps: int
    ) -> None:
        self.model, self.description, self._contacts = model, description, contacts
        self._client = model.client
        self.position_gain = POSITION_GAIN
        self.timestep, self.substeps, self.tick = timestep, substeps, timestep * substeps
        self._counts = np.arange(substeps)[:, None]
        self.grip = fingers_of(description)
        infos = [model.joints[name] for name in description.arm_joints]
        self._arm = [info.index for info in infos]
        self._joints = self._arm + [model.joints[name].index for name in self.grip.drives]
        self._followers = [model.joints[name].index for name in self.grip.followers]
        ranges = [(i.lower, i.upper) if np.isfinite(i.lower) else CONTINUOUS for i in infos]
        self.lower, self.upper = np.array(ranges).T.copy()
        self.velocity_limits = np.array([i.velocity for i in infos])
        self.effort_limits = np.array([i.effort for i in infos])
        self._tip = model.link_index(description.tip_frame)
        self._states: FloatArray | None = None
        self._kept_torques: FloatArray | None = None
        self.on_reset: list[Callable[[bool], None]] = []
        self.hidden_links: frozenset[tuple[int, int]] = frozenset()
        self._goals: FloatArray | None = None
        self._feed: list[float] = []
        self._control = ArmControl("velocity", np.zeros(len(infos)), np.zeros(len(infos)))
        self._still = Effort([0.0] * len(infos), [0.0] * len(infos))
        self._first = self._later = self._still
        self._prepare_dynamics()
        self._motors = Motors(model, self._arm, self.effort_limits)
        self._measures = [*self._joints, *(joint for joint in self._motors.movable if joint not in self._joints)]
        self._order = [self._measures.index(joint) for joint in self._motors.movable]
        self.reset_configuration(description.home, [description.gripper_open] * len(self.grip.drives))

    def _prepare_dynamics(self) -> None:
        for index in range(-1, len(self.model.links) - 1):
            self._client.change(bullet.changeDynamics, self.model.uid, index, linearDamping=0.0, angularDamping=0.0)

    # Measuring -------------------------------------------------------------------------------------------------------

    def _measured(self) -> FloatArray:
        """Positions, velocities and motor torques of all movable joints, (3, m); read once per tick."""
        if self._states is None:
            states = bullet.getJointStates(self.model.uid, self._measures, physicsClientId=self._client.id)
            self._states = np.array([(s[0], s[1], s[3]) for s in states]).T
            self._states[2, : len(self._arm)] += self._later.torques
            if self._kept_torques is not None:
                self._states[2] = self._kept_torques
        return self._states

    def forget_measurements(self) -> None:
        """Read the joints again at the next request; called after a change of the world."""
        self._states = None

    def keep_torques(self, keep: bool = True) -> None:
        """Report the present motor torques until the next tick or until this is switched off, even if the server changes them."""
        self._kept_torques = self._measured()[2].copy() if as_flag(keep, "keep") else None

    @property
    def joint_positions(self) -> FloatArray:
        """Arm joint positions (n,) [rad]."""
        return self._measured()[0, : len(self._arm)].copy()

    @property
    def joint_velocities(self) -> FloatArray:
        """Arm joint velocities (n,) [rad/s]."""
        return self._measured()[1, : len(self._arm)].copy()

    @property
    def joint_torques(self) -> FloatArray:
        """Torques (n,) that the motors applied in the last physics step [N m]."""
        commanded = self._commanded_torques()
        if commanded is not None:
            return commanded.copy()
        return self._measured()[2, : len(self._arm)].copy()

    @property
    def fingers(self) -> FloatArray:
        """Finger positions (2,), the distance of each pad from the centre [m]."""
        return self.grip.positions(self._measured()[0, len(self._arm) : len(self._joints)].copy())

    def joint_states(self) -> FloatArray:
        """Positions, velocities and motor torques of the joints of arm and fingers, shape (3, n + fingers)."""
        return self._measured()[:, : len(self._joints)].copy()

    def tip_pose(self) -> FloatArray:
        """Pose (7,) of the tip frame in the world."""
        return self.model.link_pose_at(self._tip)

    def link_pose(self, link: str) -> FloatArray:
        """Pose (7,) of the URDF frame of a link in the world."""
        return self.model.link_pose(link)

    def link_poses(self) -> dict[str, FloatArray]:
        """Poses (7,) of all link frames in the world, base first."""
        return {name: self.model.link_pose(name) for name in self.model.links}

    def touch_forces(self) -> FloatArray:
        """Contact forces (6,) on the fingers [N]: left x, y, z, right x, y, z, each in the frame of its finger."""
        return np.concatenate([self._contact_force(link) for link in self.description.finger_links])

    def _contact_force(self, link: str) -> FloatArray:
        index = self.model.link_index(link)
        points = bullet.getContactPoints(bodyA=self.model.uid, linkIndexA=index, physicsClientId=self._client.id)
        if not points:
            return np.zeros(3)
        force = sum(np.multiply(p[9], p[7]) + np.multiply(p[10], p[11]) + np.multiply(p[12], p[13]) for p in points)
        return pose_to_se3(self.link_pose(link)).rotation.T @ force

    def show(self, links: Collection[str] | None = None) -> None:
        """Draw only these links of the robot in images, or all of them if None; the physics does not change.

        Raises:
            InvalidValue: The argument is not a list of names.
            UnknownName: The robot has no such link.
        """
        shown = self.model.links if links is None else as_names(links, "links")
        hidden = {self.model.link_index(name) for name in self.model.links} - {self.model.link_index(name) for name in shown}
        self.hidden_links = frozenset((self.model.uid, index) for index in hidden)

    def touching(self) -> tuple[str, ...]:
        """Names of the bodies that arm or gripper touch, sorted."""
        return self._contacts.touching(self.model.uid)

    def contact_forces(self) -> dict[tuple[str, str], float]:
        """Return (link, other body) -> sum of the normal forces between them in the last physics step [N]."""
        return self._contacts.forces(self.model.uid)

    def _commanded_torques(self) -> FloatArray | None:
        """Torques of the last tick if torques were commanded."""
        return self._control.target if self._control.mode == "torque" else self._control.torques

    # Commanding ------------------------------------------------------------------------------------------------------

    @property
    def mode(self) -> DriveMode:
        """The present control mode."""
        return self._control.mode

    def set_position_targets(self, q: Sequence[float] | FloatArray) -> None:
        """Move to joint positions (n,) [rad] in the next tick, on a straight line in joint space; then hold them.

        Targets are clipped to the joint limits. A motion beyond the velocity limits takes more ticks.
        """
        target = action_vector(q, len(self._arm), "joint position target").clip(self.lower, self.upper)
        reference = self._control.reference if self.mode == "position" else self.joint_positions
        self._control = ArmControl("position", target, reference, self._commanded_torques())

    def set_velocity_targets(self, v: Sequence[float] | FloatArray) -> None:
        """Move the joints at velocities (n,) [rad/s] until the next command; clipped to the velocity limits."""
        target = action_vector(v, len(self._arm), "joint velocity target")
        velocity = target.clip(-self.velocity_limits, self.velocity_limits)
        self._control = ArmControl("velocity", velocity, self.joint_positions, self._commanded_torques())

    def set_torques(self, tau: Sequence[float] | FloatArray) -> None:
        """Apply torques (n,) [N m] in every physics step until the next command; clipped to the effort limits."""
        target = action_vector(tau, len(self._arm), "joint torque")
        self._control = ArmControl("torque", target.clip(-self.effort_limits, self.effort_limits), self.joint_positions)

    def reset_configuration(self, q: Sequence[float] | FloatArray, fingers: Sequence[float] | FloatArray | None = None) -> None:
        """Set the arm to joint positions at once, with zero velocity, and hold them.

        Args:
            q: Arm joint positions (n,) [rad].
            fingers: Finger positions (2,) [m]; None does not change them.
        """
        positions, joints = finite_vector(q, len(self._arm), "configuration"), self._arm
        values = positions.tolist()
        if fingers is not None:
            opening = finite_vector(fingers, len(self.grip.drives), "finger positions")
            values += self.grip.joint_values(opening.clip(0.0, self.description.gripper_open)).tolist()
            joints = self._joints + self._followers
        for index, value in zip(joints, values, strict=True):
            self._client.change(bullet.resetJointState, self.model.uid, index, value)
        self._control = ArmControl("position", positions, positions)
        self.forget_measurements()
        for callback in self.on_reset:
            callback(fingers is not None)

    def place_base(self, pose: FloatArray) -> None:
        """Set the pose (7,) of the base of the arm in the world."""
        self.model.set_base_pose(pose)
        self.forget_measurements()

    def set_joint_states(self, positions: FloatArray, velocities: FloatArray) -> None:
        """Set positions and velocities (n + fingers,) of the joints of arm and fingers; motor commands do not change."""
        given = ((positions, "vector of positions"), (velocities, "vector of velocities"))
        q, v = (finite_vector(x, len(self._joints), what) for x, what in given)
        drives = slice(len(self._arm), None)
        followers = self.grip.follower_values(q[drives]), self.grip.follower_speeds(v[drives])
        both = (np.append(x, more).tolist() for x, more in zip((q, v), followers, strict=True))
        for index, position, velocity in zip(self._joints + self._followers, *both, strict=True):
            self._client.change(bullet.resetJointState, self.model.uid, index, position, velocity)
        self.forget_measurements()

    # Ticks -----------------------------------------------------------------------------------------------------------

    @property
    def control(self) -> ArmControl:
        """Command of the motors."""
        return self._control

    def set_control(self, control: ArmControl) -> None:
        """Restore a stored command."""
        self._control = control
        self.forget_measurements()

    def begin_tick(self) -> None:
        """Compute the motor commands of this tick."""
        self._kept_torques = None
        if self._control.torques is not None:  # the motors report those of this tick
            self._control = replace(self._control, torques=None)
        self._goals, self._watches = None, False
        self._client.allow_passes(PASSES if self.mode == "position" else _PASSES_WITHOUT_PATH)
        if self.mode == "torque":
            self._motors.release()
            self._first = self._later = self._still
            return
        measured = self._measured()
        velocities, places = measured[1, : len(self._arm)], measured[0].tolist()
        positions = [places[k] for k in self._order]
        feed = self._begin_position_tick(velocities) if self.mode == "position" else self._control.target
        self._first, self._later = self._motors.efforts(positions, velocities, feed, self.timestep)
        self._feed = feed.tolist()

    def _begin_position_tick(self, velocities: FloatArray) -> FloatArray:
        """Compute the reference positions of all physics steps, and return the reference velocities (n,) [rad/s]."""
        control = self._control
        self._lead = self._allowed_lead(control)
        measured = self._measured()[0, : len(self._arm)]
        start = control.reference.clip(measured - self._lead, measured + self._lead)
        move = control.target - start
        excess = float((np.abs(move) / (self.velocity_limits * self.tick)).max())
        if excess > 1.0:
            move /= excess
        feed: FloatArray = move / self.tick
        self._goals = start + self._counts * (move / self.substeps)
        self._watches = bool((np.abs(feed - velocities) > _FAST_CHANGE * self.velocity_limits).any())
        self._control = ArmControl("position", control.target, start + move if excess > 1.0 else control.target)
        return feed

    def _allowed_lead(self, control: ArmControl) -> FloatArray:
        """Largest lead of the reference over a lagging arm at which the arm stays within the velocity limits [rad]."""
        feed = np.abs(control.target - control.reference) / self.tick
        spare = np.maximum(self.velocity_limits - feed, _CATCH_UP * self.velocity_limits)
        return spare * self.timestep / self.position_gain

    def _position_goals(self, goals: FloatArray, substep: int) -> list[float]:
        """Return the motor positions of one physics step; they wait for the arm if velocities change fast."""
        wanted: FloatArray = goals[substep]
        if self._watches and substep:
            states = bullet.getJointStates(self.model.uid, self._arm, physicsClientId=self._client.id)
            measured = np.array([s[0] for s in states])
            wanted = wanted.clip(measured - self._lead, measured + self._lead)
        return wanted.tolist()

    def drive(self, substep: int) -> None:
        """Command the motors for physics step `substep` of this tick; unchanged commands are not sent again."""
        if self.mode == "torque":
            self._motors.push(self._control.target.tolist())
            return
        effort = self._later if substep else self._first
        if self._goals is not None:
            if substep < 2 or self._watches or any(self._feed):
                goals = self._position_goals(self._goals, substep)
                self._motors.follow(goals, self._feed, self.position_gain, effort.spare)
        elif substep < 2:
            self._motors.turn(self._feed, effort.spare)
        self._motors.push(effort.torques)
