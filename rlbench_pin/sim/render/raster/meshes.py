"""Visual shapes as triangles with normals and shades: OBJ files, boxes, spheres, cylinders and capsules."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.client import bullet

_CREASE = np.cos(np.radians(35.0))
"""Faces that meet at a smaller angle are one smooth surface."""
_DIGITS = 7
"""Corners that agree to so many digits [m] are one point."""


def flat_normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the normals (m, 3, 3) of triangles with corners (m, 3, 3), the same at all three; 0 for those without an area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    return np.repeat(normals[:, None], 3, axis=1)


def creased_normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the normals (m, 3, 3) of triangles with corners (m, 3, 3).

    The normal at a corner is the mean of the normals of the adjacent faces that differ by less than 35 degrees from its own,
    weighted by their angles there, so that it does not depend on the triangulation of a face.
    """
    if not len(corners):
        return np.zeros((0, 3, 3))
    flat = flat_normals(corners)[:, 0]
    ahead, behind = (np.roll(corners, turn, axis=1) - corners for turn in (-1, 1))
    lengths = np.linalg.norm(ahead, axis=2) * np.linalg.norm(behind, axis=2)
    angles = np.arccos(np.clip(np.einsum("ijk,ijk->ij", ahead, behind) / np.maximum(lengths, 1e-30), -1.0, 1.0)).ravel()
    _, point = np.unique(corners.reshape(-1, 3).round(_DIGITS), axis=0, return_inverse=True)
    point = point.ravel()
    # every corner with every corner at the same point
    order, counts = np.argsort(point, kind="stable"), np.bincount(point)
    each = counts[point]
    own = np.repeat(np.arange(len(point)), each)
    step = np.arange(len(own)) - np.repeat(np.cumsum(each) - each, each)
    other = order[(np.cumsum(counts) - counts)[point[own]] + step]
    smooth = np.einsum("ij,ij->i", flat[own // 3], flat[other // 3]) > _CREASE
    own, other = own[smooth], other[smooth]
    weighted = flat[other // 3] * angles[other, None]
    sums = np.stack([np.bincount(own, weighted[:, axis], len(point)) for axis in range(3)], axis=1)
    norms = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(norms > 1e-9, sums / np.maximum(norms, 1e-9), np.repeat(flat, 3, axis=0)).reshape(-1, 3, 3)


_AROUND, _ALONG = 20, 10


@dataclass(frozen=True, eq=False)
class Triangles:
    """Triangles, visible from the side from which their corners are counter-clockwise."""

    corners: NDArray[np.float64]
    """(m, 3, 3) [m]."""
    normals: NDArray[np.float64]
    """Unit normal of each corner (m, 3, 3)."""
    shades: NDArray[np.float64] | None = None
    """How much of the ambient light reaches each corner (m, 3), 0..1; all of it when None."""


def triangles_of(kind: int, size: tuple[float, ...], file: str) -> Triangles | None:
    """Return a visual in its own frame; None for an unknown geometry.

    Args:
        kind: PyBullet's number of the geometry.
        size: box: edges; sphere: radius; cylinder, capsule: length, radius [m]; mesh: factor along each axis.
        file: File of a mesh.
    """
    if kind == bullet.GEOM_MESH:
        return _scaled(_read_obj(Path(file)), size) if file.lower().endswith(".obj") and Path(file).is_file() else None
    if kind == bullet.GEOM_BOX:
        return _scaled(_box(), size)
    if kind == bullet.GEOM_SPHERE:
        return _turned(0.0, size[0])
    if kind == bullet.GEOM_CAPSULE:
        return _turned(size[0], size[1])
    return _cylinder(size[0], size[1]) if kind == bullet.GEOM_CYLINDER else None


def _scaled(triangles: Triangles, factors: tuple[float, ...]) -> Triangles:
    factor = np.array(factors)
    normals = triangles.normals / factor
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return replace(triangles, corners=triangles.corners * factor, normals=normals)


@lru_cache(maxsize=1)
def _box() -> Triangles:
    """The cube with edges of 1 around the origin."""
    square = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]) * 0.5
    faces = [np.roll(square * [1.0, sign, sign], turn, axis=1) for turn in range(3) for sign in (1.0, -1.0)]
    corners = np.array([face[list(part)] for face in faces for part in ((0, 1, 2), (0, 2, 3))])
    return Triangles(corners, flat_normals(corners))


@lru_cache(maxsize=64)
def _turned(length: float, radius: float) -> Triangles:
    """A sphere, or a capsule with a cylinder of some length along z."""
    down = np.linspace(np.pi, 0.0, _ALONG + 1)
    heights = radius * np.cos(down) + np.where(down > np.pi / 2, -0.5, 0.5) * length
    return _swept(heights, radius * np.sin(down), down)


@lru_cache(maxsize=64)
def _cylinder(length: float, radius: float) -> Triangles:
    ends = [(0.5 * length * side, np.array([radius, 0.0])) for side in (-1.0, 1.0)]
    mantle = _swept(np.array([-0.5, 0.5]) * length, np.full(2, radius), np.full(2, np.pi / 2))
    bottom = _swept(np.full(2, ends[0][0]), ends[0][1][::-1], np.full(2, np.pi))
    top = _swept(np.full(2, ends[1][0]), ends[1][1], np.zeros(2))
    parts = (mantle, bottom, top)
    return Triangles(np.concatenate([p.corners for p in parts]), np.concatenate([p.normals for p in parts]))


def _swept(heights: NDArray, radii: NDArray, down: NDArray) -> Triangles:
    """A line from bottom to top, given by height and radius [m], turned around z; `down` is its normal's angle to +z [rad]."""
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND + 1)
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    points = radii[:, None, None] * circle + heights[:, None, None] * up
    normals = np.sin(down)[:, None, None] * circle + np.cos(down)[:, None, None] * up
    corners, at_corners = (_cells(grid) for grid in (points, normals))
    solid = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) > 1e-15
    return Triangles(corners[solid], at_corners[solid])


