"""Puts resting bodies to sleep, so that they cost no time until something comes near them or changes the world.

PyBullet's solver leaves out what sleeps as long as every body whose box overlaps theirs sleeps too, and simulates it again in the
very physics step in which the box of something awake overlaps. When that has gone without moving them they sleep on. This
module decides which bodies sleep, by how many ticks in a row they were at rest; the states that PyBullet saves do not contain it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from rlbench_pin.sim.body import Body
from rlbench_pin.sim.client import PhysicsClient, bullet

QUIET_TICKS = 5
"""A body sleeps when it was at rest at the end of so many ticks in a row."""
QUIET_SPEED, QUIET_TURN = 5e-4, 2e-2
"""Speed [m/s] and speed of turning [rad/s] below which a body is at rest."""
_WAKING = 4e-4
"""Squares of speed and speed of turning, added, at which PyBullet wakes a body for the rest of a tick [m^2/s^2]."""
_SLEEP = bullet.ACTIVATION_STATE_ENABLE_SLEEPING | bullet.ACTIVATION_STATE_SLEEP
_WAKE = bullet.ACTIVATION_STATE_DISABLE_SLEEPING | bullet.ACTIVATION_STATE_WAKE_UP
_ZERO = (0.0, 0.0, 0.0)


@dataclass
class _Loose:
    """A body that may sleep."""

    uid: int
    ticks: int = 0
    """At the end of how many ticks in a row it was at rest, `QUIET_TICKS` at most."""


class Resting:
    """Sleeping bodies. Every change of the world but that of a colour wakes all bodies.

    A body that slept begins to move one physics step late, except where something awake comes near. Bodies that are fixed sleep
    from the end of the first tick on, so that PyBullet does not look for contacts between them and what sleeps.

    Args:
        client: The physics server.
        bodies: The bodies of the world by name, those of later times included.
        room: Table, floor and walls, by name.
    """

    def __init__(self, client: PhysicsClient, bodies: Mapping[str, Body], room: Mapping[str, Body]) -> None:
        self._client, self._bodies, self._room = client, bodies, room
        self._loose: dict[str, _Loose] = {}
        self._fixed: list[int] = []
        self._fixed_sleep = False
        self._thrown: dict[int, tuple[tuple[float, ...], tuple[float, ...]]] = {}
        self._changes, self._drowsy = -1, False

    @property
    def asleep(self) -> tuple[str, ...]:
        """Names of the bodies that sleep."""
        return tuple(name for name, ticks in self.quiet if ticks == QUIET_TICKS)

    # Ticks -----------------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Advance one physics step; all bodies wake if something has changed the world since the last one."""
        if self._thrown:
            self._throw_again()
        if self._client.changes != self._changes:
            self._wake()
        self._client.step()

    def end_tick(self) -> None:
        """Find the bodies at rest."""
        if self._thrown:
            self._throw_again()
        if not self._fixed_sleep and self._loose:
            self._tell(self._fixed, _SLEEP)
            self._fixed_sleep = True
        identifier = self._client.id
        for body in self._loose.values():
            linear, angular = bullet.getBaseVelocity(body.uid, physicsClientId=identifier)
            slept = body.ticks == QUIET_TICKS
            if slept and linear == _ZERO and angular == _ZERO:
                continue
            if math.hypot(*linear) < QUIET_SPEED and math.hypot(*angular) < QUIET_TURN:
                body.ticks = min(body.ticks + 1, QUIET_TICKS)
                if body.ticks == QUIET_TICKS:  # also when it slept, for PyBullet may have woken it
                    self._tell([body.uid], _SLEEP)
                continue
            body.ticks = 0
            if slept:
                self._tell([body.uid], _WAKE)

    def _wake(self) -> None:
        """Wake all bodies, and find out which there are now."""
        self._throw_again()
        now = [*self._room.values(), *self._bodies.values()]
        present = {body.model.uid for body in now}
        slept = [b.uid for b in self._loose.values() if b.ticks == QUIET_TICKS and b.uid in present]
        velocities = {uid: bullet.getBaseVelocity(uid, physicsClientId=self._client.id) for uid in slept}
        self._thrown = {uid: velocity for uid, velocity in velocities.items() if velocity != (_ZERO, _ZERO)}
        self._tell(slept, _WAKE)
        if self._fixed_sleep:
            self._tell([uid for uid in self._fixed if uid in present], _WAKE)
        rigid = [body for body in now if not body.joints]
        self._loose = {body.name: _Loose(body.model.uid) for body in rigid if not body.fixed}
        self._fixed, self._fixed_sleep = [body.model.uid for body in rigid if body.fixed], False
        self._changes = self._client.changes

    def _throw_again(self) -> None:
        """Give velocities back that were set while a body slept: in the step in which it wakes PyBullet makes them zero."""
        for uid, velocity in self._thrown.items():
            if bullet.getBaseVelocity(uid, physicsClientId=self._client.id) == (_ZERO, _ZERO):
                bullet.resetBaseVelocity(uid, *velocity, physicsClientId=self._client.id)
        self._thrown.clear()

    def _tell(self, uids: Iterable[int], state: int) -> None:
        self._drowsy |= state == _SLEEP
        for uid in uids:
            bullet.changeDynamics(uid, -1, activationState=state, sleepThreshold=_WAKING, physicsClientId=self._client.id)

    # State -----------------------------------------------------------------------------------------------------------

    @property
    def quiet(self) -> tuple[tuple[str, int], ...]:
        """Names of the bodies that were at rest, and at the end of how many ticks in a row."""
        if self._client.changes != self._changes:
            return ()
        return tuple((name, body.ticks) for name, body in self._loose.items() if body.ticks)

    def rouse(self) -> None:
        """Wake all bodies at once, by a physics step; a state of the server has to be restored afterwards."""
        self._changes = -1
        self._wake()
        if self._drowsy:
            self._client.step()
        self._thrown.clear()
        self._drowsy = False

    def forget(self) -> None:
        """Take note that the server was emptied and built again, where nobody sleeps."""
        self._loose, self._fixed, self._changes, self._drowsy = {}, [], -1, False
        self._thrown.clear()

    def go_on(self, quiet: Iterable[tuple[str, int]]) -> None:
        """Let those sleep that slept when a state was saved, which has been restored after `rouse`.

        Args:
            quiet: What `quiet` was.
        """
        self._changes = -1
        self._wake()
        for name, ticks in quiet:
            body = self._loose[name]
            body.ticks = min(ticks, QUIET_TICKS)
            if body.ticks == QUIET_TICKS:
                self._tell([body.uid], _SLEEP)
