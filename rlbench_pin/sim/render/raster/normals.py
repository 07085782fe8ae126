"""Normals at the corners of triangles for meshes that bring none: smooth over blunt edges, sharp at others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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

    At each corner it is the mean of the normals of those faces around it that turn by less than 35 degrees from its own, weighted
    by their angles there, so that it does not depend on how a face is cut into triangles.
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
