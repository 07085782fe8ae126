"""A mesh of one's own as an asset: a URDF, the mesh as it is seen, and convex parts of it for what it touches."""

from __future__ import annotations

from collections.abc import Sequence

import coacd
import numpy as np
import trimesh

from rlbench_pin.builder.server import UploadedMesh, UploadRefused
from rlbench_pin.builder.view.own.solids import MOMENTS, OwnAsset, inertia_of, written
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_number

MOST_PARTS = 32
"""Convex parts at most."""
_CONVEX = 0.98
"""Share of its hull that a convex mesh fills."""
LARGEST = 2.0
"""Along each axis [m]."""
FLAT = 1e-4
"""What is thinner is no solid [m]."""


def mesh_asset(uploaded: UploadedMesh, scale: float, mass: float, color: Sequence[float]) -> OwnAsset:
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
    check_extent(uploaded.name, extent)
    parts = convex_parts(uploaded.name, mesh)
    name = uploaded.name
    names = [f"{name}_part{number}.obj" for number in range(len(parts))]
    files = {f"{name}.obj": obj_text(mesh).encode()}
    files |= {file: obj_text(part).encode() for file, part in zip(names, parts)}
    files[f"{name}.urdf"] = _urdf(name, names, parts, mass, color).encode()
    return OwnAsset(f"{name}.urdf", files)


def check_extent(name: str, extent: FloatArray) -> None:
    """Refuse what is larger than furniture, or has no size at all.

    Raises:
        UploadRefused: It is.
    """
    if extent.max() > LARGEST:
        hint = "Give a smaller scale: 0.001 where the file is in millimetres."
        raise UploadRefused(name, f"it would be {_size(extent)} m large, at most {LARGEST:g} m are taken", hint)
    if extent.max() < FLAT:
        raise UploadRefused(name, f"it would be {_size(extent)} m large, which is nothing", "Give a larger scale.")


def _size(extent: FloatArray) -> str:
    return " x ".join(f"{side:.3g}" for side in extent)


def convex_parts(name: str, mesh: trimesh.Trimesh) -> list[trimesh.Trimesh]:
    """Return convex parts that together stand for a mesh; its hull where it is convex.

    Args:
        name: Of the file, for errors.
        mesh: What is taken apart [m].

    Raises:
        UploadRefused: It is flat.
    """
    hull = _hull(mesh)
    if hull is None or min(hull.bounding_box_oriented.primitive.extents) < FLAT:
        size = _size(mesh.bounds[1] - mesh.bounds[0])
        raise UploadRefused(name, f"it is flat: {size} m", "Give it a thickness of a tenth of a millimetre or more.")
    if mesh.is_watertight and mesh.volume > _CONVEX * hull.volume:
        return [hull]
    coacd.set_log_level("off")
    found = coacd.run_coacd(
        coacd.Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces)), threshold=0.05, max_convex_hull=MOST_PARTS, seed=0
    )
    parts = [_hull(trimesh.Trimesh(vertices, faces)) for vertices, faces in found]
    return [part for part in parts if part is not None and part.volume > 0.0] or [hull]


def _hull(mesh: trimesh.Trimesh) -> trimesh.Trimesh | None:
    """Return the convex hull of a mesh; None where it has none, because it is flat."""
    try:
        hull = mesh.convex_hull
    except Exception:  # Qhull's, of scipy's own kind
        return None
    return hull if np.isfinite(hull.volume) else None


def obj_text(mesh: trimesh.Trimesh) -> str:
    """Return an OBJ file with corners and triangles, lengths to a micrometre."""
    corners = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in np.round(mesh.vertices, 6) + 0.0]
    faces = [f"f {a} {b} {c}" for a, b, c in np.asarray(mesh.faces) + 1]
    return "\n".join([*corners, *faces]) + "\n"


def _urdf(name: str, names: Sequence[str], parts: Sequence[trimesh.Trimesh], mass: float, color: Sequence[float]) -> str:
    inertia = inertia_of(parts, mass)
    moments = " ".join(f'{key}="{inertia.moments[i, j]:.6g}"' for key, i, j in MOMENTS)
    rgba = " ".join(f"{share:g}" for share in (*color[:3], 1.0))
    collisions = [f'    <collision>\n      <geometry><mesh filename="{file}"/></geometry>\n    </collision>' for file in names]
    lines = (
        '<?xml version="1.0"?>',
        f'<robot name="{name}">',
        f'  <link name="{name}">',
        '    <contact><lateral_friction value="0.8"/></contact>',
        "    <inertial>",
        f'      <origin xyz="{written(inertia.center)}" rpy="0 0 0"/>',
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
