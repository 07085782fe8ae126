"""Scenes with other bodies: similar models in place of objects, and objects of other sizes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from rlbench_pin.robot.geometry import bounds, solid_geometry
from rlbench_pin.scene.reader import resolve_asset
from rlbench_pin.scene.spec import BodySpec, JointSpec, PosedSpec, RegionSpec, SceneSpec, SensorSpec, WaypointSpec
from rlbench_pin.spatial import FloatArray, pose_to_se3
from rlbench_pin.urdf import read_urdf


def with_models(scene: SceneSpec, models: Mapping[str, str]) -> SceneSpec:
    """Return a scene in which bodies have another model of the same size, that rests at the same height.

    The size is the geometric mean of the sides of the bounding box of the base link. What is attached to a body keeps its place.

    Args:
        scene: The scene.
        models: URDF file for each body, by name of the body.
    """
    bodies = tuple(_with_model(scene, body, models[body.name]) if body.name in models else body for body in scene.body)
    return scene.model_copy(update={"body": bodies})


def _with_model(scene: SceneSpec, body: BodySpec, asset: str) -> BodySpec:
    other = body.model_copy(update={"asset": asset})
    own, new = (np.ptp(_bounds(scene, each, upright=True), axis=0) for each in (body, other))
    other = other.model_copy(update={"scale": body.scale * float(np.exp(np.log(own / new).mean()))})
    x, y, z, *turn = body.pose
    lifted = z + _bounds(scene, body)[0, 2] - _bounds(scene, other)[0, 2]
    return other.model_copy(update={"pose": (x, y, float(lifted), *turn)})


def resized(scene: SceneSpec, sizes: Mapping[str, float]) -> SceneSpec:
    """Return a scene in which bodies have other sizes.

    Frames, regions, sensors and waypoints that are attached to such a body keep their place on it, and regions and sensors
    are scaled with it. A body stays on the surface that supports it.

    Args:
        scene: The scene.
        sizes: Scale factor of each body, by name.
    """
    parents = {posed.name: posed.parent.partition("/")[0] for posed in scene.posed()}

    def size_of(name: str) -> float:
        """Return the scale of the frame of a body, or of the body that a frame is attached to."""
        while name in parents and name not in sizes:
            name = parents[name]
        return sizes.get(name, 1.0)

    def changed(posed: PosedSpec) -> PosedSpec:
        factor = size_of(parents[posed.name])
        update: dict[str, Any] = {"pose": _scaled(posed.pose, factor)}
        if isinstance(posed, BodySpec):
            own = sizes.get(posed.name, 1.0)
            x, y, z, *turn = update["pose"]
            update |= {"scale": posed.scale * own, "pose": (x, y, z + (1.0 - own) * float(_bounds(scene, posed)[0, 2]), *turn)}
        elif isinstance(posed, RegionSpec | SensorSpec):
            update["size"] = tuple(factor * length for length in posed.size)
        elif isinstance(posed, WaypointSpec):
            update["points"] = tuple(_scaled(point, factor) for point in posed.points)
        return posed.model_copy(update=update)

    posed = {
        kind: tuple(changed(one) for one in getattr(scene, kind)) for kind in ("body", "frame", "region", "sensor", "waypoint")
    }
    return scene.model_copy(update={"joint": _scaled_joints(scene, sizes), **posed})


def _scaled_joints(scene: SceneSpec, sizes: Mapping[str, float]) -> tuple[JointSpec, ...]:
    """Return the joints with scaled start and rest positions of the sliders of scaled bodies; PyBullet scales the limits."""
    sliders = {
        f"{body.name}/{joint.name}": sizes[body.name]
        for body in scene.body
        if body.name in sizes
        for joint in read_urdf(resolve_asset(scene, body.asset)).joints
        if joint.kind == "prismatic"
    }
    joints = []
    for joint in scene.joint:
        factor = sliders.get(joint.name, 1.0)
        spring = None if joint.spring is None else joint.spring.model_copy(update={"rest": factor * joint.spring.rest})
        joints.append(joint.model_copy(update={"position": factor * joint.position, "spring": spring}))
    return tuple(joints)


def _scaled(pose: tuple[float, ...], factor: float) -> tuple[float, ...]:
    x, y, z, *turn = pose
    return (factor * x, factor * y, factor * z, *turn)


def _bounds(scene: SceneSpec, body: BodySpec, *, upright: bool = False) -> FloatArray:
    """Return lowest and highest corner (2, 3) of the base link of a body around its origin [m].

    Args:
        scene: The scene.
        body: The body.
        upright: In the axes of the body; otherwise in those of its parent.
    """
    parts = next(iter(solid_geometry(resolve_asset(scene, body.asset), body.scale).values()), ())
    turned = pose_to_se3((0.0, 0.0, 0.0, *((0.0, 0.0, 0.0, 1.0) if upright else body.pose[3:])))
    return bounds((shape, turned * placement) for shape, placement in parts)
