"""What an episode does to arm and surroundings: collisions with their force, and limits of the arm that are violated."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from rlbench_pin.environment.runtime import Runtime

LEAST_FORCE = 1.0
"""A contact that is lighter is none [N]."""
APART = 5
"""Control ticks without contact after which the next one with the same thing counts as another collision."""
POSITION_TOLERANCE = 1e-3
"""How far a joint may be beyond its limit before that counts [rad], or [m]."""
VELOCITY_TOLERANCE = 0.01
"""By which share of its limit a joint may be faster before that counts."""
POSITION, VELOCITY = "joint position", "joint velocity"


@dataclass
class Meter:
    """Counts, for one episode, what happens in every physics step and control tick.

    A collision is a contact of arm or hand with anything that they do not hold and are not meant to grasp; what the fingers do
    to the things of a task is the task itself, so that fingers collide with the room alone: table, walls, floor.
    """

    runtime: Runtime
    collisions: int = 0
    """Times that such a contact began."""
    max_force: float = 0.0
    """Largest normal force of arm and hand together on one such thing, in any physics step [N]."""
    violations: dict[str, int] = field(default_factory=dict)
    """Limit -> control ticks at whose end a joint was beyond it."""

    def __post_init__(self) -> None:
        """Note what may be touched by what."""
        self._arm, self._limits = self.runtime.description, self.runtime.model.limits
        self._room = frozenset(self.runtime.world.room)
        self._ticks = 0
        self._last: dict[str, int] = {}
        self._touched: set[str] = set()

    @contextmanager
    def running(self) -> Iterator[Meter]:
        """Count for the duration of a block."""
        world = self.runtime.world
        world.on_physics.insert(0, self._after_physics)
        try:
            with self.runtime.calling(after=self._after_tick):
                yield self
        finally:
            world.on_physics.remove(self._after_physics)

    def _after_physics(self) -> None:
        """Look at the contacts of the physics step before."""
        forces: dict[str, float] = {}
        for (link, thing), force in self.runtime.robot.contact_forces().items():
            if not self._may_touch(link, thing):
                forces[thing] = forces.get(thing, 0.0) + force
        for thing, force in forces.items():
            if force >= LEAST_FORCE:
                self._touched.add(thing)
                self.max_force = max(self.max_force, force)

    def _may_touch(self, link: str, thing: str) -> bool:
        if thing in self.runtime.gripper.grasped:
            return True
        if link in self._arm.finger_links:
            return thing not in self._room
        return link == self._arm.hand_link and thing in self.runtime.task.get_graspable_objects()

    def _after_tick(self) -> None:
        self._after_physics()
        self._ticks += 1
        for thing in self._touched:
            if self._ticks - self._last.get(thing, -APART - 1) > APART:
                self.collisions += 1
            self._last[thing] = self._ticks
        self._touched.clear()
        q, v = self.runtime.robot.joint_positions, self.runtime.robot.joint_velocities
        if not self._limits.contains(q, POSITION_TOLERANCE):
            self._count(POSITION)
        if bool(np.any(np.abs(v) > (1.0 + VELOCITY_TOLERANCE) * self._limits.velocity)):
            self._count(VELOCITY)

    def _count(self, limit: str) -> None:
        self.violations[limit] = self.violations.get(limit, 0) + 1
