"""Distractor objects: everyday objects on the table, away from the task and its motions."""

from __future__ import annotations

import numpy as np

from rlbench_pin.environment.reset import come_to_rest
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.scene.reader import resolve_asset
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.spatial import TABLE_HEIGHT, pose_at
from rlbench_pin.tasks.boxes import OrientedBox
from rlbench_pin.tasks.placement import footprint

OBJECTS = (
    "mug", "soup", "spam", "tuna", "coffee", "mustard", "sugar", "tomato", "sponge", "rubber_duck", "chicken",
    "drink_bottle", "coaster", "toilet_roll", "shoe_left", "drinking_glass",
)  # fmt: skip
"""Objects of the catalogue to choose from, except those that the task uses."""
AREA = np.array([[-0.05, -0.55], [0.75, 0.55]])
"""Lowest and highest x, y of their positions [m]."""
MARGIN = 0.05
"""Minimum gap to the footprint, the objects and the waypoints of the task [m]."""
LEAST_SIDE = 0.1
"""Minimum distance of distractors from each waypoint, along x and y [m]; more for larger graspable objects."""
ARM_RADIUS = 0.25
"""Radius of the circle about the base of the arm that stays free [m]."""
TRIES = 60
"""Maximum number of positions to try for one object."""


def add_distractors(runtime: Runtime, count: int, seed: int) -> tuple[str, ...]:
    """Put objects on the table, and return their names: fewer than `count` if there is not enough space.

    The first objects do not depend on `count`.

    Args:
        runtime: The running task, at the start of an episode.
        count: Number of objects.
        seed: Seed of objects and positions.
    """
    world, rng = runtime.world, np.random.default_rng(seed)
    used = {resolve_asset(world.spec, body.asset).stem for body in (*world.spec.body, *world.spawned.values())}
    taken = [*_task_boxes(runtime), *(_grown(OrientedBox.of(body.bounds(), body.pose)) for body in world.bodies.values())]
    names: list[str] = []
    for asset in rng.permutation([name for name in OBJECTS if name not in used]).tolist()[:count]:
        name, draws = f"distractor_object{len(names)}", rng.uniform(size=(TRIES, 3))
        spec = BodySpec(name=name, asset=f"objects/{asset}/{asset}.urdf")
        body = world.add_body(name, spec)
        low, high = body.bounds()
        for x, y, turn in draws:
            place = AREA[0] + np.array([x, y]) * (AREA[1] - AREA[0])
            pose = pose_at((*place, TABLE_HEIGHT - low[2] + 0.001), yaw=2.0 * np.pi * turn)
            box = OrientedBox.of(np.stack([low, high]), pose)
            if np.linalg.norm(place - runtime.description.base_pose[:2]) > ARM_RADIUS and not any(map(box.overlaps, taken)):
                body.set_pose(pose)
                taken.append(_grown(box))
                names.append(name)
                break
        else:
            world.remove_body(name)
    come_to_rest(world)
    return tuple(names)


def _task_boxes(runtime: Runtime) -> list[OrientedBox]:
    """Return the space that stays free: above the footprint of the task, and around its waypoints for what the gripper holds."""
    world = runtime.world
    low, high = footprint(world)
    corners = np.array([[*(low - MARGIN), -0.1], [*(high + MARGIN), 1.0]])
    held = [np.ptp(world.body(name).bounds(), axis=0) for name in runtime.task.get_graspable_objects()]
    side = max([LEAST_SIDE, *(float(lengths[:2].max()) for lengths in held)])
    near = np.array([[-side, -side, -0.6], [side, side, 0.6]])
    around = [OrientedBox.of(near, pose_at(waypoint.pose[:3].tolist())) for waypoint in runtime.task.get_waypoints()]
    return [OrientedBox.of(corners, world.root.pose), *around]


def _grown(box: OrientedBox) -> OrientedBox:
    return OrientedBox(box.center, box.axes, box.half + MARGIN)
