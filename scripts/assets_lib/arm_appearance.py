"""The appearance of arm links: detailed meshes are reduced to few triangles with the normals of the detailed surface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from assets_lib.collapse import collapse, quadrics_of, sharp_edges
from assets_lib.dae import Rgb
from assets_lib.decimate import samples, seen_from_outside, weld, without_small_holes
from assets_lib.mesh import FloatArray, IntArray, Mesh, corner_normals

DETAIL = 0.012
"""Parts with a smaller diagonal [m], such as letters and screws, are left out."""
SMALL, SMALL_WEIGHT = 0.045, 0.2
"""Pieces with a smaller diagonal [m], such as sockets, count so much less."""
CREASE = 0.7
"""Edges whose faces differ by more [rad] keep their course."""
KEPT, HIDDEN, BETWEEN = 0.3, 0.02, 0.25
"""Weight of borders and of edges behind which something hidden was cut away; share of triangles after the first pass."""
NEAR, ALIKE = 0.001, 0.7
"""How far from a corner [m], and with which least cosine to its face, a normal of the source is looked for."""


@dataclass(frozen=True)
class Piece:
    """A coloured surface of one part."""

    part: str
    number: int
    """Its place in the file of the part."""
    color: Rgb
    mesh: Mesh


@dataclass(frozen=True)
class Appearance:
    """A piece with few triangles."""

    piece: Piece
    normals: FloatArray
    """Unit normals of the corners of its faces, shape (m, 3, 3)."""


def light_appearances(
    parts: Mapping[str, Sequence[tuple[Rgb, Mesh]]], weights: Mapping[str, float], target: int
) -> list[Appearance]:
    """Return all pieces of all parts with about `target` triangles together.

    The first pass, without regard for edges, takes away what is smaller than a tenth of a millimetre, steps and grooves between
    shells above all; the second one keeps the edges that are left.

    Args:
        parts: The coloured pieces of each part.
        weights: How much more than others a part counts.
        target: Triangles.
    """
    pieces, quadrics = [], []
    for part, colored in parts.items():
        coarse = [
            (number, color, without_small_holes(_without_details(weld(mesh, 5)), DETAIL))
            for number, (color, mesh) in enumerate(colored)
        ]
        whole = [(number, color, mesh) for number, color, mesh in coarse if len(mesh.faces)]
        seen = seen_from_outside([mesh for *_, mesh in whole]) if len(whole) > 1 else [mesh for *_, mesh in whole]
        for (number, color, mesh), outer in zip(whole, seen, strict=True):
            pieces.append(Piece(part, number, color, outer))
            quadrics.append(_border_quadrics(mesh, outer))
    faces = sum(len(piece.mesh.faces) for piece in pieces)
    middle = collapse([piece.mesh for piece in pieces], quadrics, int(BETWEEN * faces))
    quadrics = [_edge_quadrics(mesh) * _weight(mesh, weights.get(p.part)) for p, mesh in zip(pieces, middle, strict=True)]
    light = collapse(middle, quadrics, target)
    return [
        Appearance(Piece(piece.part, piece.number, piece.color, mesh), _normals_from(mesh, source))
        for piece, mesh, source in zip(pieces, light, middle, strict=True)
        if len(mesh.faces)
    ]


def _diagonal(points: FloatArray) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0


def _without_details(mesh: Mesh) -> Mesh:
    """Leave out what hangs together and is small."""
    links = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]]])
    size = len(mesh.vertices)
    count, of = connected_components(coo_array((np.ones(len(links)), tuple(links.T)), shape=(size, size)), directed=False)
    large = np.array([_diagonal(mesh.vertices[of == i]) > DETAIL for i in range(count)])
    return Mesh(mesh.vertices, mesh.faces[large[of[mesh.faces[:, 0]]]])


def _border_quadrics(whole: Mesh, outer: Mesh) -> FloatArray:
    """Quadrics of what is left of a piece; borders that are no edges of the whole piece hardly count."""
    sharp = {tuple(edge) for edge in np.sort(sharp_edges(whole, CREASE)[0], axis=1).tolist()}
    edges, uprights = sharp_edges(outer, np.pi)
    weights = np.array([KEPT if tuple(edge) in sharp else HIDDEN for edge in np.sort(edges, axis=1).tolist()])
    return quadrics_of(outer, edges, uprights, weights)


def _edge_quadrics(mesh: Mesh) -> FloatArray:
    edges, uprights = sharp_edges(mesh, CREASE)
    return quadrics_of(mesh, edges, uprights, np.full(len(edges), KEPT))


def _weight(mesh: Mesh, given: float | None) -> float:
    if given is not None:
        return given
    return SMALL_WEIGHT if _diagonal(mesh.vertices) < SMALL else 1.0


def _normals_from(mesh: Mesh, source: Mesh) -> FloatArray:
    """Return for each corner of each face the normal of the source next to it, shape (m, 3, 3).

    Of those near by, the one most like that of the face is taken, so that flat faces beside rounded edges stay flat.
    """
    points, normals = _points_with_normals(source)
    tree, corners = KDTree(points), mesh.vertices[mesh.faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-30)
    distances, found = tree.query(mesh.vertices, k=min(60, len(points)))
    result = np.zeros_like(corners)
    rows = np.arange(len(flat))
    for corner in range(3):
        at = mesh.faces[:, corner]
        candidates = normals[found[at]]
        likeness = np.einsum("mkj,mj->mk", candidates, flat)
        fits = (distances[at] < distances[at, :1] + NEAR) & (likeness > ALIKE)
        best = np.where(fits, likeness, -2.0).argmax(axis=1)
        result[:, corner] = np.where(fits.any(axis=1)[:, None], candidates[rows, best], flat)
    return result


def _points_with_normals(source: Mesh) -> tuple[FloatArray, FloatArray]:
    """Spread points over a mesh, about one a millimetre; return them and the smooth normals there, each (n, 3)."""
    points, faces = samples(source.vertices[source.faces], 0.002)
    weights = _barycentric(points, source.vertices[source.faces], faces)
    normals = np.einsum("ik,ikj->ij", weights, corner_normals(source, 0.6)[faces])
    return points, normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


def _barycentric(points: FloatArray, corners: FloatArray, faces: IntArray) -> FloatArray:
    """Return the weights (n, 3) of the corners of its face for each point."""
    a, b, c = (corners[faces][:, i] for i in range(3))
    normal = np.cross(b - a, c - a)
    square = np.maximum((normal**2).sum(axis=1), 1e-30)
    second = (np.cross(points - a, c - a) * normal).sum(axis=1) / square
    third = (np.cross(b - a, points - a) * normal).sum(axis=1) / square
    return np.column_stack([1.0 - second - third, second, third])
