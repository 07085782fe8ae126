"""Bodies of the room as flat rectangles: PyBullet simulates collisions with them, and the backdrop draws them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from rlbench_pin.errors import AssetInvalid
from rlbench_pin.sim.body import BASE, Body, Color
from rlbench_pin.sim.client import bullet
from rlbench_pin.sim.render.backdrop import Panel
from rlbench_pin.sim.render.texture import Texture, read_texture
from rlbench_pin.spatial import FloatArray, pose_to_matrix
from rlbench_pin.urdf import read_urdf


@dataclass(frozen=True, eq=False)
class Quad:
    """A parallelogram, visible from the side from which its edges are counter-clockwise."""

    corner: FloatArray
    """(3,) [m], in the frame of its body."""
    edges: FloatArray
    """The two edges that leave the corner, (2, 3) [m]."""
    color: tuple[float, float, float]
    """Colour, or tint of the texture."""
    texture: Path | None = None
    """Image on it."""
    uv: FloatArray | None = None
    """Texture coordinates of the corner and their growth along both edges, (3, 2)."""


@lru_cache(maxsize=32)
def read_quads(urdf: Path) -> tuple[Quad, ...]:
    """Return the rectangles of a body with one link, whose meshes consist of pairs of triangles.

    Raises:
        AssetInvalid: A visual is not a mesh, or two consecutive triangles of a mesh are not the halves of a parallelogram.
    """
    quads: list[Quad] = []
    for visual in (visual for link in read_urdf(urdf).links for visual in link.visuals):
        if visual.mesh is None:
            raise AssetInvalid(urdf, "a visual is not a mesh; visuals of the room have to be meshes")
        red, green, blue = (visual.color or (1.0, 1.0, 1.0))[:3]
        quads += _mesh_quads(urdf, visual.mesh, (red, green, blue))
    return tuple(quads)


def _mesh_quads(urdf: Path, obj: Path, color: tuple[float, float, float]) -> list[Quad]:
    vertices, coordinates, faces, texture = _read_obj(obj)
    if len(faces) % 2:
        raise AssetInvalid(urdf, f"{obj.name} has an odd number of triangles; meshes of the room have to be rectangles")
    return [_quad(urdf, vertices, coordinates, a, b, color, texture) for a, b in zip(faces[0::2], faces[1::2])]


_Face = list[tuple[int, int]]


def _quad(
    urdf: Path,
    vertices: FloatArray,
    uv: FloatArray,
    first: _Face,
    second: _Face,
    color: tuple[float, float, float],
    texture: Path | None,
) -> Quad:
    """Join triangles (a, b, c) and (a, c, d) to the parallelogram with corner a and edges b - a, d - a."""
    (a, b, c), d = first, second[2]
    points = vertices[[a[0], b[0], c[0], d[0]]]
    if second[0][0] != a[0] or second[1][0] != c[0] or np.abs(points[1] + points[3] - points[0] - points[2]).max() > 1e-6:
        raise AssetInvalid(urdf, "two consecutive triangles do not form a rectangle; meshes of the room have to be rectangles")
    edges = np.stack([points[1] - points[0], points[3] - points[0]])
    if texture is None:
        return Quad(points[0], edges, color)
    t = uv[[a[1], b[1], d[1]]]
    return Quad(points[0], edges, color, texture, np.stack([t[0], t[1] - t[0], t[2] - t[0]]))


def _read_obj(obj: Path) -> tuple[FloatArray, FloatArray, list[_Face], Path | None]:
    vertices, uv, faces, texture = [], [], [], None
    for line in obj.read_text(encoding="utf-8").splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            vertices.append([float(x) for x in rest])
        elif word == "vt":
            uv.append([float(x) for x in rest[:2]])
        elif word == "f":
            faces.append([_corner(text) for text in rest])
        elif word == "mtllib":
            texture = _texture_of(obj.parent / rest[0])
    return np.array(vertices), np.array(uv), faces, texture


def _corner(text: str) -> tuple[int, int]:
    parts = text.split("/")
    return int(parts[0]) - 1, int(parts[1]) - 1 if len(parts) > 1 and parts[1] else 0


def _texture_of(mtl: Path) -> Path | None:
    for line in mtl.read_text(encoding="utf-8").splitlines():
        if line.startswith("map_Kd "):
            return mtl.parent / line.split(maxsplit=1)[1].strip()
    return None


_REPEATS = 1.7  # of a foreign texture along one metre
_UNSEEN = (1.0, 1.0, 1.0, 0.0)


class RoomBody(Body):
    """Table, floor, a wall or the ceiling; hidden from PyBullet's renderers.

    Attributes:
        texture: Replaces its own textures and covers its plain parts, or None.
        pattern: Replaces its own textures and keeps their mean colours, or None.
        tint: Factor of red, green and blue.
    """

    texture: Texture | None = None
    pattern: Texture | None = None
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def hide(self) -> RoomBody:
        """Hide it from PyBullet's renderers."""
        self.model.client.change(bullet.changeVisualShape, self.model.uid, BASE, rgbaColor=_UNSEEN)
        return self

    def _paint(self, index: int, color: Color) -> None:
        self._colors[index] = color

    def _unpaint(self, index: int) -> None:
        del self._colors[index]

    def appearance(self) -> tuple[object, ...]:
        """All values on which its image depends, for comparison."""
        place = bullet.getBasePositionAndOrientation(self.model.uid, physicsClientId=self.model.client.id)
        return (place, self._colors.get(BASE), self.texture, self.pattern, self.tint)

    def panels(self, identifier: int) -> list[Panel]:
        """Its rectangles in the world.

        Args:
            identifier: Mask id.
        """
        pose, painted = pose_to_matrix(self.pose), self._colors.get(BASE)
        panels = []
        for quad in read_quads(self.model.urdf):
            texture = self.texture or (None if quad.texture is None else read_texture(quad.texture))
            color = quad.color if painted is None else painted[:3]
            if self.texture is not None and painted is None:
                color = (1.0, 1.0, 1.0)
            if self.pattern is not None:
                color = _product(color, (1.0, 1.0, 1.0) if texture is None else texture.mean.tolist())
                texture = self.pattern
            color = _product(color, self.tint)
            corner, edges = pose[:3, :3] @ quad.corner + pose[:3, 3], quad.edges @ pose[:3, :3].T
            uv = quad.uv if self.texture is None and self.pattern is None else _in_metres(quad.edges)
            panels.append(Panel(corner, edges, identifier, color, texture, uv))
        return panels


def _product(color: Sequence[float], factors: Sequence[float]) -> tuple[float, float, float]:
    red, green, blue = (a * b for a, b in zip(color, factors, strict=True))
    return red, green, blue


def _in_metres(edges: FloatArray) -> FloatArray:
    """Texture coordinates in metres of a rectangle with a uniformly repeated texture."""
    lengths = _REPEATS * np.linalg.norm(edges, axis=1)
    return np.array([[0.0, 0.0], [lengths[0], 0.0], [0.0, lengths[1]]])
