"""Assets made of a mesh: a URDF file, the mesh for the visual and convex parts for the collision; inertia of solids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import coacd
import numpy as np
import trimesh

from rlbench_pin.builder.custom_assets.uploads import UploadedMesh, UploadRefused
from rlbench_pin.builder.custom_assets.urdf_file import one_link_urdf
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_number

MAX_PARTS = 32
"""Convex parts of a mesh at most."""
_CONVEX = 0.98
"""A mesh that fills at least this share of its hull is convex."""
MAX_EXTENT = 2.0
"""Extent along each axis at most [m]."""
MIN_THICKNESS = 1e-4
"""Thickness of a solid at least [m]."""
DENSITY = 500.0
"""Density of solids without a given mass, that of wood [kg/m^3]."""
MOMENTS = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
"""Names of the moments of inertia in a URDF file, and their rows and columns in a matrix."""


@dataclass(frozen=True, eq=False)
class CustomAsset:
    """Files of an asset."""

    urdf: str
    """Name of its URDF file, among `files`."""
    files: dict[str, bytes]
    """Name -> content."""


@dataclass(frozen=True, eq=False)
class Inertia:
    """Mass distribution of a link."""

    mass: float
    """[kg]."""
    center: FloatArray
    """Centre of mass (3,) in the link frame [m]."""
    moments: FloatArray
    """About the centre, in axes of the link (3, 3) [kg m^2]."""


def inertia_of(solids: Sequence[trimesh.Trimesh], mass: float | None = None) -> Inertia:
    """Return the inertia of solids of uniform density.

    Args:
        solids: Closed meshes in the link frame [m].
        mass: Total mass [kg]; None computes it from `DENSITY`.
    """
    volumes = np.array([solid.volume for solid in solids])
    center = volumes @ np.array([solid.center_mass for solid in solids]) / volumes.sum()
    mass = DENSITY * float(volumes.sum()) if mass is None else mass
    moments = np.sum([_moments(solid, center) for solid in solids], axis=0) * (mass / volumes.sum())
    return Inertia(mass, center, moments)


def _moments(solid: trimesh.Trimesh, center: FloatArray) -> FloatArray:
    """Return the moments (3, 3) of a solid of density 1 about a point."""
    away = solid.center_mass - center
    return np.asarray(solid.moment_inertia) + solid.volume * (away @ away * np.eye(3) - np.outer(away, away))


def format_numbers(numbers: Sequence[float] | FloatArray) -> str:
    """Return numbers in the format of a URDF file."""
    return " ".join(f"{number:.9g}" for number in np.round(numbers, 9) + 0.0)


def mesh_asset(uploaded: UploadedMesh, scale: float, mass: float, color: Sequence[float]) -> CustomAsset:
    """Return an asset with its origin at the centre of its bounding box.

    Args:
        uploaded: The mesh.
        scale: Factor on its lengths; 0.001 for millimetres.
        mass: [kg].
        color: Red, green, blue from 0 to 1.

    Raises:
        UploadRefused: It is flat, or larger than 2 m.
        InvalidValue: Scale or mass is not above 0.
    """
    scale = as_number(scale, "scale", above=0.0, most=1e4)
    mass = as_number(mass, "mass [kg]", above=0.0, most=100.0)
    mesh = uploaded.mesh.copy()
    mesh.apply_scale(scale)
    mesh.apply_translation(-mesh.bounds.mean(axis=0))
    extent = mesh.bounds[1] - mesh.bounds[0]
    check_extent(uploaded.name, extent)
    parts = convex_parts(uploaded.name, mesh)
    name = uploaded.name
    names = [f"{name}_part{number}.obj" for number in range(len(parts))]
    files = {f"{name}.obj": obj_text(mesh).encode()}
    files |= {file: obj_text(part).encode() for file, part in zip(names, parts)}
    files[f"{name}.urdf"] = _urdf(name, names, parts, mass, color).encode()
    return CustomAsset(f"{name}.urdf", files)


def check_extent(name: str, extent: FloatArray) -> None:
    """Check the size of a mesh (3,) [m].

    Raises:
        UploadRefused: It is larger than 2 m, or has no size.
    """
    if extent.max() > MAX_EXTENT:
        hint = "Give a smaller scale: 0.001 where the file is in millimetres."
        raise UploadRefused(name, f"it would be {_size(extent)} m large, the limit is {MAX_EXTENT:g} m", hint)
    if extent.max() < MIN_THICKNESS:
        raise UploadRefused(name, f"it would be {_size(extent)} m large, which is too small", "Give a larger scale.")


def _size(extent: FloatArray) -> str:
    return " x ".join(f"{side:.3g}" for side in extent)


def convex_parts(name: str, mesh: trimesh.Trimesh) -> list[trimesh.Trimesh]:
    """Decompose a mesh into convex parts; a convex mesh gives its hull.

    Args:
        name: Name of the file, for errors.
        mesh: The mesh [m].

    Raises:
        UploadRefused: It is flat.
    """
    hull = _hull(mesh)
    if hull is None or min(hull.bounding_box_oriented.primitive.extents) < MIN_THICKNESS:
        size = _size(mesh.bounds[1] - mesh.bounds[0])
        raise UploadRefused(name, f"it is flat: {size} m", "Give it a thickness of a tenth of a millimetre or more.")
    if mesh.is_watertight and mesh.volume > _CONVEX * hull.volume:
        return [hull]
    coacd.set_log_level("off")
    found = coacd.run_coacd(
        coacd.Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces)), threshold=0.05, max_convex_hull=MAX_PARTS, seed=0
    )
    parts = [_hull(trimesh.Trimesh(vertices, faces)) for vertices, faces in found]
    return [part for part in parts if part is not None and part.volume > 0.0] or [hull]


def _hull(mesh: trimesh.Trimesh) -> trimesh.Trimesh | None:
    """Return the convex hull of a mesh; None for a flat mesh."""
    try:
        hull = mesh.convex_hull
    except Exception:  # Qhull's, of scipy's own kind
        return None
    return hull if np.isfinite(hull.volume) else None


def obj_text(mesh: trimesh.Trimesh) -> str:
    """Return an OBJ file with vertices and triangles, lengths rounded to a micrometre."""
    corners = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in np.round(mesh.vertices, 6) + 0.0]
    faces = [f"f {a} {b} {c}" for a, b, c in np.asarray(mesh.faces) + 1]
    return "\n".join([*corners, *faces]) + "\n"


def _urdf(name: str, names: Sequence[str], parts: Sequence[trimesh.Trimesh], mass: float, color: Sequence[float]) -> str:
    inertia = inertia_of(parts, mass)
    moments = " ".join(f'{key}="{inertia.moments[i, j]:.6g}"' for key, i, j in MOMENTS)
    inertial = (
        f'<origin xyz="{format_numbers(inertia.center)}" rpy="0 0 0"/>', f'<mass value="{mass:g}"/>', f"<inertia {moments}/>",
    )  # fmt: skip
    visual, *collisions = (f'<mesh filename="{file}"/>' for file in (f"{name}.obj", *names))
    return one_link_urdf(name, inertial, visual, collisions, color)
