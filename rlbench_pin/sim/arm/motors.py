"""The arm's motors in the physics server, and the torques that the arm's own weight and inertia ask for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rlbench_pin.sim.bodies.model import LoadedModel
from rlbench_pin.sim.client import bullet
from rlbench_pin.spatial import FloatArray


@dataclass(frozen=True)
class Effort:
    """What the motors of n joints do in a physics step."""

    torques: list[float]
    """Applied whatever happens (n,) [N m]."""
    spare: list[float]
    """Most that a motor adds to reach its goal (n,) [N m]."""


class Motors:
    """Motors of some joints of the loaded robot.

    The torques that the arm's own weight and inertia ask for are worked out beforehand, by inverse dynamics. PyBullet's solver,
    which begins each physics step from nothing, then only has to find what is missing, in a few passes instead of fifty.

    Args:
        model: The loaded robot; it stands where it stays.
        joints: PyBullet's numbers of the n joints.
        efforts: Largest torques (n,) [N m].

    Attributes:
        movable: PyBullet's numbers of all joints of the robot that can move, fingers among them.
    """

    def __init__(self, model: LoadedModel, joints: Sequence[int], efforts: FloatArray) -> None:
        self._model, self._client = model, model.client
        self._joints, self._efforts = list(joints), efforts.tolist()
        self.movable = sorted(info.index for info in model.joints.values())
        self._places = [self.movable.index(joint) for joint in joints]
        self._still = [0.0] * len(self.movable)
        self._zeros, self._ones = [0.0] * len(joints), [1.0] * len(joints)
        # PyBullet keeps the masses of the first call until its server is built again: those of the robot's file.
        self._client.change(bullet.calculateInverseDynamics, model.uid, self._still, self._still, self._still)

    def efforts(self, positions: list[float], now: FloatArray, wanted: FloatArray, timestep: float) -> tuple[Effort, Effort]:
        """Return what the motors do in the first physics step, which changes the joint velocities, and in those that follow.

        A change that asks for more than the motors can give is left to the solver.

        Args:
            positions: Those of `movable` joints.
            now: Measured joint velocities (n,) [rad/s].
            wanted: Joint velocities to reach (n,) [rad/s].
            timestep: Physics step [s].
        """
        velocities = now.tolist()
        later = self._within(self._dynamics(positions, velocities, self._zeros))
        first = self._dynamics(positions, velocities, ((wanted - now) / timestep).tolist())
        if any(abs(torque) > most for torque, most in zip(first, self._efforts, strict=True)):
            first = later
        return Effort(first, self._left(first)), Effort(later, self._left(later))

    def _dynamics(self, positions: list[float], velocities: list[float], accelerations: list[float]) -> list[float]:
        """Torques (n,) [N m] that the robot alone asks for."""
        v, a = self._still.copy(), self._still.copy()
        for place, velocity, acceleration in zip(self._places, velocities, accelerations, strict=True):
            v[place], a[place] = velocity, acceleration
        torques = bullet.calculateInverseDynamics(self._model.uid, positions, v, a, physicsClientId=self._client.id)
        return [torques[place] for place in self._places]

    def _within(self, torques: list[float]) -> list[float]:
        """The nearest torques that the motors can give."""
        return [min(max(torque, -most), most) for torque, most in zip(torques, self._efforts, strict=True)]

    def _left(self, torques: list[float]) -> list[float]:
        """What motors that give `torques` can add."""
        return [most - abs(torque) for torque, most in zip(torques, self._efforts, strict=True)]

    def follow(self, positions: list[float], velocities: list[float], gain: float, forces: list[float]) -> None:
        """Hold on to a motion from the next physics step on.

        Args:
            positions: Where the joints should be (n,) [rad].
            velocities: How fast they should be (n,) [rad/s].
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
        """Turn at velocities (n,) [rad/s] from the next physics step on, with torques of at most `forces` (n,) [N m]."""
        bullet.setJointMotorControlArray(
            self._model.uid,
            self._joints,
            bullet.VELOCITY_CONTROL,
            targetVelocities=velocities,
            forces=forces,
            physicsClientId=self._client.id,
        )

    def release(self) -> None:
        """Exert nothing from the next physics step on."""
        self.turn(self._zeros, self._zeros)

    def push(self, torques: list[float]) -> None:
        """Apply torques (n,) [N m] in the next physics step alone, beside what the motors do."""
        bullet.setJointMotorControlArray(
            self._model.uid, self._joints, bullet.TORQUE_CONTROL, forces=torques, physicsClientId=self._client.id
        )
