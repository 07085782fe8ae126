"""Planning problems as self-contained records: arm, obstacles, held bodies, start and goal.

Their file format is JSON. Scene and request files in the YAML of MoveIt messages, as in the public MotionBenchMaker
problem sets, can be read too: boxes, cylinders and spheres, a start state and a goal in joint space.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import yaml

from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.errors import ProblemFileError
from rlbench_pin.robot.collision import body_geometry
from rlbench_pin.robot.description import DEFAULT_ROBOT, RobotDescription, robot_description
from rlbench_pin.robot.geometry import as_shape
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import NO_FILE, ROOM, BodySnapshot, Shape, WorldSnapshot
from rlbench_pin.spatial import IDENTITY, FloatArray, PoseLike, compose

FORMAT = 1


@dataclass(frozen=True, eq=False)
class PlanningProblem:
    """A motion from a start to a goal among obstacles."""

    name: str
    """Name of the problem in reports."""
    world: WorldSnapshot
    """Obstacles, the start configuration, and held bodies."""
    goal: FloatArray | None = None
    """Goal configuration (n,), [rad]; None if goal poses are given."""
    poses: FloatArray | None = None
    """Equivalent goal poses of the tip (k, 7)."""
    allowed: tuple[str, ...] = ()
    """Bodies that may be touched."""
    robot: str = DEFAULT_ROBOT
    """Catalogue name of the arm."""
    base_pose: tuple[float, ...] | None = None
    """World pose (7,) of the arm base; None uses the pose in its description."""

    @property
    def start(self) -> FloatArray:
        """Start configuration (n,), [rad]."""
        return self.world.arm

    def model(self) -> RobotModel:
        """Return the arm model of this problem at its base pose."""
        return RobotModel(robot_description(self.robot), self.base_pose)


def solid_body(
    name: str, shapes: Sequence[Shape], pose: PoseLike = IDENTITY, *, fixed: bool = True, in_room: bool | None = None
) -> BodySnapshot:
    """Return a body of shapes at a pose (7,). Without `in_room`, a body named like a part of the room belongs to it."""
    room = name in ROOM if in_room is None else in_room
    poses = np.array([pose], dtype=float)
    return BodySnapshot(name, NO_FILE, ("base",), poses, fixed=fixed, shapes=tuple(shapes), in_room=room)


def self_contained(world: WorldSnapshot) -> WorldSnapshot:
    """Return the world with shapes instead of model files; each link becomes a body with the name of its body."""
    bodies: list[BodySnapshot] = []
    attached: list[str] = []
    for body in world.bodies:
        if not body.collides:
            continue
        geometry = body_geometry(body)
        for link, pose in zip(body.link_names, body.link_poses, strict=True):
            if link in geometry:
                name = body.name if len(body.link_names) == 1 else f"{body.name}/{link}"
                shapes = [as_shape(part) for part in geometry[link]]
                bodies.append(solid_body(name, shapes, pose, fixed=body.fixed, in_room=body.in_room))
                attached += [name] if body.name in world.attached else []
    return WorldSnapshot(tuple(bodies), world.arm, world.fingers, tuple(attached))


# JSON -------------------------------------------------------------------------------------------------------------


def write_problem(problem: PlanningProblem, path: Path) -> None:
    """Write one problem; numbers are stored exactly.

    Raises:
        StorageError: The disk cannot be written to; no partial file remains.
    """
    world = self_contained(problem.world)
    allowed = [b.name for b in world.bodies if {b.name, b.name.partition("/")[0]} & {*problem.allowed}]
    content = {
        "format": FORMAT,
        "name": problem.name,
        "robot": problem.robot,
        "base_pose": problem.base_pose,
        "start": world.arm.tolist(),
        "fingers": world.fingers.tolist(),
        "goal": None if problem.goal is None else problem.goal.tolist(),
        "poses": None if problem.poses is None else problem.poses.tolist(),
        "allowed": allowed,
        "attached": list(world.attached),
        "bodies": [
            {
                "name": body.name,
                "pose": body.link_poses[0].tolist(),
                "fixed": body.fixed,
                "in_room": body.in_room,
                "shapes": [asdict(shape) for shape in body.shapes],
            }
            for body in world.bodies
        ],
    }
    write_whole(path, (json.dumps(content, indent=1) + "\n").encode())


def read_problem(path: Path) -> PlanningProblem:
    """Read a problem that `write_problem` wrote.

    Raises:
        ProblemFileError: The file is missing, is not JSON, has another format, or lacks an entry.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ProblemFileError(path, str(error)) from error
    if not isinstance(content, Mapping) or content.get("format") != FORMAT:
        raise ProblemFileError(path, f"it is not of format {FORMAT}")
    try:
        return _problem(content)
    except (KeyError, TypeError, ValueError) as error:
        raise ProblemFileError(path, f"{type(error).__name__}: {error}") from error


def _problem(content: Mapping[str, object]) -> PlanningProblem:
    bodies = tuple(
        solid_body(b["name"], [_json_shape(s) for s in b["shapes"]], b["pose"], fixed=bool(b["fixed"]), in_room=b.get("in_room"))
        for b in content["bodies"]  # type: ignore[attr-defined]
    )
    world = WorldSnapshot(bodies, np.array(content["start"]), np.array(content["fingers"]), tuple(content["attached"]))  # type: ignore[arg-type]
    goal, poses, base = content["goal"], content["poses"], content["base_pose"]
    return PlanningProblem(
        str(content["name"]),
        world,
        None if goal is None else np.array(goal),
        None if poses is None else np.array(poses),
        tuple(content["allowed"]),  # type: ignore[arg-type]
        str(content["robot"]),
        None if base is None else tuple(base),  # type: ignore[arg-type]
    )


def _json_shape(content: Mapping[str, object]) -> Shape:
    return Shape(content["kind"], tuple(content["size"]), tuple(content["pose"]))  # type: ignore[arg-type]


_KINDS = {1: "box", 2: "sphere", 3: "cylinder"}
_NOWHERE = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def read_motion_bench(scene: Path, request: Path, robot: str = DEFAULT_ROBOT) -> PlanningProblem:
    """Read one problem of MotionBenchMaker; the base of the arm is the origin.

    Args:
        scene: File with `world: collision_objects`.
        request: File with `start_state: joint_state` and `goal_constraints: joint_constraints`.
        robot: Catalogue name of the arm.

    Raises:
        ProblemFileError: A file is missing, is not YAML, lacks a joint, or contains unknown shapes.
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
    obstacles = WorldSnapshot(tuple(bodies), start[:size], start[size:])
    return PlanningProblem(name, obstacles, goal, robot=robot, base_pose=tuple(IDENTITY.tolist()))


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
            raise ProblemFileError(path, f"object '{item['id']}' has meshes; only boxes, cylinders and spheres are supported")
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
    position, orientation = content.get("position", IDENTITY[:3]), content.get("orientation", IDENTITY[3:])
    if isinstance(position, Mapping):
        position = [position[key] for key in "xyz"]
    if isinstance(orientation, Mapping):
        orientation = [orientation[key] for key in "xyzw"]
    place: FloatArray = np.concatenate([np.asarray(position, dtype=float), np.asarray(orientation, dtype=float)])
    place[3:] /= np.linalg.norm(place[3:])
    return place


def _start(request: Mapping[str, object], description: RobotDescription) -> FloatArray:
    """Return arm and finger positions; fingers that are not in the file are open."""
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
