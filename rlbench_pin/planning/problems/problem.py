"""Planning problems as self-contained records: arm, obstacles, held bodies, start and goal; written as JSON and read back."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from rlbench_pin.errors import ProblemFileError, StorageError
from rlbench_pin.robot.collision import body_geometry
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.robot.geometry import as_shape
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import NO_FILE, ROOM, BodySnapshot, Shape, WorldSnapshot
from rlbench_pin.spatial import IDENTITY, FloatArray, PoseLike

FORMAT = 1


@dataclass(frozen=True, eq=False)
class PlanningProblem:
    """From where the arm stands to where it should be, among obstacles."""

    name: str
    """What it is called in reports."""
    world: WorldSnapshot
    """Obstacles, the start configuration, and what is held."""
    goal: FloatArray | None = None
    """Goal configuration (n,), [rad]; None when poses are given."""
    poses: FloatArray | None = None
    """Equally good goal poses of the tip (k, 7)."""
    allowed: tuple[str, ...] = ()
    """Bodies that may be touched."""
    robot: str = DEFAULT_ROBOT
    """Catalogue name of the arm."""
    base_pose: tuple[float, ...] | None = None
    """Where the arm stands; None as in its description."""

    @property
    def start(self) -> FloatArray:
        """Start configuration (n,), [rad]."""
        return self.world.arm

    def model(self) -> RobotModel:
        """Return the arm of this problem, where it stands."""
        return RobotModel(robot_description(self.robot), self.base_pose)


def solid_body(
    name: str, shapes: Sequence[Shape], pose: PoseLike = IDENTITY, *, fixed: bool = True, in_room: bool | None = None
) -> BodySnapshot:
    """Return a body made of shapes, at a pose (7,); without `in_room`, one that is called like a body of the room is one."""
    room = name in ROOM if in_room is None else in_room
    poses = np.array([pose], dtype=float)
    return BodySnapshot(name, NO_FILE, ("base",), poses, fixed=fixed, shapes=tuple(shapes), in_room=room)


def self_contained(world: WorldSnapshot) -> WorldSnapshot:
    """Return the world with shapes in place of model files; every link becomes a body that is named like its own."""
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
    """Write one problem; numbers keep every bit.

    Raises:
        StorageError: The disk cannot be written to; no half of the file is left.
    """
    world = self_contained(problem.world)
    content = {
        "format": FORMAT,
        "name": problem.name,
        "robot": problem.robot,
        "base_pose": problem.base_pose,
        "start": world.arm.tolist(),
        "fingers": world.fingers.tolist(),
        "goal": None if problem.goal is None else problem.goal.tolist(),
        "poses": None if problem.poses is None else problem.poses.tolist(),
        "allowed": list(problem.allowed),
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
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
        os.replace(temporary, path)
    except OSError as error:
        raise StorageError(path, error) from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def read_problem(path: Path) -> PlanningProblem:
    """Read a problem that `write_problem` wrote.

    Raises:
        ProblemFileError: The file is missing, no JSON, of another format, or lacks a part.
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
        solid_body(b["name"], [_shape(s) for s in b["shapes"]], b["pose"], fixed=bool(b["fixed"]), in_room=b.get("in_room"))
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


def _shape(content: Mapping[str, object]) -> Shape:
    return Shape(content["kind"], tuple(content["size"]), tuple(content["pose"]))  # type: ignore[arg-type]
