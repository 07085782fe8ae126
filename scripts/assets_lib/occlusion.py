"""Ambient occlusion: the fraction of ambient light that reaches the corners of faces past other parts of the same link."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from assets_lib.mesh import FloatArray, IntArray, Mesh

_DIRECTIONS = 64
_REACH = 0.35
"""Surfaces farther away than this block no light [m]."""
_INSETS, _LIFT = (0.2, 0.55), 0.0015
"""A corner is judged at points so far towards the middle of its faces, and so far above them [m]."""
_FARTHEST = 0.02
"""These points are no farther from the corner [m]."""
_AT_ONCE = 512
"""Points whose rays are followed together."""
_BOUNCE, _LEAST = 0.65, 0.4
"""Share of the light that surfaces throw back into a hollow, and how much reaches its darkest corner."""
_FULL = (0.84, 0.97)
"""Shades between these rise to full light."""
_STEPS = 100
"""Shades are rounded to so many steps."""
_BURIED = 0.06
"""Points that see less of their half space lie under another part, and count little."""
_ALIKE = 0.98
"""Corners at one place have one shade where the cosine between their normals is larger."""


def _directions() -> FloatArray:
    """Return directions (d, 3) spread evenly over a sphere, along a spiral."""
    k = np.arange(_DIRECTIONS)
    z = 1.0 - (2.0 * k + 1.0) / _DIRECTIONS
    angle = k * np.pi * (3.0 - 5.0**0.5) + 0.1
    radius = np.sqrt(1.0 - z * z)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])


def shades_of(meshes: Sequence[Mesh], normals: Sequence[FloatArray], blockers: Sequence[Mesh]) -> list[FloatArray]:
    """Return for each corner of each face of the meshes of one link how much light reaches it, (m, 3) in 0..1.

    With v the share of directions that are free, light that is thrown back in the hollow makes it v / (1 - b (1 - v)). Corners
    at one place with one normal have one shade, so that none of the edges within a flat or round surface is seen.

    Args:
        meshes: Visual meshes in the frame of the link.
        normals: Of the corners of their faces, (m, 3, 3).
        blockers: What keeps light from others.
    """
    corners = np.concatenate([mesh.vertices[mesh.faces] for mesh in meshes])
    solid = np.concatenate([np.zeros((0, 3, 3)), *(mesh.vertices[mesh.faces] for mesh in blockers)])
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-30)
    group = _groups(corners.reshape(-1, 3), np.concatenate(normals).reshape(-1, 3))
    angles = _angles(corners).ravel()
    total, weight = np.zeros(group.max() + 1), np.zeros(group.max() + 1)
    inwards = corners.mean(axis=1, keepdims=True) - corners
    far = np.linalg.norm(inwards, axis=2, keepdims=True)
    for inset in _INSETS:
        points = corners + inwards * np.minimum(inset, _FARTHEST / np.maximum(far, 1e-9)) + _LIFT * flat[:, None]
        free = _free(points.reshape(-1, 3), np.repeat(flat, 3, axis=0), solid)
        own = angles * (0.001 + np.minimum(free / _BURIED, 1.0) ** 4)
        np.add.at(total, group, own * free / (1.0 - _BOUNCE * (1.0 - free)))
        np.add.at(weight, group, own)
    shades = _filled(total / weight, weight, group)
    shades = _LEAST + (1.0 - _LEAST) * shades
    low, high = _FULL
    shades += (1.0 - shades) * np.clip((shades - low) / (high - low), 0.0, 1.0)
    shades = np.round(shades * _STEPS)[group].reshape(-1, 3) / _STEPS
    return np.split(shades, np.cumsum([len(mesh.faces) for mesh in meshes])[:-1])


def _groups(places: FloatArray, normals: FloatArray) -> IntArray:
    """Return for corners (n, 3) with normals (n, 3) a number (n,) that those at one place and with one normal share."""
    found: dict[tuple[float, ...], list[tuple[FloatArray, int]]] = {}
    numbers = np.zeros(len(places), dtype=np.int64)
    count = 0
    for k, (place, normal) in enumerate(zip(np.round(places, 5) + 0.0, normals, strict=True)):
        there = found.setdefault(tuple(place), [])
        number = next((number for other, number in there if other @ normal > _ALIKE), None)
        if number is None:
            number, count = count, count + 1
            there.append((normal, number))
        numbers[k] = number
    return numbers


def _angles(corners: FloatArray) -> FloatArray:
    """Return the angles (m, 3) of triangles (m, 3, 3) [rad]."""
    ahead, back = (np.roll(corners, side, axis=1) - corners for side in (-1, 1))
    lengths = np.linalg.norm(ahead, axis=2) * np.linalg.norm(back, axis=2)
    cosine = np.einsum("mki,mki->mk", ahead, back) / np.maximum(lengths, 1e-30)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0))) + 1e-6


def _filled(shades: FloatArray, weight: FloatArray, group: IntArray) -> FloatArray:
    """Return the shades (g,) of groups, those of buried corners as at the other corners of their faces.

    Args:
        shades: Of the groups.
        weight: How much they count; buried ones little.
        group: Of the corners of the faces (3 m,).
    """
    buried = weight < 0.05
    faces = group.reshape(-1, 3)
    shades = shades.copy()
    for _ in range(3):
        total, count = np.zeros(len(shades)), np.zeros(len(shades))
        for k in range(3):
            for other in ((k + 1) % 3, (k + 2) % 3):
                known = ~buried[faces[:, other]]
                np.add.at(total, faces[known, k], shades[faces[known, other]])
                np.add.at(count, faces[known, k], 1.0)
        found = buried & (count > 0.0)
        shades[found] = total[found] / count[found]
        buried &= ~found
    return shades


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
    result = np.zeros(len(points), dtype=bool)
    if not len(a):
        return result
    sign = np.sign(along)[:, None]
    sides = [(np.cross(direction, second - first) * sign, first) for first, second in ((a, b), (b, c), (c, a))]
    distance = (-np.cross(b - a, c - a) / along[:, None], a)
    for begin in range(0, len(points), _AT_ONCE):
        own = points[begin : begin + _AT_ONCE]
        inside = _affine(own, *sides[0]) >= 0.0
        for side in sides[1:]:
            inside &= _affine(own, *side) >= 0.0
        far = _affine(own, *distance)
        inside &= far > 1e-5
        inside &= far < _REACH
        result[begin : begin + _AT_ONCE] = inside.any(axis=1)
    return result


def _affine(points: FloatArray, forms: FloatArray, origins: FloatArray) -> np.ndarray:
    """Return forms (t, 3) of points (n, 3) less those of origins (t, 3), (n, t)."""
    offsets = np.einsum("ij,ij->i", forms, origins)
    ours = np.column_stack([points, np.ones(len(points))]).astype(np.float32)
    return np.asarray(ours @ np.column_stack([forms, -offsets]).astype(np.float32).T)
