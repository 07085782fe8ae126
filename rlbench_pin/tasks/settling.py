"""Settling of dropped bodies: step the world until they rest, and none rests on an edge."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from rlbench_pin.errors import BoundaryError, InvalidValue
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks.arguments import LOOSE_BODY, STEPPED_WORLD, as_object, as_objects
from rlbench_pin.values import as_record

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, World

FALL_TICKS = 20
"""Maximum number of control ticks (1 s) for bodies to fall or move."""
STILL_TICKS = 4
"""Number of successive control ticks without motion after which the wait ends."""
WATCH_TICKS = 10
"""Number of control ticks over which motion is measured."""
KNOCK_SPEED, KNOCKS = 3.0, 2
"""Angular speed that tips over bodies on an edge [rad/s], and number of repetitions."""
PUSH_SPEED, MAX_PUSHES = 0.4, 8
"""Speed that pushes apart bodies that do not come to rest [m/s], and maximum number of pushes."""
MAX_DRIFT = 2e-4
"""Largest motion [m] or rotation (part of a quaternion) of a body at rest within a second."""
REST_SPEED, REST_TURN = 5e-4, 1e-2
"""Speed [m/s] and angular speed [rad/s] below which a body is at rest; the first also applies to its joints, in either unit."""


def at_rest(bodies: Iterable[Body]) -> bool:
    """Return whether bodies and their joints are stationary at this instant; for a fixed body only its joints are checked."""
    for body in bodies:
        if not body.fixed:
            velocity = body.velocity.tolist()
            if math.hypot(*velocity[:3]) > REST_SPEED or math.hypot(*velocity[3:]) > REST_TURN:
                return False
        if any(abs(joint.velocity) > REST_SPEED for joint in body.joints.values()):
            return False
    return True


def settle(world: World, bodies: Sequence[Body], rng: np.random.Generator) -> None:
    """Let bodies fall, tip over bodies on an edge, and push apart bodies that lean or creep.

    Args:
        world: The world, which is stepped for several seconds.
        bodies: The dropped bodies.
        rng: Random generator of the directions of tipping.

    Raises:
        BoundaryError: The bodies still move after `MAX_PUSHES` pushes.
        InvalidValue: An argument is not a world, body or generator, or `bodies` is empty.
    """
    as_object(world, STEPPED_WORLD, "world")
    bodies = as_objects(bodies, LOOSE_BODY, "bodies")
    as_record(rng, np.random.Generator, "rng")
    if not bodies:
        raise InvalidValue("bodies", bodies, "has to contain at least one body")
    _wait(world, bodies)
    for _ in range(KNOCKS):
        _knock(world, bodies, rng)
    drift = _drift(world, bodies)
    for _ in range(MAX_PUSHES):
        if drift < MAX_DRIFT:
            return
        _knock(world, bodies, rng, PUSH_SPEED)
        drift = _drift(world, bodies)
    if drift >= MAX_DRIFT:
        names = ", ".join(body.name for body in bodies)
        raise BoundaryError(
            f"After {MAX_PUSHES} pushes one of {names} still moves by {drift:.1e} m a second. "
            "Drop fewer bodies, or into more space."
        )


def _knock(world: World, bodies: Sequence[Body], rng: np.random.Generator, push: float = 0.0) -> None:
    """Rotate each body about a random horizontal axis, push it away from the others [m/s], and wait."""
    for angle, body in zip(rng.uniform(0.0, 2.0 * np.pi, len(bodies)), bodies, strict=True):
        along = push * _away(body, bodies)
        body.set_velocity([*along, 0.0, KNOCK_SPEED * np.cos(angle), KNOCK_SPEED * np.sin(angle), 0.0])
    _wait(world, bodies)


def _away(body: Body, bodies: Sequence[Body]) -> FloatArray:
    """Return the horizontal direction (2,) from the middle of all bodies to one of them."""
    away = (body.position - np.mean([other.position for other in bodies], axis=0))[:2]
    return away / max(float(np.linalg.norm(away)), 1e-6)


def _wait(world: World, bodies: Sequence[Body]) -> None:
    """Wait until the bodies have not moved for `STILL_TICKS`, at most 1 s."""
    still = 0
    for _ in range(FALL_TICKS):
        still = still + 1 if _drift(world, bodies, 1) < MAX_DRIFT else 0
        if still == STILL_TICKS:
            return


def _drift(world: World, bodies: Sequence[Body], ticks: int = WATCH_TICKS) -> float:
    """Return the largest change of a pose component of any body per second, measured over some ticks."""
    before = [body.pose for body in bodies]
    for _ in range(ticks):
        world.step()
    moved = max(float(np.abs(body.pose - pose).max()) for body, pose in zip(bodies, before, strict=True))
    return moved / (ticks * world.control_dt)
