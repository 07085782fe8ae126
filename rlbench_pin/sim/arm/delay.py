"""Delayed and lost commands of the arm's motors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rlbench_pin.sim.arm.control import ArmControl, SimRobot


@dataclass(frozen=True)
class DelayState:
    """State of a delay; None in `waiting` is a lost command."""

    waiting: tuple[ArmControl | None, ...]
    wanted: ArmControl
    arrived: ArmControl
    random: Mapping[str, Any]


class CommandDelay:
    """Delays commands of the arm's motors by some control ticks, and loses some; a `StateKeeper` of a world.

    Args:
        robot: The arm; its present command is the first to arrive.
        latency: Control ticks between a command and its arrival.
        loss: Probability that a command is lost on its way. The command before it then stays active for one more tick.
        seed: Seed of the losses.
    """

    def __init__(self, robot: SimRobot, latency: int, loss: float, seed: int) -> None:
        self._robot, self._loss = robot, loss
        self._rng = np.random.default_rng(seed)
        self._wanted = self._arrived = robot.control
        self._waiting: tuple[ArmControl | None, ...] = (robot.control,) * latency
        self.lost = False
        """Whether the command that was given in the last tick is lost."""

    def pass_on(self) -> None:
        """Send the motors the command that arrives at the start of this tick."""
        given = self._robot.control
        if given is not self._arrived:
            self._wanted = given
        self.lost = bool(self._rng.random() < self._loss)
        arriving, *waiting = (*self._waiting, None if self.lost else self._wanted)
        self._waiting = tuple(waiting)
        before = self._arrived
        command = before if arriving is None else arriving
        follows_on = command.mode == before.mode == "position"
        reference = before.reference if follows_on else self._robot.joint_positions
        self._robot.set_control(ArmControl(command.mode, command.target, reference, given.torques))

    def end_tick(self) -> None:
        """Store the command of the motors after the start of the tick."""
        self._arrived = self._robot.control

    def state(self) -> DelayState:
        """Return the state of the delay."""
        return DelayState(self._waiting, self._wanted, self._arrived, self._rng.bit_generator.state)

    def set_state(self, state: object) -> None:
        """Restore a state from `state()`."""
        assert isinstance(state, DelayState)
        self._waiting, self._wanted, self._arrived = state.waiting, state.wanted, state.arrived
        self._rng.bit_generator.state = state.random
