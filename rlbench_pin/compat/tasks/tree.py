"""The objects of a task as one thing: where they are, going back there, and placing one of them with all that it carries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rlbench_pin.errors import BoundaryError, RlbenchPinError
from rlbench_pin.sim import World
from rlbench_pin.spatial import FloatArray, pose_to_se3
from rlbench_pin.tasks import PLACEMENT_AREA
from rlbench_pin.tasks.boxes import rotated
from rlbench_pin.tasks.placement import MAX_TURNS, footprint
from rlbench_pin.tasks.task import RotationBounds


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


def place_thing(world: World, name: str, rng: np.random.Generator, bounds: RotationBounds) -> None:
    """Place one body or frame at random in the placement area, with all that moves with it.

    Args:
        world: The world.
        name: What is moved.
        rng: Random generator.
        bounds: Lowest and highest roll, pitch, yaw on top of the present orientation [rad].

    Raises:
        BoundaryError: It does not fit at any of the orientations drawn.
    """
    thing = world.body(name) if name in world.bodies else world.frame(name)
    start = np.array(thing.pose)
    low, high = _patch(world, name)
    for _ in range(MAX_TURNS):
        quaternion = rotated(rng.uniform(*bounds), start[3:])
        corners = np.array([[x, y, 0.0] for x in (low[0], high[0]) for y in (low[1], high[1])])
        patch = corners @ pose_to_se3(np.concatenate([np.zeros(3), quaternion])).rotation.T
        first = PLACEMENT_AREA.low - patch[:, :2].min(axis=0)
        last = PLACEMENT_AREA.high - patch[:, :2].max(axis=0)
        if np.all(first <= last):
            thing.set_pose(np.concatenate([rng.uniform(first, last), start[2:3], quaternion]))
            return
    raise BoundaryError(
        f"'{name}' with the footprint {np.round(high - low, 3).tolist()} m does not fit on the table at any orientation tried. "
        "Give it narrower base_rotation_bounds() or name a smaller thing in boundary_root()."
    )


def _patch(world: World, name: str) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and highest x, y (2,) of what has to fit, in the frame of the thing [m]."""
    if world.spec.placement.footprint is not None:
        return footprint(world)
    if name in world.bodies:
        low, high = world.bodies[name].bounds()
        return low[:2], high[:2]
    half = np.asarray(getattr(world.frame(name), "size", np.zeros(3)), dtype=float)[:2] / 2.0
    return -half, half
