"""Reads scene and request files in the YAML of MoveIt messages, as the public MotionBenchMaker problem sets use them.

Boxes, cylinders and spheres; a start state and a goal in joint space. Places are relative to the arm's base.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import yaml

from rlbench_pin.errors import ProblemFileError
from rlbench_pin.planning.problems.problem import PlanningProblem, solid_body
from rlbench_pin.robot.description import DEFAULT_ROBOT, RobotDescription, robot_description
from rlbench_pin.scene.snapshot import BodySnapshot, Shape, WorldSnapshot
from rlbench_pin.spatial import FloatArray, compose

_KINDS = {1: "box", 2: "sphere", 3: "cylinder"}
_NOWHERE = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def read_motion_bench(scene: Path, request: Path, robot: str = DEFAULT_ROBOT) -> PlanningProblem:
    """Read one problem; the arm's base is the origin.

    Args:
        scene: File with `world: collision_objects`.
        request: File with `start_state: joint_state` and `goal_constraints: joint_constraints`.
        robot: Catalogue name of the arm.

    Raises:
        ProblemFileError: A file is missing or no YAML, lacks a joint, or holds shapes that are not known.
    """
    description = robot_description(robot)
    world, query = _load(scene), _load(request)
    query = query.get("motion_plan_request", query)  # type: ignore[assignment]
    try:
        bodies = _bodies(scene, world)
    except (KeyError, TypeError, ValueError) as error:
        raise ProblemFileError(scene, f"{type(error).__name__}: {error}") from error
    try:
        start = _start(query, description)
        goal = _goal(query, description)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise ProblemFileError(request, f"{type(error).__name__}: {error}") from error
    size = len(description.arm_joints)
    name = f"{scene.parent.name}_{request.stem}"
    return PlanningProblem(name, WorldSnapshot(tuple(bodies), start[:size], start[size:]), goal, robot=robot, base_pose=_NOWHERE)


def _load(path: Path) -> Mapping[str, object]:
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        raise ProblemFileError(path, str(error)) from error
    if not isinstance(content, Mapping):
        raise ProblemFileError(path, "it is not a table of names and values")
    return content


def _bodies(path: Path, scene: Mapping[str, object]) -> list[BodySnapshot]:
    world = scene.get("world", {})
    bodies = []
    for item in world.get("collision_objects") or ():  # type: ignore[attr-defined]
        if item.get("meshes"):
            raise ProblemFileError(path, f"object '{item['id']}' has meshes; only boxes, cylinders and spheres are read")
        primitives = item.get("primitives") or ()
        poses = item.get("primitive_poses") or item.get("poses") or [{}] * len(primitives)
        if len(poses) != len(primitives):
            raise ProblemFileError(path, f"object '{item['id']}' has {len(primitives)} primitives and {len(poses)} poses")
        whole = _pose(item.get("pose") or {})
        shapes = [_shape(path, p, compose(whole, _pose(pose))) for p, pose in zip(primitives, poses, strict=True)]
        if shapes:
            bodies.append(solid_body(str(item["id"]), shapes))
    return bodies


def _shape(path: Path, primitive: Mapping[str, object], pose: FloatArray) -> Shape:
    kind = primitive["type"]
    kind = _KINDS.get(kind, kind)  # type: ignore[call-overload]
    size = tuple(float(x) for x in primitive["dimensions"])  # type: ignore[attr-defined]
    needed = {"box": 3, "cylinder": 2, "sphere": 1}
    if kind not in needed:
        raise ProblemFileError(path, f"'{kind}' is not one of {', '.join(needed)}")
    if len(size) < needed[kind]:
        raise ProblemFileError(path, f"a {kind} has {needed[kind]} dimensions, not {len(size)}")
    if kind == "cylinder":  # height comes first there
        size = (size[1], size[0])
    return Shape(kind, size[: needed[kind]], tuple(pose.tolist()))  # type: ignore[arg-type]


def _pose(content: Mapping[str, object]) -> FloatArray:
    position, orientation = content.get("position", _NOWHERE[:3]), content.get("orientation", _NOWHERE[3:])
    if isinstance(position, Mapping):
        position = [position[key] for key in "xyz"]
    if isinstance(orientation, Mapping):
        orientation = [orientation[key] for key in "xyzw"]
    place: FloatArray = np.concatenate([np.asarray(position, dtype=float), np.asarray(orientation, dtype=float)])
    place[3:] /= np.linalg.norm(place[3:])
    return place


def _start(request: Mapping[str, object], description: RobotDescription) -> FloatArray:
    """Return arm and finger positions; fingers that are not mentioned are open."""
    state = request["start_state"]["joint_state"]  # type: ignore[index]
    return _joints(state["name"], state["position"], (*description.arm_joints, *description.gripper_joints), description)


def _goal(request: Mapping[str, object], description: RobotDescription) -> FloatArray:
    wanted = request["goal_constraints"][0]["joint_constraints"]  # type: ignore[index]
    return _joints([c["joint_name"] for c in wanted], [c["position"] for c in wanted], description.arm_joints, description)


def _joints(names: Sequence[str], values: Sequence[float], wanted: Sequence[str], description: RobotDescription) -> FloatArray:
    given = dict(zip(names, values, strict=True)) | {
        name: description.gripper_open for name in description.gripper_joints if name not in names
    }
    return np.array([float(given[name]) for name in wanted])
