"""The gripper: motion of the fingers at a given speed and force, and grasped bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import InvalidActionError, InvalidValue
from rlbench_pin.robot import geometry
from rlbench_pin.sim.arm.control import JointMotors, SimRobot
from rlbench_pin.sim.arm.grasp import Attachment, Attachments
from rlbench_pin.sim.body import Body, touched_links
from rlbench_pin.sim.client import bullet
from rlbench_pin.sim.frames import volume_meets
from rlbench_pin.spatial import FloatArray, pose_to_se3
from rlbench_pin.values import as_number

_GAIN = 0.05
"""Share of the position error that a finger motor removes in one physics step; more makes a friction grip tremble."""
_OPEN = 0.9  # fraction of the range above which a finger counts as open
_MOVED = 1e-3  # motion in a tick above which the gripper counts as moving [m]
_GEAR_FORCE = 200.0  # of the coupling between the fingers [N]
_GEAR_ERP, _STIFF_GEAR_ERP = 0.2, 0.9  # share of the difference between the fingers that the coupling removes in a physics step
_SQUEEZE_SPEED = 0.3
"""Closing speed that the motors of blocked fingers ask for [m/s]: the object keeps the fingers from it, so that the motors reach
their force in 40 passes of the solver. At the speed of closing they press with 10 N of 40 N; at 1 m/s they fling a rope away."""
_SQUEEZE_PASSES = 100
"""Most passes of the solver while the fingers squeeze: with `PASSES` objects turn between the pads when the arm turns fast."""
_LINKAGE_PASSES = 400
"""Most passes of the solver where pads hang on linkages: with `PASSES` they sink 7 mm into a block, with 400 0.1 mm."""
_BLOCKED = 1.5e-3
"""How far both fingers are behind the reference when they count as blocked [m]; without an object it is 0.01 mm at most."""
_PAD_TORSION = 0.007  # torsional friction: torque about the line between the pads per force, for pads of 18 mm [m]


@dataclass(frozen=True, eq=False)
class FingerControl:
    """Command of the finger motors, complete enough for an exact continuation."""

    target: FloatArray
    """Finger joint positions to go to (2,) [m]."""
    reference: FloatArray
    """How far the motion to the target has come (2,) [m]."""
    speed: float
    """[m/s]."""
    force: float
    """Largest force of one finger [N]."""
    last: FloatArray
    """Measured positions at the end of the last tick but one (2,) [m]."""


class SimGripper:
    """Two coupled fingers and the bodies fixed to the gripper.

    Args:
        robot: The arm that carries the gripper.
        find: Looks up a body by name.
        bodies: Returns all bodies of the scene.

    Attributes:
        attaches: Whether closing fixes bodies to the gripper; otherwise only friction holds them.
    """

    def __init__(self, robot: SimRobot, find: Callable[[str], Body], bodies: Callable[[], tuple[Body, ...]]) -> None:
        self._robot, self._find, self._bodies = robot, find, bodies
        self.attaches = True
        self._model, self._client = robot.model, robot.model.client
        description = robot.description
        self._grip = robot.grip
        self._joints = [self._model.joints[name].index for name in self._grip.drives]
        self._motors = JointMotors(self._model, self._joints)
        self._range = description.gripper_open
        self._default_force, self._default_speed = description.gripper_force, description.grip_speed
        self._attachments = Attachments(self._model, description)
        self._attachments.restore_order(bodies())
        self._couple()
        self._fingers = [self._model.link_index(link) for link in description.finger_links]
        for index in self._fingers:  # anchors keep a friction grip from creeping
            self._client.change(
                bullet.changeDynamics, self._model.uid, index, lateralFriction=description.pad_friction, frictionAnchor=1
            )
        self._control: FingerControl
        self._stop()
        robot.on_reset.append(lambda fingers_too: self._stop() if fingers_too else None)

    def _couple(self) -> None:
        """Couple the fingers, like the gear of a real gripper."""
        left, right = self._joints
        self._gear = self._gear_of(left, right, 1.0, _GEAR_ERP)
        for follower, way in zip(self._grip.followers, self._grip.follows, strict=True):
            drive, joint = (self._model.joints[name].index for name in (way.joint, follower))
            gear = self._gear_of(drive, joint, way.ratio, _STIFF_GEAR_ERP)
            if way.offset:
                self._client.change(bullet.changeConstraint, gear, relativePositionTarget=-way.offset / way.ratio)
            self._client.change(
                bullet.setJointMotorControl2, self._model.uid, joint, bullet.VELOCITY_CONTROL, targetVelocity=0.0, force=0.0
            )

    def _gear_of(self, first: int, second: int, ratio: float, erp: float) -> int:
        """Couple two joints: the second moves `ratio` times as far as the first. Return the number of the constraint."""
        uid, change = self._model.uid, self._client.change
        gear: int = change(bullet.createConstraint, uid, first, uid, second, bullet.JOINT_GEAR, [1, 0, 0], [0, 0, 0], [0, 0, 0])
        change(bullet.changeConstraint, gear, gearRatio=-1.0 / ratio, erp=erp, maxForce=_GEAR_FORCE)
        return gear

    def rely_on_friction(self) -> None:
        """Hold objects by friction only: the pads resist torsion, the fingers stay centred, and no body is fixed.

        Fingers that an object stops press on it with the full force of `set_target`.

        Call this while the world is built, so that `build_again` repeats it.
        """
        self.attaches = False
        self._client.change(bullet.changeConstraint, self._gear, gearRatio=-1, erp=_STIFF_GEAR_ERP, maxForce=_GEAR_FORCE)
        for index in self._fingers:
            self._client.change(bullet.changeDynamics, self._model.uid, index, spinningFriction=_PAD_TORSION)

    # Fingers ---------------------------------------------------------------------------------------------------------

    @property
    def opening(self) -> FloatArray:
        """Opening fraction of each finger (2,), 0 closed to 1 open."""
        return self._robot.fingers / self._range

    @property
    def is_open(self) -> bool:
        """True if every finger is more than 90 % open."""
        return all(part > _OPEN for part in self.opening.tolist())

    @property
    def moving(self) -> bool:
        """True if a finger moved in the last tick by more than 1 mm, or by half of the distance that its speed allows."""
        least = min(_MOVED, 0.5 * self._control.speed * self._robot.tick)
        return any(abs(way) > least for way in (self._robot.fingers - self._control.last).tolist())

    @property
    def squeezes(self) -> bool:
        """True if objects are held by friction only and an object stops both fingers."""
        return not self.attaches and bool((self._robot.fingers - self._control.reference > _BLOCKED).all())

    def set_target(self, amount: float, speed: float | None = None, force: float | None = None) -> None:
        """Drive the fingers to an opening fraction in the coming ticks.

        Args:
            amount: 0 closed to 1 open.
            speed: Finger speed [m/s]; None is the closing speed on objects.
            force: Largest force of one finger [N]; None is the default of the gripper.

        Raises:
            InvalidActionError: `amount` is not in 0..1, or speed or force is not positive and finite.
        """
        try:
            amount = as_number(amount, "The opening fraction, 0 shut to 1 open,", least=0.0, most=1.0)
            speed = self._default_speed if speed is None else as_number(speed, "The finger speed [m/s]", above=0.0)
            strength = self._default_force if force is None else as_number(force, "The force of a finger [N]", above=0.0)
        except InvalidValue as error:
            raise InvalidActionError(str(error)) from error
        here, target = self._robot.fingers, np.full(2, amount * self._range)
        squeezes, closes = self.squeezes, bool((target < here).all())
        if squeezes and not closes:
            self._attachments.forget_contacts(self._find(name) for name in self.between_fingers())
        reference = self._control.reference if squeezes and closes else here
        self._control = FingerControl(target, reference, speed, strength, here)

    def hold(self) -> None:
        """Hold the fingers at their positions; fingers that squeeze an object keep squeezing it."""
        if not self.squeezes:
            self._stop()

    def _stop(self) -> None:
        here = self._robot.fingers
        self._control = FingerControl(here, here, self._default_speed, self._default_force, here)

    # Holding ---------------------------------------------------------------------------------------------------------

    @property
    def grasped(self) -> tuple[str, ...]:
        """Names of the bodies fixed to the gripper."""
        return self._attachments.names

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the bodies that the gripper holds: those fixed to it or, without attachments, those between the fingers."""
        return self.grasped if self.attaches else self.between_fingers()

    def between_fingers(self) -> tuple[str, ...]:
        """Return the names of the graspable bodies that both fingers touch and that overlap the box between the pads.

        Only contacts with links that `register_graspable_objects` allows count. The box has `pad_size` along tip x and z, and
        along tip y the gap between the fingers minus 2 mm (at least 1 mm).
        """
        return tuple(body.name for body in self._bodies() if body.graspable and self._is_gripped(body) and self._in_gap(body))

    def _is_gripped(self, body: Body) -> bool:
        """Whether each finger touches a graspable link of the body."""
        links = {body.model.links[name] for name in body.grasp_links or body.model.links}
        return all(links & touched_links(self._model, finger, body.model) for finger in self._fingers)

    def reaches_between_fingers(self, name: str) -> bool:
        """Whether a body, graspable or not, overlaps the box between the pads."""
        return self._in_gap(self._find(name))

    def closes_on_something(self) -> bool:
        """Whether any body, graspable or not, overlaps the box between the pads."""
        return any(body.collides and self._in_gap(body) for body in self._bodies())

    def _in_gap(self, body: Body) -> bool:
        left, right = self._robot.fingers
        width, height = self._robot.description.pad_size
        box = geometry.volume("box", (width, max(left + right - 0.002, 0.001), height))
        T_world_tip = pose_to_se3(self._robot.tip_pose())
        T_world_box = T_world_tip * pin.SE3(np.eye(3), np.array([0.0, 0.5 * (right - left), 0.0]))
        return volume_meets(box, geometry.radius(box), T_world_box, body)

    def grasp(self, name: str) -> bool:
        """Fix a body to the gripper at its pose, and hold the fingers; return False if it is already held or cannot move."""
        body = self._find(name)
        if name in self.grasped or body.fixed:
            return False
        self._attachments.attach(body)
        self._stop()
        return True

    def release(self) -> None:
        """Release all bodies; the fingers do not move."""
        for name in self.grasped:
            self._attachments.detach(name)

    # Ticks and state -------------------------------------------------------------------------------------------------

    @property
    def control(self) -> FingerControl:
        """Command of the finger motors."""
        return self._control

    def set_control(self, control: FingerControl) -> None:
        """Restore a stored command."""
        self._control = control

    def attachments(self) -> tuple[Attachment, ...]:
        """Bodies fixed to the gripper."""
        return self._attachments.state()

    def set_attachments(self, attachments: tuple[Attachment, ...]) -> None:
        """Replace all attachments by `attachments`."""
        self.release()
        self._attachments.restore_order(self._bodies())
        for attachment in attachments:
            self._attachments.add(attachment, self._find(attachment.body))

    def begin_tick(self) -> None:
        """Compute the motion of the fingers in this tick."""
        control, robot = self._control, self._robot
        here = robot.fingers
        lead, most = control.speed * robot.timestep / _GAIN, control.speed * robot.tick
        self._squeezing = self.squeezes
        if self._squeezing:
            self._client.allow_passes(_SQUEEZE_PASSES)
        elif self._grip.followers:
            self._client.allow_passes(_LINKAGE_PASSES)
        fingers = zip(control.target.tolist(), control.reference.tolist(), here.tolist(), strict=True)  # few: no arrays
        starts, ends = [], []
        for target, reference, at in fingers:
            start = min(max(reference, at - lead), at + lead)
            starts.append(start)
            ends.append(start + min(max(target - start, -most), most))
        moves = [end - start for start, end in zip(starts, ends, strict=True)]
        self._paces = [(start, move / robot.substeps) for start, move in zip(starts, moves, strict=True)]
        self._feed = [move / robot.tick for move in moves]
        self._control = FingerControl(control.target, np.array(ends), control.speed, control.force, here)

    def drive(self, substep: int) -> None:
        """Command the finger motors for physics step `substep` of this tick; stationary fingers keep their command."""
        if substep and (self._squeezing or not any(self._feed)):
            return
        positions, speeds = [start + substep * pace for start, pace in self._paces], self._feed
        forces = [self._control.force] * 2
        if self._squeezing:
            speeds = [-_SQUEEZE_SPEED] * 2
        if self._grip.travels:
            levers = self._grip.lever(np.array(positions)).tolist()
            positions = self._grip.drive_values(np.array(positions)).tolist()
            speeds = [speed * lever for speed, lever in zip(speeds, levers, strict=True)]
            forces = [force / abs(lever) for force, lever in zip(forces, levers, strict=True)]
        if self._squeezing:
            self._motors.turn(speeds, forces)
        else:
            self._motors.follow(positions, speeds, _GAIN, forces)
