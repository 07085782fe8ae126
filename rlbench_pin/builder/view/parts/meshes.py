"""A mesh of one's own as an asset: a URDF, the mesh as it is seen, and convex parts of it for what it touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import coacd
import numpy as np
import trimesh

from rlbench_pin.builder.server import UploadedMesh, UploadRefused
from rlbench_pin.values import as_number

MOST_PARTS = 32
"""Convex parts at most."""
_FEW = 20_000
"""Triangles that are taken apart; of more, a hull stands for the whole."""
_LARGEST = 2.0


@dataclass(frozen=True, eq=False)
class MeshAsset:
    """Files of an asset, by their names."""

    urdf: str
    """Name of its URDF file, among `files`."""
    files: dict[str, bytes]
    """Name -> content."""
    height: float
    """How high its origin is when it stands on the table [m]."""


def mesh_asset(uploaded: UploadedMesh, scale: float, mass: float, color: Sequence[float]) -> MeshAsset:
    """Return an asset whose origin is the middle of its box.

    Args:
        uploaded: The mesh.
        scale: Factor on its lengths; 0.001 for millimetres.
        mass: [kg].
        color: Red, green, blue from 0 to 1.

    Raises:
        UploadRefused: It is flat, or larger than 2 m.
        InvalidValue: Scale or mass are not above 0.
    """
    scale = as_number(scale, "scale", above=0.0, most=1e4)
    mass = as_number(mass, "mass [kg]", above=0.0, most=100.0)
    mesh = uploaded.mesh.copy()
    mesh.apply_scale(scale)
    mesh.apply_translation(-mesh.bounds.mean(axis=0))
    extent = mesh.bounds[1] - mesh.bounds[0]
    _check_extent(uploaded.name, extent)
    parts = convex_parts(mesh)
    name = uploaded.name
    names = [f"{name}_part{number}.obj" for number in range(len(parts))]
    files = {f"{name}.obj": obj_text(mesh).encode()}
    files |= {file: obj_text(part).encode() for file, part in zip(names, parts)}
    files[f"{name}.urdf"] = _urdf(name, names, parts, mass, color).encode()
    return MeshAsset(f"{name}.urdf", files, round(0.5 * float(extent[2]), 4))


def _check_extent(name: str, extent: np.ndarray) -> None:
    size = " x ".join(f"{side:.3g}" for side in extent)
    if extent.max() > _LARGEST:
        hint = "Give a smaller scale: 0.001 where the file is in millimetres."
        raise UploadRefused(name, f"it would be {size} m large, at most {_LARGEST:g} m are taken", hint)
    if extent.min() < 1e-4:
        raise UploadRefused(name, f"it is flat: {size} m", "Give it a thickness of a tenth of a millimetre or more.")


def convex_parts(mesh: trimesh.Trimesh) -> list[trimesh.Trimesh]:
    """Return convex parts that together stand for a mesh; its hull where it is convex, or has too many triangles."""
    hull = mesh.convex_hull
    solid = mesh.is_watertight and mesh.volume > 0.0
    if len(mesh.faces) > _FEW or (solid and mesh.volume > 0.98 * hull.volume):
        return [hull]
    coacd.set_log_level("error")
    found = coacd.run_coacd(
        coacd.Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces)), threshold=0.05, max_convex_hull=MOST_PARTS, seed=0
    )
    parts = [trimesh.Trimesh(vertices, faces).convex_hull for vertices, faces in found]
    return [part for part in parts if part.volume > 0.0] or [hull]


def obj_text(mesh: trimesh.Trimesh) -> str:
    """Return an OBJ file with corners and triangles, lengths to a micrometre."""
    corners = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in np.round(mesh.vertices, 6) + 0.0]
    faces = [f"f {a} {b} {c}" for a, b, c in np.asarray(mesh.faces) + 1]
    return "\n".join([*corners, *faces]) + "\n"


def _urdf(name: str, names: Sequence[str], parts: Sequence[trimesh.Trimesh], mass: float, color: Sequence[float]) -> str:
    volumes = np.array([part.volume for part in parts])
    center = volumes @ np.array([part.center_mass for part in parts]) / volumes.sum()
    inertia = np.sum([_inertia(part, center) for part in parts], axis=0) * (mass / volumes.sum())
    x, y, z = (f"{v:.6g}" for v in np.round(center, 6) + 0.0)
    keys = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
    moments = " ".join(f'{key}="{inertia[i, j]:.6g}"' for key, i, j in keys)
    rgba = " ".join(f"{share:g}" for share in (*color[:3], 1.0))
    collisions = [f'    <collision>\n      <geometry><mesh filename="{file}"/></geometry>\n    </collision>' for file in names]
    lines = (
        '<?xml version="1.0"?>',
        f'<robot name="{name}">',
        f'  <link name="{name}">',
        '    <contact><lateral_friction value="0.8"/></contact>',
        "    <inertial>",
        f'      <origin xyz="{x} {y} {z}" rpy="0 0 0"/>',
        f'      <mass value="{mass:g}"/>',
        f"      <inertia {moments}/>",
        "    </inertial>",
        "    <visual>",
        f'      <geometry><mesh filename="{name}.obj"/></geometry>',
        f'      <material name="{name}"><color rgba="{rgba}"/></material>',
        "    </visual>",
        *collisions,
        "  </link>",
        "</robot>",
    )
    return "\n".join(lines) + "\n"


def _inertia(part: trimesh.Trimesh, center: np.ndarray) -> np.ndarray:
    """Return the moments (3, 3) of a part of density 1 about a point."""
    away = part.center_mass - center
    return np.asarray(part.moment_inertia) + part.volume * (away @ away * np.eye(3) - np.outer(away, away))
