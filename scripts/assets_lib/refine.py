"""Division of large flat faces into cells, so that baked light can vary along them. Lengths in [m]."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from assets_lib.mesh import FloatArray, IntArray, Mesh

CELLS = (0.04, 0.05, 0.06, 0.08, 0.1, 0.14, 0.2)
"""Lengths of the edges of cells, of which an object takes the smallest that it can afford [m]."""
_ABOVE, _REACH = 0.005, 5.0
"""A surface that rises so far above a face changes the light on it [m], up to a distance of so many times its height."""

Quad = tuple[int, int, int, int, int, int]
"""Two faces of a mesh, and the corners of the parallelogram that they form."""


def quads_of(mesh: Mesh) -> list[Quad]:
    """Return the pairs of faces that share their longest edge and form a flat parallelogram."""
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    longest = np.argmax(np.round(lengths, 9), axis=1)
    waiting: dict[tuple[int, int], int] = {}
    quads: list[Quad] = []
    for face, k in enumerate(longest.tolist()):
        a, b, apex = (int(mesh.faces[face, (k + i) % 3]) for i in range(3))
        other = waiting.pop((b, a), None)
        if other is None:
            waiting[(a, b)] = face
            continue
        opposite = int(mesh.faces[other, (longest[other] + 2) % 3])
        ends = mesh.vertices[[a, b]].sum(axis=0) - mesh.vertices[[apex, opposite]].sum(axis=0)
        if np.abs(ends).max() < 2e-6 and normals[face] @ normals[other] > 1.0 - 1e-9:
            quads.append((other, face, a, opposite, b, apex))
    return quads


def shaded_quads(meshes: Sequence[Mesh]) -> list[list[Quad]]:
    """Return of each mesh of a link the parallelograms above which a surface of the link rises."""
    points = np.concatenate([mesh.vertices for mesh in meshes])
    found = []
    for mesh in meshes:
        own = []
        for quad in quads_of(mesh):
            a, b, c, d = mesh.vertices[list(quad[2:])]
            normal = np.cross(b - a, d - a)
            normal /= np.linalg.norm(normal)
            height = (points - a) @ normal
            away = points - points.clip(np.min([a, b, c, d], axis=0), np.max([a, b, c, d], axis=0))
            if ((height > _ABOVE) & (np.linalg.norm(away, axis=1) < _REACH * height)).any():
                own.append(quad)
        found.append(own)
    return found


def _pieces(mesh: Mesh, quad: Quad, cell: float) -> tuple[int, int]:
    """Return into how many cells a parallelogram is cut along its first and its second edge."""
    a, b, _, d = mesh.vertices[list(quad[2:])]
    return tuple(max(1, int(np.ceil(np.linalg.norm(end - a) / cell - 1e-6))) for end in (b, d))  # type: ignore[return-value]


def added(mesh: Mesh, quads: Sequence[Quad], cell: float) -> int:
    """Return by how many triangles a mesh grows when its parallelograms are cut into cells."""
    counts = [_pieces(mesh, quad, cell) for quad in quads]
    return sum(2 * across * along - 2 for across, along in counts)


def cut(mesh: Mesh, normals: FloatArray, quads: Sequence[Quad], cell: float) -> tuple[Mesh, FloatArray]:
    """Cut parallelograms of a mesh into cells.

    Args:
        mesh: The mesh.
        normals: Of the corners of its faces, (m, 3, 3).
        quads: Its parallelograms.
        cell: Longest edge of a cell [m].

    Returns:
        The new mesh and its normals.
    """
    vertices, faces, corners = [mesh.vertices], [], []
    known = {tuple(np.round(vertex, 6)): number for number, vertex in enumerate(mesh.vertices)}
    new: list[FloatArray] = []
    kept = np.ones(len(mesh.faces), dtype=bool)
    for quad in quads:
        across, along = _pieces(mesh, quad, cell)
        if across * along == 1:
            continue
        kept[list(quad[:2])] = False
        ends = np.array(quad[2:])
        at = {int(v): n for face in quad[:2] for v, n in zip(mesh.faces[face], normals[face], strict=True)}
        weights = _weights(across, along)
        places, directions = weights @ mesh.vertices[ends], weights @ np.array([at[int(end)] for end in ends])
        directions /= np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-30)
        numbers = []
        for place in places:
            key = tuple(np.round(place, 6))
            if key not in known:
                known[key] = len(mesh.vertices) + len(new)
                new.append(place)
            numbers.append(known[key])
        for triangle in _triangles(across, along):
            faces.append([numbers[i] for i in triangle])
            corners.append(directions[list(triangle)])
    if not faces:
        return mesh, normals
    if new:
        vertices.append(np.array(new))
    every: IntArray = np.concatenate([mesh.faces[kept], np.array(faces)])
    return Mesh(np.concatenate(vertices), every), np.concatenate([normals[kept], np.array(corners)])


def _weights(across: int, along: int) -> FloatArray:
    """Return the weights (n, 4) of the corners of a parallelogram at the corners of its cells, row by row."""
    v, u = (part.ravel() for part in np.meshgrid(np.arange(along + 1) / along, np.arange(across + 1) / across, indexing="ij"))
    return np.column_stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v])


def _triangles(across: int, along: int) -> list[tuple[int, int, int]]:
    """Return the triangles of the cells, their diagonals in turn so that no direction stands out."""
    found = []
    for row in range(along):
        for column in range(across):
            a = row * (across + 1) + column
            b, d = a + 1, a + across + 1
            c = d + 1
            found += [(a, b, c), (a, c, d)] if (row + column) % 2 == 0 else [(a, b, d), (b, c, d)]
    return found
