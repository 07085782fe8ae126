"""Doors of a running world, its parts, and its environment; after each case the world goes back to where it was."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from rlbench_pin import tasks
from rlbench_pin.environment import Discrete, Environment, JointPosition, MoveArmThenGripper, TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.sim import CameraView, World, look_at
from tests.fuzz.doors import Door, Fresh, functions, methods

TASK = "open_drawer"
INNER = (
    "hold", "set_state", "restore", "save", "set_ticks", "pull", "drive", "set_control", "set_attachments", "configure",
    "region", "sensor", "remove_body",
)  # fmt: skip
"""How world and environment keep each other's state, in the types that `state()` returns."""
LOOSE = {"Body.set_color": "color"}
LONG = ("get_demos", "try_demo", "reset_to_demo", "step")
"""These have tests of their own."""


@contextmanager
def opened(name: str = TASK) -> Iterator[TaskEnvironment]:
    """A task with joints, bodies, frames and waypoints, at the start of an episode."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config(), seed=0) as env:
        task = env.get_task(name)
        task.reset(seed=1)
        yield task


def samples(task: TaskEnvironment) -> dict[str, object]:
    """Return good arguments by name."""
    world = task.world
    body = next(body for body in world.bodies.values() if body.joints)
    joint = next(iter(body.joints.values()))
    view = CameraView(pose=look_at((1.0, 1.0, 1.5), (0.0, 0.0, 1.0)), fov=1.0, size=(16, 16), near=0.05, far=5.0)
    nine = world.robot.joint_states()
    plain = {
        "name": body.name, "pose": np.array(body.pose), "local": np.array(body.pose), "target": np.array(body.pose),
        "position": np.zeros(3), "parent": "world", "velocity": np.zeros(6), "color": np.array([1.0, 0.0, 0.0]), "colors": {},
        "fixed": True, "collides": True, "link": body.links[0], "frame": np.array(body.pose),
        "directions": np.eye(3), "q": task.runtime.model.home,
        "v": np.zeros(7), "tau": np.zeros(7), "amount": 1.0, "point": np.zeros(3), "body": body.name, "camera": view,
        "arrays": world.arrays(), "rng": Fresh(lambda: np.random.default_rng(0)), "seed": 3,
    }  # fmt: skip
    special = {
        "ObjectJoint.set_position.position": 0.05, "ObjectJoint.set_lock.position": 0.05,
        "Body.joint.name": joint.name.split("/")[1],
        "World.joint.name": joint.name, "World.frame.name": "waypoint0", "SimRobot.link_pose.link": "panda_hand",
        "SimRobot.show.links": None,
        "SimRobot.set_joint_states.positions": nine[0], "SimRobot.set_joint_states.velocities": nine[1],
        "TaskEnvironment.set_variation.v": 0, "TaskEnvironment.set_factors.factors": "friction:1",
        "World.add_body.name": Fresh(_Counter("added")),
        "World.add_body.spec": BodySpec(name="x", asset="objects/cube_small/cube_small.urdf"),
    }  # fmt: skip
    return plain | special


class _Counter:
    """Makes names that were not used before."""

    def __init__(self, word: str) -> None:
        self.word, self.count = word, 0

    def __call__(self) -> str:
        self.count += 1
        return f"{self.word}{self.count}"


class _Patch:
    """A region, as placing sees it; the scene has none."""

    name = "patch"
    pose = np.array([0.25, 0.0, 0.8, 0.0, 0.0, 0.0, 1.0])
    size = np.array([1.5, 1.5, 0.0])


def placing_doors(world: World) -> list[Door]:
    """Return those of what tasks place, settle and grip."""
    body = next(body for body in world.bodies.values() if body.joints)
    good: dict[str, object] = {
        "regions": [_Patch()], "element": body, "elements": [body], "others": [world.frame("waypoint0")], "world": world,
        "rng": Fresh(lambda: np.random.default_rng(0)), "bodies": [body], "wanted": [body], "first": body, "second": body,
        "tray": tasks.Tray(_Patch.pose, np.array([0.5, 0.5])), "free_direction.others": [np.ones(2)], "place": np.zeros(2),
        "directions": [0.0, 1.0], "half_width": 0.1, "length": 0.5, "SpawnBoundary.sample.min_rotation": np.full(3, -0.1),
        "SpawnBoundary.sample.max_rotation": np.full(3, 0.1),
    }  # fmt: skip
    names = ("SpawnBoundary", "clearance", "easiest_top_grasp", "free_direction", "place_task", "settle", "swap_places")
    boundary = tasks.SpawnBoundary(good["regions"])  # type: ignore[arg-type]
    doors = functions(tasks, names, good, LOOSE) + methods(boundary, good, LOOSE, skip=INNER)
    return [replace(d, finite=d.name != "clearance", good_is_taken=d.name != "settle") for d in doors]  # a chest does not rest


def moved(world: World, before: dict[str, np.ndarray]) -> str:
    """Say what differs from `before`, or nothing."""
    now = {"q": world.robot.joint_positions, **{name: body.pose for name, body in world.bodies.items()}}
    return ", ".join(name for name, value in now.items() if name in before and not np.array_equal(value, before[name]))


def world_doors(task: TaskEnvironment) -> list[Door]:
    """Return all of them."""
    world, good, saved = task.world, samples(task), task.world.save()
    before = {"q": world.robot.joint_positions, **{name: body.pose for name, body in world.bodies.items()}}

    def restored() -> str:
        world.restore(saved)
        there = moved(world, before)
        return f"{there} cannot be brought back" if there else ""

    body = next(body for body in world.bodies.values() if body.joints)
    things = [world, body, next(iter(body.joints.values())), world.robot, world.gripper, world.frame("waypoint0"), task]
    doors = [door for thing in things for door in methods(thing, good, LOOSE, skip=(*INNER, *LONG))]
    doors += placing_doors(world)
    return [replace(door, check=restored) for door in doors]
