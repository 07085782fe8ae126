"""The arm's motors in the physics server, and the torques that carry the arm's own weight."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.sim.bodies.model import LoadedModel
from rlbench_pin.sim.client import bullet
from rlbench_pin.spatial import FloatArray


class Motors:
    """Motors of some joints of the loaded robot.

    Motors carry the arm's weight by torques that are worked out beforehand, once per tick; the solver, which begins each
    physics step from nothing, then only has to find what is missing, in a few iterations instead of fifty.

    Args:
        model: The loaded robot; it stands where it stays.
        joints: PyBullet's numbers of the n joints.
        efforts: Largest torques (n,) [N m], weight included.
    """

    def __init__(self, model: LoadedModel, joints: Sequence[int], efforts: FloatArray) -> None:
        self._model, self._client = model, model.client
        self._joints, self._efforts = list(joints), efforts
        self._movable = sorted(info.index for info in model.joints.values())
        self._places = [self._movable.index(joint) for joint in joints]
        self._still = [0.0] * len(self._movable)
        self._zeros, self._ones = [0.0] * len(joints), [1.0] * len(joints)
        # PyBullet keeps the masses of the first call until its server is built again: those of the robot's file.
        self._client.change(bullet.calculateInverseDynamics, model.uid, self._still, self._still, self._still)

    def weight(self) -> FloatArray:
        """Return the torques (n,) that hold the robot's own weight where it is now [N m], at most the efforts."""
        states = bullet.getJointStates(self._model.uid, self._movable, physicsClientId=self._client.id)
        positions = [state[0] for state in states]
        torques = bullet.calculateInverseDynamics(
            self._model.uid, positions, self._still, self._still, physicsClientId=self._client.id
        )
        weight = np.array([torques[place] for place in self._places])
        return np.minimum(np.maximum(weight, -self._efforts), self._efforts)

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
