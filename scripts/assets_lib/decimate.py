"""Reduce meshes: weld vertices, remove hidden faces, and compute a hull with few vertices."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, hull_of, icosphere


def weld(mesh: Mesh, digits: int = 6) -> Mesh:
    """Join equal vertices and drop faces that became lines and vertices that nobody uses."""
    keys, index = np.unique(np.round(mesh.vertices, digits) + 0.0, axis=0, return_inverse=True)
    faces = index.reshape(-1)[mesh.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    used = np.unique(faces)
    renumber = np.zeros(len(keys), dtype=np.int64)
    renumber[used] = np.arange(len(used))
    return Mesh(keys[used], renumber[faces])


def without_small_holes(mesh: Mesh, size: float) -> Mesh:
    """Close the holes whose border has a diagonal below `size` [m] with a fan around their middle."""
    sides = {edge for a, b, c in mesh.faces.tolist() for edge in ((a, b), (b, c), (c, a))}
    ahead: dict[int, list[int]] = {}
    for a, b in sorted(sides):
        if (b, a) not in sides:
            ahead.setdefault(b, []).append(a)
    points, faces = [mesh.vertices], [mesh.faces]
    count = len(mesh.vertices)
    for first in sorted(ahead):
        loop = _loop(ahead, first)
        corners = mesh.vertices[loop]
        if len(loop) > 2 and np.linalg.norm(np.ptp(corners, axis=0)) < size:
            points.append(corners.mean(axis=0, keepdims=True))
            faces.append(np.column_stack([loop, np.roll(loop, -1), np.full(len(loop), count)]))
            count += 1
    return Mesh(np.concatenate(points), np.concatenate(faces))


def _loop(ahead: dict[int, list[int]], first: int) -> list[int]:
    """Take the border that begins at a point; nothing where it does not come back or branches."""
    loop, here = [first], ahead.pop(first, [])
    while len(here) == 1 and here[0] != first and here[0] in ahead:
        loop.append(here[0])
        here = ahead.pop(here[0])
    return loop if here == [first] else []


def seen_from_outside(meshes: list[Mesh], cell: float = 0.002, tolerance: float = 0.0014) -> list[Mesh]:
    """Drop the faces of parts that no far viewer sees, by point depth images from 42 directions."""
    owner = np.concatenate([np.full(len(m.faces), i) for i, m in enumerate(meshes)])
    corners = np.concatenate([m.vertices[m.faces] for m in meshes])
    points, face_of = samples(corners, cell)
    visible = np.zeros(len(corners), dtype=bool)
    for direction in icosphere(1.0, 1).vertices:
        helper = np.array([1.0, 0.0, 0.0]) if abs(direction[0]) < 0.7 else np.array([0.0, 1.0, 0.0])
        u = np.cross(direction, helper)
        u /= np.linalg.norm(u)
        v = np.cross(direction, u)
        grid = np.floor(np.column_stack([points @ u, points @ v]) / cell).astype(np.int64)
        grid -= grid.min(axis=0)
        flat = grid[:, 0] * (grid[:, 1].max() + 1) + grid[:, 1]
        depth = points @ direction
        front = np.full(flat.max() + 1, -np.inf)
        np.maximum.at(front, flat, depth)
        visible[np.unique(face_of[depth >= front[flat] - tolerance])] = True
    result = []
    for i, mesh in enumerate(meshes):
        keep = visible[owner == i]
        result.append(Mesh(mesh.vertices, mesh.faces[keep]))
    return result


def samples(corners: FloatArray, cell: float) -> tuple[FloatArray, np.ndarray]:
    """Spread points over triangles (m, 3, 3), about one per half cell; return them and the face of each."""
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    steps = np.clip(np.ceil(sides / (0.5 * cell)), 1, 60).astype(int)
    points, faces = [], []
    for n in np.unique(steps):
        chosen = np.flatnonzero(steps == n)
        i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
        inside = i + j < n
        a, b = (i[inside] + 1.0 / 3.0) / n, (j[inside] + 1.0 / 3.0) / n
        weights = np.column_stack([1.0 - a - b, a, b])
        points.append(np.einsum("wk,fkx->fwx", weights, corners[chosen]).reshape(-1, 3))
        faces.append(np.repeat(chosen, len(weights)))
    return np.concatenate(points), np.concatenate(faces)


def small_hull(points: FloatArray, count: int) -> Mesh:
    """Return a convex hull of at most `count` vertices that encloses the points closely.

    The vertices are those that the others leave the farthest outside, one after the other. Planes that still cut points off are
    then pushed out, each by shifting its corners, until nothing is outside.
    """
    full = hull_of(points).vertices
    center = (full.min(axis=0) + full.max(axis=0)) / 2.0
    directions = icosphere(1.0, 1).vertices
    chosen = sorted({int(np.argmax(full @ d)) for d in directions[:12]})
    while len(chosen) < min(count, len(full)):
        out = _outside(full, hull_of(full[chosen]))
        worst = int(np.argmax(out))
        if out[worst] < 1e-4:
            break
        chosen.append(worst)
    hull = hull_of(full[chosen])
    for _ in range(60):
        normals, offsets = _planes(hull)
        cut = (full @ normals.T - offsets).max(axis=0)
        if cut.max() < 5e-5:
            break
        shift = np.zeros_like(hull.vertices)
        for face in np.argsort(cut):
            if cut[face] > 0.0:
                for corner in hull.faces[face]:
                    missing = cut[face] - shift[corner] @ normals[face]
                    shift[corner] += 0.4 * max(missing, 0.0) * normals[face]
        hull = hull_of(hull.vertices + shift)
    return Mesh((hull.vertices - center) * _scale_to_enclose(full, hull, center) + center, hull.faces)


def _planes(hull: Mesh) -> tuple[FloatArray, FloatArray]:
    a, b, c = (hull.vertices[hull.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, np.einsum("ij,ij->i", normals, a)


def _outside(points: FloatArray, hull: Mesh) -> FloatArray:
    """Return how far each point lies outside the worst plane of a hull [m]."""
    normals, offsets = _planes(hull)
    return (points @ normals.T - offsets).max(axis=1)


def _scale_to_enclose(points: FloatArray, hull: Mesh, center: FloatArray) -> float:
    normals, offsets = _planes(hull)
    return float((((points - center) @ normals.T) / (offsets - normals @ center)).max())
