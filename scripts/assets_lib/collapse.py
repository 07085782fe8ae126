"""Mesh reduction by edge collapse, the cheapest edge first, for many meshes at once.

The cost of an edge is the quadric error of Garland and Heckbert (1997): the squared distances of its new point to the planes
of the original faces, times their areas. Sharp edges and borders add perpendicular planes, which preserve their shape.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from assets_lib.mesh import FloatArray, IntArray, Mesh

Point = tuple[float, float, float]
Quadric = tuple[float, ...]
"""The ten numbers of a symmetric 4 x 4 matrix: xx, xy, xz, xw, yy, yz, yw, zz, zw, ww."""

FLIP = 0.4
"""Cosine of the largest turn of a face in one collapse."""
SHAPE = 0.03
"""Least quality of a triangle that was not nearly as bad before; an equilateral one has 1, a line 0."""
EDGE_WEIGHT = 1e-9
"""Cost of length [m^2]: among equals the shortest edge goes first."""


def collapse(meshes: Sequence[Mesh], quadrics: Sequence[FloatArray], target: int) -> list[Mesh]:
    """Return the meshes with about `target` faces all together.

    Args:
        meshes: Welded meshes.
        quadrics: For each of them the quadrics of its vertices, shape (n, 10), as `quadrics_of` makes them.
        target: Faces to keep.
    """
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    points = np.concatenate([mesh.vertices for mesh in meshes])
    faces = np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets)])
    work = _Collapse(points, faces, np.concatenate(quadrics))
    work.run(target)
    return [work.part(int(a), int(b)) for a, b in pairwise(offsets)]


def quadrics_of(mesh: Mesh, edges: IntArray, uprights: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the quadrics of a mesh's vertices, shape (n, 10).

    Args:
        mesh: The mesh.
        edges: Edges to keep, shape (k, 2).
        uprights: Unit normals of the planes through them, shape (k, 3).
        weights: Of each, multiplied by its squared length, shape (k,).
    """
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1) / 2.0
    normals /= np.maximum(2.0 * areas, 1e-30)[:, None]
    result = np.zeros((len(mesh.vertices), 10))
    of_faces = _plane_quadrics(normals, a) * areas[:, None] / 3.0
    for corner in range(3):
        np.add.at(result, mesh.faces[:, corner], of_faces)
    start, end = mesh.vertices[edges[:, 0]], mesh.vertices[edges[:, 1]]
    of_edges = _plane_quadrics(uprights, start) * (weights * ((end - start) ** 2).sum(axis=1))[:, None]
    for corner in range(2):
        np.add.at(result, edges[:, corner], of_edges)
    return result


def _plane_quadrics(normals: FloatArray, points: FloatArray) -> FloatArray:
    """Return the quadrics of planes with unit normals (k, 3) through points (k, 3), shape (k, 10)."""
    plane = np.column_stack([normals, -(normals * points).sum(axis=1)])
    return np.stack([plane[:, i] * plane[:, j] for i in range(4) for j in range(i, 4)], axis=1)


class _Collapse:
    """A mesh whose edges collapse one after the other."""

    def __init__(self, points: FloatArray, faces: IntArray, quadrics: FloatArray) -> None:
        self._points: list[Point] = [(x, y, z) for x, y, z in points.tolist()]
        self._quadrics: list[Quadric] = [tuple(row) for row in quadrics.tolist()]
        self._faces: dict[int, tuple[int, int, int]] = {i: (a, b, c) for i, (a, b, c) in enumerate(faces.tolist())}
        self._around: list[set[int]] = [set() for _ in self._points]
        for i, face in self._faces.items():
            for corner in face:
                self._around[corner].add(i)
        self._versions = [0] * len(self._points)
        self._heap: list[tuple[float, int, int, int, int, Point]] = []

    def run(self, target: int) -> None:
        """Collapse the cheapest edge until `target` faces are left, or nothing can go."""
        edges = {(min(e), max(e)) for a, b, c in self._faces.values() for e in ((a, b), (b, c), (c, a))}
        self._heap = [self._entry(a, b) for a, b in sorted(edges)]
        heapq.heapify(self._heap)
        while self._heap and len(self._faces) > target:
            _, a, b, version_a, version_b, point = heapq.heappop(self._heap)
            if self._versions[a] == version_a and self._versions[b] == version_b and self._may(a, b, point):
                self._join(a, b, point)

    def part(self, first: int, end: int) -> Mesh:
        """Return the faces between the vertices `first` and `end`, without vertices that nobody uses."""
        faces = np.array([f for f in self._faces.values() if first <= f[0] < end], dtype=np.int64).reshape(-1, 3)
        used = np.unique(faces)
        index = np.zeros(end, dtype=np.int64)
        index[used] = np.arange(len(used))
        return Mesh(np.array([self._points[i] for i in used]).reshape(-1, 3), index[faces])

    def _entry(self, a: int, b: int) -> tuple[float, int, int, int, int, Point]:
        p, q = self._points[a], self._points[b]
        total = tuple(map(sum, zip(self._quadrics[a], self._quadrics[b])))
        middle = ((p[0] + q[0]) / 2.0, (p[1] + q[1]) / 2.0, (p[2] + q[2]) / 2.0)
        best = _lowest(total, middle)
        length = sum((x - y) ** 2 for x, y in zip(p, q))
        if sum((x - y) ** 2 for x, y in zip(best, middle)) > 4.0 * length:
            best = middle
        cost, point = min((_error(total, x), x) for x in (best, middle, p, q))
        return cost + EDGE_WEIGHT * length, a, b, self._versions[a], self._versions[b], point

    def _neighbours(self, a: int) -> set[int]:
        return {corner for i in self._around[a] for corner in self._faces[i]} - {a}

    def _may(self, a: int, b: int, point: Point) -> bool:
        """Whether the surface stays one without folds and needles when `a` and `b` become one point."""
        shared = self._around[a] & self._around[b]
        if len(self._neighbours(a) & self._neighbours(b)) != len(shared) or not 1 <= len(shared) <= 2:
            return False
        if len(shared) == 2 and self._is_open(a) and self._is_open(b):
            return False
        return all(self._bears(i, corner, point) for corner in (a, b) for i in self._around[corner] - shared)

    def _is_open(self, a: int) -> bool:
        return len(self._neighbours(a)) != len(self._around[a])

    def _bears(self, face: int, corner: int, point: Point) -> bool:
        """Whether a face stays itself when one of its corners moves to a point."""
        old = [self._points[i] for i in self._faces[face]]
        new = [point if i == corner else self._points[i] for i in self._faces[face]]
        (before, double, sides), (after, double_after, sides_after) = _shape(old), _shape(new)
        turn = sum(x * y for x, y in zip(before, after))
        least = min(SHAPE, 1.6 * 3.0**0.5 * double / max(sides, 1e-30))
        return turn > FLIP * double * double_after and 2.0 * 3.0**0.5 * double_after >= least * sides_after

    def _join(self, a: int, b: int, point: Point) -> None:
        for i in sorted(self._around[a] & self._around[b]):
            for corner in self._faces.pop(i):
                self._around[corner].discard(i)
        for i in sorted(self._around[b]):
            first, second, third = (a if corner == b else corner for corner in self._faces[i])
            self._faces[i] = (first, second, third)
            self._around[a].add(i)
        self._around[b] = set()
        self._points[a] = point
        self._quadrics[a] = tuple(map(sum, zip(self._quadrics[a], self._quadrics[b])))
        self._versions[a] += 1
        self._versions[b] += 1
        for other in sorted(self._neighbours(a)):
            heapq.heappush(self._heap, self._entry(min(a, other), max(a, other)))


