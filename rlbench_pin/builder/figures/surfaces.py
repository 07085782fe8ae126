"""Visuals of URDF files as meshes that a browser draws: shared corners where a surface is smooth, own ones at its edges."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image

from rlbench_pin.robot.geometry import shape_surface
from rlbench_pin.sim.render.raster.meshes import creased_normals
from rlbench_pin.sim.room import Quad, read_quads
from rlbench_pin.spatial import FloatArray, pose_to_matrix
from rlbench_pin.urdf import UrdfShape

_DIGITS = 6
_UNLIT = "KHR_materials_unlit"
_ONE_LEVEL, _LINEAR, _REPEAT = 9985, 9729, 10497
"""LINEAR_MIPMAP_NEAREST, LINEAR and REPEAT of OpenGL: one size of a texture is looked at and not two, half the work."""


@dataclass(frozen=True, eq=False)
class DrawnSurface:
    """A surface in the frame of its link."""

    corners: NDArray[np.float32]
    """(n, 3) [m]."""
    triangles: NDArray[np.uint32]
    """Numbers of corners (m, 3)."""


def drawn_surface(shape: UrdfShape, scale: float) -> DrawnSurface:
    """Return the surface of a visual; a mesh file is read again only after it was written again.

    Raises:
        AssetNotFound: Its mesh does not exist.
        AssetInvalid: Its file is no mesh.
    """
    written = shape.mesh.stat().st_mtime_ns if shape.mesh is not None and shape.mesh.is_file() else 0
    return _drawn_surface(shape, scale, written)


@lru_cache(maxsize=1024)
def _drawn_surface(shape: UrdfShape, scale: float, written: int) -> DrawnSurface:
    points, numbers = shape_surface(shape, scale)
    corners = points[numbers]
    normals = creased_normals(corners)
    # Browsers take the mean of the faces that share a corner: corners are shared where place and normal agree.
    both = np.concatenate([corners.reshape(-1, 3), normals.reshape(-1, 3)], axis=1).round(_DIGITS)
    unique, index = np.unique(both, axis=0, return_inverse=True)
    return DrawnSurface(unique[:, :3].astype(np.float32), index.reshape(-1, 3).astype(np.uint32))


@lru_cache(maxsize=16)
def room_glb(urdfs: tuple[Path, ...], *, lit: bool) -> bytes:
    """Return parts of the room as a GLB file with the textures that they have in simulation, seen from inside alone.

    What looks alike is one mesh: without a graphics card each mesh costs a third of a millisecond, however small it is.

    Args:
        urdfs: The parts.
        lit: Whether lights and shadows fall on them; what fills the whole picture is cheaper to draw without.
    """
    alike: dict[tuple[object, ...], list[Quad]] = {}
    for quad in (quad for urdf in urdfs for quad in read_quads(urdf)):
        alike.setdefault((quad.texture, quad.color), []).append(quad)
    glb: bytes = trimesh.Scene([_quads_mesh(quads) for quads in alike.values()]).export(file_type="glb")
    return glb if lit else _unlit(glb)


def _unlit(glb: bytes) -> bytes:
    """Return a GLB file whose materials show their own colours, whatever the light, with textures that are quick to look up."""
    size = int.from_bytes(glb[12:16], "little")
    said = json.loads(glb[20 : 20 + size])
    for material in said["materials"]:
        material["extensions"] = {_UNLIT: {}}
    said["extensionsUsed"] = [_UNLIT]
    said["samplers"] = [{"minFilter": _ONE_LEVEL, "magFilter": _LINEAR, "wrapS": _REPEAT, "wrapT": _REPEAT}]
    for texture in said.get("textures", ()):
        texture["sampler"] = 0
    text = json.dumps(said).encode()
    text += b" " * (-len(text) % 4)
    rest = glb[20 + size :]
    return (
        glb[:8] + (20 + len(text) + len(rest)).to_bytes(4, "little") + len(text).to_bytes(4, "little") + glb[16:20] + text + rest
    )


def _quads_mesh(quads: Sequence[Quad]) -> trimesh.Trimesh:
    """Return quads of one colour and one texture."""
    first = quads[0]
    color = np.array([*(round(255 * share) for share in first.color), 255], dtype=np.uint8)
    material = trimesh.visual.material.PBRMaterial(baseColorFactor=color, metallicFactor=0.0, roughnessFactor=0.9)
    if first.texture is not None:
        material.baseColorTexture = Image.open(first.texture).convert("RGB")
    corners = np.concatenate([_four(quad.corner, *quad.edges) for quad in quads])
    uv = np.concatenate([np.zeros((4, 2)) if quad.uv is None else _four(*quad.uv) for quad in quads])
    triangles = np.concatenate([np.array([[0, 1, 2], [0, 2, 3]]) + 4 * number for number in range(len(quads))])
    visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return trimesh.Trimesh(corners, triangles, visual=visual, process=False)


def _four(corner: NDArray[np.float64], along: NDArray[np.float64], up: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.array([corner, corner + along, corner + along + up, corner + up])


def merged_surface(parts: Iterable[tuple[DrawnSurface, FloatArray]]) -> DrawnSurface:
    """Return several surfaces as one.

    Args:
        parts: Each surface with the pose (7,) of its frame in that of the whole.
    """
    corners, triangles, count = list[NDArray[np.float32]](), list[NDArray[np.uint32]](), 0
    for surface, pose in parts:
        matrix = pose_to_matrix(pose)
        corners.append((surface.corners @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32))
        triangles.append(surface.triangles + np.uint32(count))
        count += len(surface.corners)
    return DrawnSurface(np.concatenate(corners), np.concatenate(triangles))
