"""Sleep of stationary bodies: they cost no time until an awake body comes near them or the world is changed.

PyBullet's solver skips a sleeping body as long as all bodies with overlapping bounding boxes sleep too. It simulates the body
again in the first physics step in which the box of an awake body overlaps. If that body leaves without moving it, it sleeps on.
This module decides which bodies sleep, by the number of consecutive ticks at rest. PyBullet's saved states do not contain this.
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
    """Sleeping bodies. Every change of the world except a change of colour wakes all bodies.

    A sleeping body starts to move one physics step late, except if an awake body comes near. Fixed bodies sleep from the end of
    the first tick on, so that PyBullet skips contacts between them and sleeping bodies.

    Args:
        client: The physics server.
        bodies: The bodies of the world by name; later bodies are added to this dict.
        room: Table, floor and walls, by name.
    """

    def __init__(self, client: PhysicsClient, bodies: Mapping[str, Body], room: Mapping[str, Body]) -> None:
        self._client, self._bodies, self._room = client, bodies, room
        self._loose: dict[str, _Loose] = {}
        self._fixed: list[int] = []
        self._fixed_sleep = False
        self._thrown: dict[int, tuple[tuple[float, ...], tuple[float, ...]]] = {}
        self._changes, self._drowsy = -1, False

    # Ticks -----------------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Advance one physics step; all bodies wake if the world has changed since the last step."""
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
        """Wake all bodies, and list the present ones."""
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
        """Restore velocities that were set while a body slept: PyBullet sets them to zero in the step in which it wakes."""
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
        """Names of the bodies at rest, with the number of consecutive ticks."""
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
        """Record that the server was built again; no body sleeps there."""
        self._loose, self._fixed, self._changes, self._drowsy = {}, [], -1, False
        self._thrown.clear()

    def go_on(self, quiet: Iterable[tuple[str, int]]) -> None:
        """Restore which bodies sleep; the state of the world was restored after `rouse` before.

        Args:
            quiet: Value of `quiet` when the state was saved.
        """
        self._changes = -1
        self._wake()
        for name, ticks in quiet:
            body = self._loose[name]
            body.ticks = min(ticks, QUIET_TICKS)
            if body.ticks == QUIET_TICKS:
                self._tell([body.uid], _SLEEP)