def _shape(corners: Sequence[Point]) -> tuple[Point, float, float]:
    """Return normal, twice the area, and the sum of the squared sides of a triangle."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corners
    ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
    normal = (uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx)
    third = (vx - ux) ** 2 + (vy - uy) ** 2 + (vz - uz) ** 2
    sides = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz + third
    return normal, sum(x * x for x in normal) ** 0.5, sides


def _error(quadric: Quadric, point: Point) -> float:
    """Return the weighted sum of squared distances of a point to the planes in a quadric, at least 0."""
    xx, xy, xz, xw, yy, yz, yw, zz, zw, ww = quadric
    x, y, z = point
    half = x * (xy * y + xz * z + xw) + y * (yz * z + yw) + z * zw
    return max(xx * x * x + yy * y * y + zz * z * z + 2.0 * half + ww, 0.0)


def _lowest(quadric: Quadric, near: Point) -> Point:
    """Return the point with the least error; where a plane or a line has it, about the one of them next to `near`."""
    xx, xy, xz, xw, yy, yz, yw, zz, zw, _ = quadric
    hold = 1e-3 * (xx + yy + zz) + 1e-30
    xx, yy, zz = xx + hold, yy + hold, zz + hold
    # the gradient at `near`, so that the pull of `hold` is towards it
    gx = xx * near[0] + xy * near[1] + xz * near[2] + xw - hold * near[0]
    gy = xy * near[0] + yy * near[1] + yz * near[2] + yw - hold * near[1]
    gz = xz * near[0] + yz * near[1] + zz * near[2] + zw - hold * near[2]
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    determinant = xx * a + xy * b + xz * c
    d, e, f = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    return (
        near[0] - (a * gx + b * gy + c * gz) / determinant,
        near[1] - (b * gx + d * gy + e * gz) / determinant,
        near[2] - (c * gx + e * gy + f * gz) / determinant,
    )


def sharp_edges(mesh: Mesh, crease: float) -> tuple[IntArray, FloatArray]:
    """Return the borders (k, 2) of a mesh and the edges whose faces differ by more than `crease` [rad], with upright planes.

    Returns:
        Edges, shape (k, 2); unit normals of planes through them that are upright on one of their faces, shape (k, 3).
    """
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    of: dict[tuple[int, int], list[int]] = {}
    for i, (p, q, r) in enumerate(mesh.faces.tolist()):
        for edge in ((p, q), (q, r), (r, p)):
            of.setdefault((min(edge), max(edge)), []).append(i)
    kept = [(edge, i) for edge, faces in of.items() if _is_sharp(normals, faces, np.cos(crease)) for i in faces]
    edges = np.array([edge for edge, _ in kept], dtype=np.int64).reshape(-1, 2)
    along = mesh.vertices[edges[:, 1]] - mesh.vertices[edges[:, 0]]
    upright = np.cross(along, normals[[i for _, i in kept]].reshape(-1, 3))
    return edges, upright / np.maximum(np.linalg.norm(upright, axis=1, keepdims=True), 1e-30)


def _is_sharp(normals: FloatArray, faces: Iterable[int], limit: float) -> bool:
    first, *rest = faces
    return not rest or any(normals[first] @ normals[i] < limit for i in rest)
