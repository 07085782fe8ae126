"""The objects of a task as one thing: where they are, going back there, and what of them has to fit on the table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rlbench_pin.compat.things import Element
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.sim import World
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks.placement import footprint


@dataclass(frozen=True, eq=False)
class TreeState:
    """Where the objects of a task are."""

    bodies: dict[str, tuple[FloatArray, FloatArray]]
    """Name -> pose (7,) and velocity (6,)."""
    joints: dict[str, tuple[float, float]]
    """Name -> value and speed."""
    frames: dict[str, tuple[str, FloatArray]]
    """Name -> parent and pose (7,) in the frame of the parent."""


class TreeChanged(RlbenchPinError, RuntimeError):
    """The task has other objects than it had."""


def save_tree(world: World) -> TreeState:
    """Return where the objects of the task are."""
    bodies = {name: (body.pose, body.velocity) for name, body in world.bodies.items()}
    joints = {joint.name: joint.state() for body in world.bodies.values() for joint in body.joints.values()}
    return TreeState(bodies, joints, {name: frame.state() for name, frame in world.frames.items()})


def restore_tree(world: World, state: TreeState) -> None:
    """Put the objects of the task back; the arm stays.

    Raises:
        TreeChanged: The task has other objects than it had.
    """
    if set(world.bodies) != set(state.bodies):
        changed = ", ".join(sorted(set(world.bodies) ^ set(state.bodies)))
        raise TreeChanged(
            f"The task had {len(state.bodies)} objects and has {len(world.bodies)} now (other: {changed}). "
            "Remove what was created, then restore."
        )
    for name, (parent, local) in state.frames.items():
        world.frame(name).set_state(parent, local)
    for name, (pose, velocity) in state.bodies.items():
        body = world.body(name)
        body.place(pose)
        if not body.fixed:
            body.set_velocity(velocity)
    for name, (position, speed) in state.joints.items():
        world.joint(name).set_state(position, speed)


def thing_name(thing: Any) -> str:
    """Return what the world calls an object of the scene: a view, or the name itself; for a part the object that it is of."""
    name = thing if isinstance(thing, str) else str(thing.element.name)
    return name.partition("/")[0]


def patch_of(world: World, element: Element) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and highest x, y (2,) of what has to fit where a thing is placed, in the frame of the thing [m]."""
    name = thing_name(element.name)
    if element.kind == "root" or world.spec.placement.footprint is not None:
        return footprint(world)
    if name in world.bodies:
        low, high = world.bodies[name].bounds()
        return low[:2], high[:2]
    half = np.asarray(getattr(world.frames.get(name), "size", np.zeros(3)), dtype=float)[:2] / 2.0
    return -half, half
