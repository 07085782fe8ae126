"""Triangle meshes as plain arrays, primitives, and mass properties.

Lengths in [m], angles in [rad]. Faces are counter-clockwise seen from outside.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh."""

    vertices: FloatArray
    """Shape (n, 3), [m]."""
    faces: IntArray
    """Shape (m, 3), indices into `vertices`."""
    uv: FloatArray | None = None
    """Texture coordinates, shape (n, 2)."""

    def moved(self, xyz: Sequence[float] = (0.0, 0.0, 0.0), rpy: Sequence[float] = (0.0, 0.0, 0.0)) -> Mesh:
        """Return the mesh rotated by `rpy` about its origin, then shifted by `xyz`."""
        return Mesh(self.vertices @ rotation(rpy).T + np.asarray(xyz, dtype=float), self.faces, self.uv)

    def scaled(self, factors: Sequence[float]) -> Mesh:
        """Return the mesh stretched by positive factors along its axes."""
        return Mesh(self.vertices * np.asarray(factors, dtype=float), self.faces, self.uv)

    def bounds(self) -> FloatArray:
        """Return the corners of the axis-aligned box, shape (2, 3), [m]."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])


def rotation(rpy: Sequence[float]) -> FloatArray:
    """Return the rotation matrix (3, 3) of URDF roll, pitch, yaw [rad]."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def merge(meshes: Iterable[Mesh]) -> Mesh:
    """Put several meshes into one; texture coordinates are dropped."""
    parts = tuple(meshes)
    offsets = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    return Mesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + offset for part, offset in zip(parts, offsets, strict=True)]),
    )


