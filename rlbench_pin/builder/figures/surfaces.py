"""Visuals of URDF files as meshes that a browser draws: shared corners where a surface is smooth, own ones at its edges."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image

from rlbench_pin.robot.surfaces import shape_surface
from rlbench_pin.sim.render.quads import Quad, read_quads
from rlbench_pin.sim.render.raster.normals import creased_normals
from rlbench_pin.urdf import UrdfShape

_DIGITS = 6
_UNLIT = "KHR_materials_unlit"


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
def room_glb(urdf: Path, *, lit: bool) -> bytes:
    """Return a part of the room as a GLB file with the textures that it has in simulation, seen from inside alone.

    Args:
        urdf: The part.
        lit: Whether lights and shadows fall on it; what fills the whole picture is cheaper to draw without.
    """
    scene = trimesh.Scene([_quad_mesh(quad) for quad in read_quads(urdf)])
    glb: bytes = scene.export(file_type="glb")
    return glb if lit else _unlit(glb)


def _unlit(glb: bytes) -> bytes:
    """Return a GLB file whose materials show their own colours, whatever the light (extension KHR_materials_unlit)."""
    size = int.from_bytes(glb[12:16], "little")
    said = json.loads(glb[20 : 20 + size])
    for material in said["materials"]:
        material["extensions"] = {_UNLIT: {}}
    said["extensionsUsed"] = [_UNLIT]
    text = json.dumps(said).encode()
    text += b" " * (-len(text) % 4)
    rest = glb[20 + size :]
    return (
        glb[:8] + (20 + len(text) + len(rest)).to_bytes(4, "little") + len(text).to_bytes(4, "little") + glb[16:20] + text + rest
    )


def _quad_mesh(quad: Quad) -> trimesh.Trimesh:
    along, up = quad.edges
    corners = np.array([quad.corner, quad.corner + along, quad.corner + along + up, quad.corner + up])
    color = np.array([*(round(255 * share) for share in quad.color), 255], dtype=np.uint8)
    material = trimesh.visual.material.PBRMaterial(baseColorFactor=color, metallicFactor=0.0, roughnessFactor=0.9)
    uv = np.zeros((4, 2))
    if quad.texture is not None and quad.uv is not None:
        origin, u, v = quad.uv
        uv = np.array([origin, origin + u, origin + u + v, origin + v])
        material.baseColorTexture = Image.open(quad.texture).convert("RGB")
    visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], visual=visual, process=False)
