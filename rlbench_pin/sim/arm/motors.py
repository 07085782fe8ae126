"""The arm's motors in the physics server, and the torques that the arm's own weight and inertia ask for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from rlbench_pin.sim.bodies.model import LoadedModel
from rlbench_pin.sim.client import bullet
from rlbench_pin.spatial import FloatArray

_SHARE = 0.9
"""Share of what the arm's weight leaves of a torque that is planned for changing speeds; the rest is for what planning misses."""
_LONGEST_CHANGE = 0.6
"""Longest planned change of speeds, as a share of a tick; a longer one is left to the solver, as fast as each motor can."""
_LEAST_ROOM = 1e-9
"""Room of a motor that the arm's weight takes altogether [N m]."""


@dataclass(frozen=True)
class Effort:
    """What the motors of n joints do in each of m physics steps."""

    torques: list[list[float]]
    """Applied whatever happens (m, n) [N m]."""
    spare: list[list[float]]
    """Most that a motor adds to reach its goal (m, n) [N m]."""
    speeds: list[list[float]] = field(default_factory=list)
    """Goals of motors that follow velocities, in each physics step in which goal or spare change (k, n) [rad/s]."""


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

    def following(self, positions: list[float], now: FloatArray, wanted: FloatArray, timestep: float, substeps: int) -> Effort:
        """Return what motors that follow positions do: the first physics step changes the joint velocities, the rest keep them.

        A change that asks for more than the motors can give is left to the solver.

        Args:
            positions: Those of `movable` joints.
            now: Measured joint velocities (n,) [rad/s].
            wanted: Joint velocities to reach (n,) [rad/s].
            timestep: Physics step [s].
            substeps: Physics steps of the tick.
        """
        velocities = now.tolist()
        later = self._within(self._dynamics(positions, velocities, self._zeros))
        first = self._dynamics(positions, velocities, ((wanted - now) / timestep).tolist())
        if any(abs(torque) > most for torque, most in zip(first, self._efforts, strict=True)):
            first = later
        torques = [first, *[later] * (substeps - 1)]
        return Effort(torques, [self._left(first), *[self._left(later)] * (substeps - 1)])

    def turning(self, positions: list[float], now: list[float], wanted: list[float], timestep: float, substeps: int) -> Effort:
        """Return what motors that follow velocities do: they change them together, as fast as they can, and keep them.

        Torques of constant velocities are interpolated between those at the beginning and at the end of the tick. A change
        that takes too long is left to the solver, torques and all: it turns each joint as fast as its motor can.

        Args:
            positions: Those of `movable` joints.
            now: Measured joint velocities (n,) [rad/s].
            wanted: Joint velocities to reach (n,) [rad/s].
            timestep: Physics step [s].
            substeps: Physics steps of the tick.
        """
        changes = [w - v for w, v in zip(wanted, now, strict=True)]
        changing = self._dynamics(positions, now, [change / timestep for change in changes])
        begin = self._dynamics(positions, wanted, self._zeros)
        there = positions.copy()
        for place, velocity in zip(self._places, wanted, strict=True):
            there[place] += velocity * substeps * timestep
        end = self._within(self._dynamics(there, wanted, self._zeros))
        extra = [torque - steady for torque, steady in zip(changing, begin, strict=True)]
        count = self._steps(extra, begin, substeps)
        if count == 0:
            return Effort([self._zeros] * substeps, [self._efforts] * substeps, [wanted])
        begin = self._within(begin)
        drift = [(last - first) / substeps for first, last in zip(begin, end, strict=True)]
        torques = (np.array(begin) + np.arange(substeps)[:, None] * np.array(drift)).tolist()
        left = self._left([max(abs(a), abs(b)) for a, b in zip(begin, end, strict=True)])
        for k in range(count):
            torques[k] = self._within([torque + more / count for torque, more in zip(torques[k], extra, strict=True)])
        spare = [*(self._left(torques[k]) for k in range(count)), *[left] * (substeps - count)]
        speeds = [[v + k / count * change for v, change in zip(now, changes, strict=True)] for k in range(1, count + 1)]
        return Effort(torques, spare, [*speeds, wanted][:substeps])

    def _steps(self, extra: list[float], steady: list[float], substeps: int) -> int:
        """Physics steps in which the motors can do what takes torques `extra` in one; 0 when that is too long to be planned."""
        rooms = (_SHARE * (most - abs(torque)) for torque, most in zip(steady, self._efforts, strict=True))
        demand = max(abs(torque) / max(room, _LEAST_ROOM) for torque, room in zip(extra, rooms, strict=True))
        return max(1, math.ceil(demand)) if demand <= _LONGEST_CHANGE * substeps else 0

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