def _cells(grid: NDArray) -> NDArray:
    """Corners (m, 3, 3) of two triangles per cell of a grid (rows upwards, columns counter-clockwise)."""
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.concatenate([np.stack(part, axis=2).reshape(-1, 3, 3) for part in ((a, b, c), (a, c, d))])


@lru_cache(maxsize=512)
def _read_obj(file: Path) -> Triangles:
    """Read corners, normals and faces; faces with more than three corners become fans, files without normals get some.

    Shades are the brightness of vertex colours, which many programs write after the coordinates.
    """
    points: list[list[float]] = []
    normals: list[list[float]] = []
    shades: list[float] = []
    faces: list[list[tuple[int, int]]] = []
    for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            points.append([float(x) for x in rest[:3]])
            shades.append(sum(float(x) for x in rest[3:6]) / 3.0 if len(rest) >= 6 else 1.0)
        elif word == "vn":
            normals.append([float(x) for x in rest[:3]])
        elif word == "f":
            corners = [_corner(text, len(points), len(normals)) for text in rest]
            faces += [[corners[0], corners[i], corners[i + 1]] for i in range(1, len(corners) - 1)]
    numbers = np.array(faces, dtype=np.int64).reshape(-1, 3, 2)
    corners_at = np.array(points, dtype=float).reshape(-1, 3)[numbers[..., 0]]
    shades_at = None if min(shades, default=1.0) >= 1.0 else np.array(shades)[numbers[..., 0]]
    if len(normals) == 0 or (numbers[..., 1] < 0).any():
        return Triangles(corners_at, creased_normals(corners_at), shades_at)
    at_corners = np.array(normals)[numbers[..., 1]]
    at_corners /= np.maximum(np.linalg.norm(at_corners, axis=2, keepdims=True), 1e-30)
    return Triangles(corners_at, at_corners, shades_at)


def _corner(text: str, points: int, normals: int) -> tuple[int, int]:
    """Numbers of the point and the normal of one corner `v/vt/vn`, -1 for no normal; negative ones count from the end."""
    parts = text.split("/")
    normal = _index(int(parts[2]), normals) if len(parts) > 2 and parts[2] else -1
    return _index(int(parts[0]), points), normal


def _index(number: int, count: int) -> int:
    return number - 1 if number > 0 else count + number
