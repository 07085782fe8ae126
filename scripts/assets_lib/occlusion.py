"""How much of the light from all around reaches the corners of faces, past the other parts of the same link."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from assets_lib.mesh import FloatArray, Mesh

_DIRECTIONS = 64
_REACH = 0.35
"""Surfaces farther away than this block no light [m]."""
_INSETS, _LIFT = (0.15, 0.45, 0.75), 0.0005
"""A corner is judged at points so far towards the middle of its face, and so far above it [m]."""
_BOUNCE, _LEAST = 0.65, 0.4
"""Share of the light that surfaces throw back into a hollow, and how much reaches its darkest corner."""
_STEPS = 20
"""Shades are rounded to so many steps."""


def _directions() -> FloatArray:
    """Return directions (d, 3) spread evenly over a sphere, along a spiral."""
    k = np.arange(_DIRECTIONS)
    z = 1.0 - (2.0 * k + 1.0) / _DIRECTIONS
    angle = k * np.pi * (3.0 - 5.0**0.5) + 0.1
    radius = np.sqrt(1.0 - z * z)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])


def shades_of(meshes: Sequence[Mesh], is_opaque: Sequence[bool]) -> list[FloatArray]:
    """Return for each corner of each face of the meshes of one link how much light reaches it, (m, 3) in 0..1.

    With v the share of directions that are free, light that is thrown back in the hollow makes it v / (1 - b (1 - v)). As a large
    face has few corners, each stands for some of what lies between it and the middle of the face.

    Args:
        meshes: Visual meshes in the frame of the link.
        is_opaque: Whether each keeps light from others.
    """
    corners = [mesh.vertices[mesh.faces] for mesh in meshes]
    solid = [own for own, opaque in zip(corners, is_opaque, strict=True) if opaque]
    blockers = np.concatenate([np.zeros((0, 3, 3)), *solid])
    counts = [len(own) for own in corners]
    every = np.concatenate(corners)
    normals = np.cross(every[:, 1] - every[:, 0], every[:, 2] - every[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    shades = np.zeros((len(every), 3))
    for inset in _INSETS:
        points = every + inset * (every.mean(axis=1, keepdims=True) - every) + _LIFT * normals[:, None]
        free = _free(points.reshape(-1, 3), np.repeat(normals, 3, axis=0), blockers).reshape(-1, 3)
        shades += free / (1.0 - _BOUNCE * (1.0 - free)) / len(_INSETS)
    shades = np.round((_LEAST + (1.0 - _LEAST) * shades) * _STEPS) / _STEPS
    shades[shades > 0.9] = 1.0
    return np.split(shades, np.cumsum(counts)[:-1])


def _free(points: FloatArray, normals: FloatArray, blockers: FloatArray) -> FloatArray:
    """Return the share of the half space above points (n, 3) that triangles (t, 3, 3) leave free, weighted by the cosine."""
    seen, total = np.zeros(len(points)), np.zeros(len(points))
    for direction in _directions():
        cosine = normals @ direction
        chosen = np.flatnonzero(cosine > 0.0)
        total[chosen] += cosine[chosen]
        open_ = chosen[~_blocked(points[chosen], direction, blockers)]
        seen[open_] += cosine[open_]
    return np.where(total > 0.0, seen / np.maximum(total, 1e-30), 1.0)


def _blocked(points: FloatArray, direction: FloatArray, blockers: FloatArray) -> np.ndarray:
    """Return whether the ray from each point (n, 3) along a direction meets a triangle (t, 3, 3) within reach.

    Seen along the direction, a point lies in a triangle where it is on the same side of its three edges, each side an affine
    function of the point.
    """
    a, b, c = (blockers[:, i] for i in range(3))
    along = np.cross(b - a, c - a) @ direction
    facing = np.abs(along) > 1e-12
    a, b, c, along = a[facing], b[facing], c[facing], along[facing]
    if not len(a):
        return np.zeros(len(points), dtype=bool)
    sign = np.sign(along)[:, None]
    inside = np.ones((len(points), len(a)), dtype=bool)
    for first, second in ((a, b), (b, c), (c, a)):
        form = np.cross(direction, second - first) * sign
        inside &= _affine(points, form, first) >= 0.0
    normal = np.cross(b - a, c - a) / along[:, None]
    distance = -_affine(points, normal, a)
    return np.asarray((inside & (distance > 1e-5) & (distance < _REACH)).any(axis=1))


def _affine(points: FloatArray, forms: FloatArray, origins: FloatArray) -> np.ndarray:
    """Return forms (t, 3) of points (n, 3) less those of origins (t, 3), (n, t)."""
    return (points @ forms.T - np.einsum("ij,ij->i", forms, origins)).astype(np.float32)
