"""Things put where a changed scene, or a frame of a recording, has them: nothing is built anew, nothing is simulated."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from rlbench_pin.builder.contracts import Frame
from rlbench_pin.builder.figures.chain import origin_pose
from rlbench_pin.scene.spec import ROOT, PlacementSpec, PosedSpec, SceneSpec
from rlbench_pin.sim import Body, World
from rlbench_pin.spatial import IDENTITY, FloatArray, compose, relative
from rlbench_pin.urdf import UrdfJoint, read_urdf

_POSED = ("body", "frame", "region", "sensor", "waypoint")


def only_moves(old: SceneSpec, new: SceneSpec) -> bool:
    """Whether two scenes differ in nothing but where things are: poses, joint positions and the placement."""
    return _without_places(old) == _without_places(new)


def move_to_scene(world: World, scene: SceneSpec) -> None:
    """Put everything where a scene says that differs from the world's in nothing but places; the arm is at home."""
    world.restore(world.origin)
    joints = {joint.name: joint for joint in scene.joint}
    for body in world.bodies.values():
        for name in body.joints:
            start = joints.get(f"{body.name}/{name}")
            body.joints[name].set_position(0.0 if start is None else start.position)
    world.place_root(np.array(scene.placement.pose))
    frames = (*scene.frame, *scene.waypoint, *scene.region, *scene.sensor)
    for frame in frames:
        world.frame(frame.name).set_state(frame.parent, np.array(frame.pose, dtype=np.float64))
    for spec in sorted(scene.body, key=lambda spec: _depth(scene, spec.name)):
        parent = _pose_of(world, spec.parent)
        world.body(spec.name).set_pose(compose(parent, np.array(spec.pose)))


def move_to_frame(world: World, frame: Frame) -> None:
    """Put bodies and arm where a frame of a recording has them, and paint them likewise; what is not in both is left alone."""
    for name, body in world.bodies.items():
        poses = {link: frame.poses[f"{name}/{link}"] for link in body.links if f"{name}/{link}" in frame.poses}
        if body.links[0] not in poses:
            continue
        body.set_pose(poses[body.links[0]])
        for joint, position in joint_positions(body, poses).items():
            body.joints[joint].set_state(position, 0.0)
        painted = {body.model.links[link]: frame.colors.get(f"{name}/{link}") for link in body.links}
        body.set_colors({index: color for index, color in painted.items() if color is not None})
    world.robot.reset_configuration(frame.arm, frame.fingers)


def joint_positions(body: Body, poses: Mapping[str, FloatArray]) -> dict[str, float]:
    """Return name -> position of the joints of a body, from the poses (7,) of its links by name."""
    joints = [joint for joint in read_urdf(body.model.urdf).joints if joint.name in body.joints]
    known = [joint for joint in joints if joint.parent in poses and joint.child in poses]
    return {joint.name: _position(joint, poses[joint.parent], poses[joint.child], body.model.scale) for joint in known}


def _position(joint: UrdfJoint, parent: FloatArray, child: FloatArray, scale: float) -> float:
    moved = relative(child, compose(parent, origin_pose(joint.origin, scale)))
    axis = np.array(joint.axis) / max(float(np.linalg.norm(joint.axis)), 1e-12)
    if joint.kind == "prismatic":
        return float(axis @ moved[:3])
    return math.remainder(2.0 * math.atan2(float(axis @ moved[3:6]), float(moved[6])), 2.0 * math.pi)


def _without_places(scene: SceneSpec) -> SceneSpec:
    tables: dict[str, object] = {name: tuple(_unplaced(thing) for thing in getattr(scene, name)) for name in _POSED}
    joints = tuple(joint.model_copy(update={"position": 0.0}) for joint in scene.joint)
    return scene.model_copy(update={**tables, "joint": joints, "placement": PlacementSpec(), "deviation": (), "file": ""})


def _unplaced(thing: PosedSpec) -> PosedSpec:
    return thing.model_copy(update={"pose": tuple(IDENTITY)})


def _depth(scene: SceneSpec, name: str) -> int:
    """How many things are above one."""
    parents = {thing.name: thing.parent.partition("/")[0] for thing in scene.posed()}
    depth = 0
    while name in parents:
        name, depth = parents[name], depth + 1
    return depth


def _pose_of(world: World, name: str) -> FloatArray:
    """Return the pose (7,) of a body, a link, a frame, the root or the world."""
    if name == "world":
        return IDENTITY.copy()
    if name == ROOT or name in world.frames:
        return world.frame(name).pose
    body, _, link = name.partition("/")
    return world.body(body).link_pose(link) if link else world.body(body).pose