def box(size: Sequence[float], center: Sequence[float] = (0.0, 0.0, 0.0)) -> Mesh:
    """Return a box of `size` x, y, z."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    return Mesh(corners * np.asarray(size, dtype=float) + np.asarray(center, dtype=float), np.array(faces))


def lathe(profile: Sequence[tuple[float, float]], segments: int = 20, *, phase: float = 0.0) -> Mesh:
    """Turn an outline about the z axis.

    Args:
        profile: Points (radius, z) [m]. Walked upwards it has the outside on its right, so outer walls go up and
            inner walls go down. Points on the axis have radius 0; a profile that ends off the axis stays open there.
        segments: Number of sides.
        phase: Angle of the first vertex [rad].
    """
    angles = phase + 2.0 * np.pi * np.arange(segments) / segments
    rings: list[IntArray] = []
    vertices: list[list[float]] = []
    for radius, z in profile:
        start = len(vertices)
        if radius == 0.0:
            vertices.append([0.0, 0.0, z])
            rings.append(np.full(segments, start))
        else:
            vertices += [[radius * float(np.cos(a)), radius * float(np.sin(a)), z] for a in angles]
            rings.append(start + np.arange(segments))
    faces: list[tuple[int, int, int]] = []
    for low, high in pairwise(rings):
        for i in range(segments):
            j = (i + 1) % segments
            a, b, c, d = (int(v) for v in (low[i], low[j], high[j], high[i]))
            faces += [f for f in ((a, b, c), (a, c, d)) if len(set(f)) == 3]
    return Mesh(np.array(vertices), np.array(faces))


def cylinder(radius: float, length: float, segments: int = 16, *, bevel: float = 0.0) -> Mesh:
    """Return a closed cylinder along z, centred, optionally with bevelled edges."""
    h = length / 2.0
    if bevel > 0.0:
        outline = [(0.0, -h), (radius - bevel, -h), (radius, -h + bevel), (radius, h - bevel), (radius - bevel, h), (0.0, h)]
    else:
        outline = [(0.0, -h), (radius, -h), (radius, h), (0.0, h)]
    return lathe(outline, segments)


def rod(start: Sequence[float], end: Sequence[float], radius: float, segments: int = 10) -> Mesh:
    """Return a closed cylinder between two points."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    along = (b - a) / np.linalg.norm(b - a)
    helper = np.array([1.0, 0.0, 0.0]) if abs(along[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    side = np.cross(along, helper) / np.linalg.norm(np.cross(along, helper))
    frame = np.column_stack([side, np.cross(along, side), along])
    body = cylinder(radius, float(np.linalg.norm(b - a)), segments)
    return Mesh(body.vertices @ frame.T + (a + b) / 2.0, body.faces)


def icosphere(radius: float, subdivisions: int = 2) -> Mesh:
    """Return a sphere made of 20 * 4**subdivisions triangles."""
    g = (1.0 + 5.0**0.5) / 2.0
    points = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g)]
    points += [(0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    hull = hull_of(np.array(points, dtype=float))
    vertices, faces = hull.vertices, hull.faces
    for _ in range(subdivisions):
        middle: dict[tuple[int, int], int] = {}
        points_list = list(vertices)
        new: list[tuple[int, int, int]] = []
        for a, b, c in faces.tolist():
            ab, bc, ca = (_middle(points_list, middle, *edge) for edge in ((a, b), (b, c), (c, a)))
            new += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        vertices, faces = np.array(points_list), np.array(new)
    return Mesh(vertices / np.linalg.norm(vertices, axis=1, keepdims=True) * radius, faces)


def _middle(points: list[FloatArray], known: dict[tuple[int, int], int], a: int, b: int) -> int:
    """Return the index of the middle of an edge, adding the point at its first use."""
    key = (min(a, b), max(a, b))
    if key not in known:
        known[key] = len(points)
        points.append((points[a] + points[b]) / 2.0)
    return known[key]


def hull_of(points: FloatArray) -> Mesh:
    """Return the convex hull of points (n, 3), with faces turned outwards."""
    hull = ConvexHull(points)
    used = np.unique(hull.simplices)
    index = np.zeros(len(points), dtype=np.int64)
    index[used] = np.arange(len(used))
    faces = index[hull.simplices]
    vertices = points[used]
    normals = np.cross(vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]])
    inward = np.einsum("ij,ij->i", normals, hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return Mesh(vertices, faces)


def corner_normals(mesh: Mesh, crease: float) -> FloatArray:
    """Return a unit normal for every corner of every face, shape (m, 3, 3).

    Faces that share a vertex and differ by less than `crease` [rad] are smoothed together, weighted by area.
    """
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    weighted = np.cross(b - a, c - a)
    unit = weighted / np.maximum(np.linalg.norm(weighted, axis=1, keepdims=True), 1e-30)
    keys = np.round(mesh.vertices, 7) + 0.0
    _, welded = np.unique(keys, axis=0, return_inverse=True)
    welded = welded.reshape(-1)
    around: dict[int, list[int]] = {}
    for face, corners in enumerate(mesh.faces.tolist()):
        for corner in corners:
            around.setdefault(int(welded[corner]), []).append(face)
    result = np.zeros((len(mesh.faces), 3, 3))
    limit = np.cos(crease)
    for face, corners in enumerate(mesh.faces.tolist()):
        for k, corner in enumerate(corners):
            near = around[int(welded[corner])]
            total = weighted[near][unit[near] @ unit[face] >= limit - 1e-9].sum(axis=0)
            norm = np.linalg.norm(total)
            result[face, k] = total / norm if norm > 1e-30 else (0.0, 0.0, 1.0)
    return result


def mass_properties(mesh: Mesh) -> tuple[float, FloatArray, FloatArray]:
    """Return volume [m^3], centre [m] and second moments about it at unit density, shape (3, 3), of a closed mesh."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    volume = float(volumes.sum())
    center = (volumes[:, None] * (a + b + c) / 4.0).sum(axis=0) / volume
    a, b, c = a - center, b - center, c - center
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    total = a + b + c
    covariance = sum(np.einsum("i,ij,ik->jk", volumes, p, p) for p in (a, b, c, total)) / 20.0
    return volume, center, np.trace(covariance) * np.eye(3) - covariance
