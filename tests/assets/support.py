"""What the tests of the assets share: the list of URDF files and both engines' view of one."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pinocchio as pin
import pybullet as p

from rlbench_pin.assets import ASSETS

URDFS = tuple(sorted(path for folder in ("objects", "robots", "room") for path in (ASSETS / folder).rglob("*.urdf")))
OBJECTS = tuple(path for path in URDFS if "objects" in path.parts)
ROBOTS = tuple(path for path in URDFS if "robots" in path.parts)
PANDA = ASSETS / "robots/panda/panda.urdf"


def object_urdf(name: str) -> Path:
    """Return the file of an object."""
    return ASSETS / "objects" / name / f"{name}.urdf"


def label(path: Path) -> str:
    """Name a URDF in the output of pytest."""
    return path.stem


@contextmanager
def client() -> Iterator[int]:
    """Give a fresh PyBullet client."""
    number = p.connect(p.DIRECT)
    p.setGravity(0.0, 0.0, -9.81, physicsClientId=number)
    p.setTimeStep(1.0 / 240.0, physicsClientId=number)
    try:
        yield number
    finally:
        p.disconnect(number)


def load(path: Path, number: int, position: tuple[float, float, float] = (0.0, 0.0, 0.0), *, fixed: bool = True) -> int:
    """Load a URDF with its link frame at a position; return the body."""
    flags = p.URDF_USE_INERTIA_FROM_FILE | p.URDF_USE_IMPLICIT_CYLINDER
    body = p.loadURDF(str(path), useFixedBase=fixed, flags=flags, physicsClientId=number)
    place(body, number, position)
    return body


def inertial_place(body: int, index: int, number: int) -> pin.SE3:
    """Return the inertial frame, which PyBullet turns along the principal axes, in the link frame."""
    info = p.getDynamicsInfo(body, index, physicsClientId=number)
    return pin.XYZQUATToSE3(np.array([*info[3], *info[4]]))


def place(body: int, number: int, position: tuple[float, float, float]) -> None:
    """Put the base link frame, not the centre of mass, at a position without turning it."""
    pose = pin.SE3ToXYZQUAT(pin.SE3(np.eye(3), np.array(position)) * inertial_place(body, -1, number))
    p.resetBasePositionAndOrientation(body, pose[:3], pose[3:], physicsClientId=number)


def base_position(body: int, number: int) -> np.ndarray:
    """Return the position (3,) of the base link frame."""
    center, turn = p.getBasePositionAndOrientation(body, physicsClientId=number)
    return (pin.XYZQUATToSE3(np.array([*center, *turn])) * inertial_place(body, -1, number).inverse()).translation


def joint_table(body: int, number: int) -> dict[str, tuple[int, int, str]]:
    """Return index, type and child link of every joint of a body, by name."""
    rows = [p.getJointInfo(body, j, physicsClientId=number) for j in range(p.getNumJoints(body, physicsClientId=number))]
    return {row[1].decode(): (row[0], row[2], row[12].decode()) for row in rows}


def geometry(path: Path) -> tuple[pin.Model, pin.GeometryModel]:
    """Read a URDF with Pinocchio: kinematics and collision shapes, meshes as convex hulls."""
    model = pin.buildModelFromUrdf(str(path))
    shapes = pin.buildGeomFromUrdf(model, str(path), pin.GeometryType.COLLISION, package_dirs=[str(path.parent)])
    for item in shapes.geometryObjects:
        if hasattr(item.geometry, "buildConvexHull"):
            item.geometry.buildConvexHull(True, "Qt")
            item.geometry = item.geometry.convex
    return model, shapes


def configuration(model: pin.Model, values: Mapping[str, float]) -> np.ndarray:
    """Return the configuration (nq,) of joint values by name, others 0; joints without end have two numbers in it."""
    q = pin.neutral(model)
    for name, value in values.items():
        joint = model.joints[model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else (np.cos(value), np.sin(value))
    return q


def random_configuration(model: pin.Model, rng: np.random.Generator) -> tuple[np.ndarray, dict[str, float]]:
    """Return a configuration (nq,) within the limits, and its joint values by name."""
    values = {}
    for name in list(model.names)[1:]:
        joint = model.joints[model.getJointId(name)]
        ends = (model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]) if joint.nq == 1 else (-3.0, 3.0)
        values[name] = float(rng.uniform(*ends))
    return configuration(model, values), values


def read_obj(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) and faces (m, 3) of one of our OBJ files."""
    lines = path.read_text().splitlines()
    vertices = np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)
    faces = [[int(word.split("/")[0]) - 1 for word in line.split()[1:]] for line in lines if line.startswith("f ")]
    return vertices, np.array(faces)


def meshes_of(path: Path, kind: str) -> tuple[Path, ...]:
    """Return the mesh files that the visual or collision elements of a URDF name."""
    names = [mesh.attrib["filename"] for mesh in ET.parse(path).getroot().iterfind(f"link/{kind}/geometry/mesh")]
    return tuple(path.parent / name for name in names)
