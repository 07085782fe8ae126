"""Make meshes small: drop what is never seen, weld, decimate, and enclose in a hull with few vertices."""

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


def seen_from_outside(meshes: list[Mesh], cell: float = 0.0015, tolerance: float = 0.003) -> list[Mesh]:
    """Drop the faces of parts that no far viewer sees, by point depth images from 162 directions."""
    owner = np.concatenate([np.full(len(m.faces), i) for i, m in enumerate(meshes)])
    corners = np.concatenate([m.vertices[m.faces] for m in meshes])
    points, face_of = _samples(corners, cell)
    visible = np.zeros(len(corners), dtype=bool)
    for direction in icosphere(1.0, 2).vertices:
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


def _samples(corners: FloatArray, cell: float) -> tuple[FloatArray, np.ndarray]:
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


def decimate(mesh: Mesh, target: int, aggression: float = 5.0) -> Mesh:
    """Return about `target` faces; needs the package fast-simplification."""
    import fast_simplification

    mesh = weld(mesh, 5)
    if len(mesh.faces) <= target:
        return mesh
    points, faces = fast_simplification.simplify(
        mesh.vertices.astype(np.float64), mesh.faces.astype(np.int32), target_count=target, agg=aggression
    )
    return weld(Mesh(np.asarray(points, dtype=float), np.asarray(faces, dtype=np.int64)), 5)


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
