"""Model files for shapes that programs make: a file of the same content has the same path in every process of a user."""

from __future__ import annotations

import hashlib
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.spatial import FloatArray

_FRICTION = 0.8
_SIDES = 32  # of cones and of cylinders and balls that are not round


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed surface in the frame of its shape."""

    vertices: FloatArray
    """Corners (n, 3) [m]."""
    triangles: NDArray[np.int64]
    """Corner numbers (m, 3), counter-clockwise seen from outside."""


def primitive_file(kind: str, size: tuple[float, float, float], mass: float) -> Path:
    """Write the model file of a primitive.

    Args:
        kind: `CUBOID`, `SPHERE`, `CYLINDER` or `CONE`.
        size: Lengths along x, y, z [m].
        mass: [kg].
    """
    x, y, z = size
    round_about_z = abs(x - y) < 1e-9
    if kind == "CUBOID":
        return _write(f'<box size="{x:.9g} {y:.9g} {z:.9g}"/>', size, mass)
    if kind == "SPHERE" and round_about_z and abs(x - z) < 1e-9:
        return _write(f'<sphere radius="{x / 2:.9g}"/>', size, mass)
    if kind == "CYLINDER" and round_about_z:
        return _write(f'<cylinder radius="{x / 2:.9g}" length="{z:.9g}"/>', size, mass)
    profiles = {"CYLINDER": ((1.0, -1.0), (1.0, 1.0)), "CONE": ((1.0, -1.0), (0.0, 1.0))}
    angles = np.linspace(-np.pi / 2, np.pi / 2, _SIDES // 2 + 1)
    profile = profiles.get(kind, tuple((float(np.cos(a)), float(np.sin(a))) for a in angles))
    turned = _turned(profile)
    return mesh_file(Mesh(turned.vertices * (0.5 * np.array(size)), turned.triangles), mass)


def mesh_file(mesh: Mesh, mass: float) -> Path:
    """Write the model file of a surface; it is solid as its convex hull."""
    text = "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in mesh.vertices)
    text += "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in mesh.triangles)
    stored = _store(text, ".obj")
    size = np.ptp(mesh.vertices, axis=0)
    return _write(f'<mesh filename="{stored.name}"/>', (float(size[0]), float(size[1]), float(size[2])), mass)


def _turned(profile: tuple[tuple[float, float], ...]) -> Mesh:
    """Turn a profile of (radius, height) about z; ends are closed."""
    angles = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(_SIDES)], axis=1)
    rings = [ring * (radius, radius, 0.0) + (0.0, 0.0, height) for radius, height in profile]
    ends = [[0.0, 0.0, profile[0][1]], [0.0, 0.0, profile[-1][1]]]
    triangles = []
    for level in range(len(profile) - 1):
        for k in range(_SIDES):
            a, b = level * _SIDES + k, level * _SIDES + (k + 1) % _SIDES
            triangles += [[a, b, b + _SIDES], [a, b + _SIDES, a + _SIDES]]
    bottom, top, last = len(profile) * _SIDES, len(profile) * _SIDES + 1, (len(profile) - 1) * _SIDES
    for k in range(_SIDES):
        following = (k + 1) % _SIDES
        triangles += [[bottom, following, k], [top, last + k, last + following]]
    return Mesh(np.concatenate([*rings, np.array(ends)]), np.array(triangles, dtype=np.int64))


def _write(geometry: str, size: tuple[float, float, float], mass: float) -> Path:
    """Write a URDF of one link; its inertia is that of a box of the same size."""
    x, y, z = (s * s for s in size)
    ixx, iyy, izz = (mass / 12.0 * max(v, 1e-8) for v in (y + z, x + z, x + y))
    element = f"<geometry>{geometry}</geometry>"
    return _store(
        '<?xml version="1.0"?>\n<robot name="shape"><link name="shape">\n'
        f'<contact><lateral_friction value="{_FRICTION}"/></contact>\n'
        f'<inertial><mass value="{mass:.9g}"/>'
        f'<inertia ixx="{ixx:.9g}" ixy="0" ixz="0" iyy="{iyy:.9g}" iyz="0" izz="{izz:.9g}"/></inertial>\n'
        f'<visual>{element}<material name="shape"><color rgba="0.8 0.8 0.8 1"/></material></visual>\n'
        f"<collision>{element}</collision>\n</link></robot>\n",
        ".urdf",
    )


def _store(text: str, suffix: str) -> Path:
    """Write a text once, under a name made from its content."""
    folder = Path(tempfile.gettempdir()) / f"rlbench_pin_shapes_{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    if folder.is_symlink() or folder.stat().st_uid != os.getuid():
        raise RlbenchPinError(f"'{folder}' belongs to somebody else. Set TMPDIR to a folder of your own.")
    file = folder / (hashlib.sha256(text.encode()).hexdigest()[:32] + suffix)
    if not file.is_file():
        handle, temporary = tempfile.mkstemp(dir=folder)
        with os.fdopen(handle, "w", encoding="utf-8") as stream:
            stream.write(text)
        Path(temporary).replace(file)
    return file
