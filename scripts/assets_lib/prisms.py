"""Upright prisms over outlines in the xy plane, and plates with holes cut into convex pieces. Lengths in [m]."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.spatial import ConvexHull

from assets_lib.mesh import FloatArray, Mesh, hull_of

Point = tuple[float, float]
Rectangle = tuple[float, float, float, float]
"""Lowest x, lowest y, highest x, highest y."""


def regular_polygon(radius: float, sides: int, phase: float = 0.0) -> FloatArray:
    """Return the corners (n, 2) of a regular polygon around the origin, counter-clockwise."""
    angles = phase + 2.0 * np.pi * np.arange(sides) / sides
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def rectangle(x: float, y: float) -> FloatArray:
    """Return the corners (4, 2) of a rectangle of edge lengths `x` and `y` around the origin."""
    return 0.5 * np.array([(-x, -y), (x, -y), (x, y), (-x, y)])


def prism(outline: FloatArray, low: float, high: float, center: Point | None = None, bevel: float = 0.0) -> Mesh:
    """Return a closed prism.

    Args:
        outline: Corners (n, 2), counter-clockwise, all of them seen from `center`.
        low: z of the lower side.
        high: z of the upper side.
        center: Middle of the two fans; None takes the mean of the corners.
        bevel: Width of the slanted edge around the upper side.
    """
    middle = outline.mean(axis=0) if center is None else np.array(center)
    inner = middle + (outline - middle) * (1.0 - bevel / np.linalg.norm(outline - middle, axis=1, keepdims=True))
    levels = [(outline, low), (outline, high - bevel), (inner, high)] if bevel > 0.0 else [(outline, low), (outline, high)]
    count = len(outline)
    vertices = [np.column_stack([points, np.full(count, z)]) for points, z in levels]
    vertices += [np.array([[*middle, low]]), np.array([[*middle, high]])]
    bottom, top = count * len(levels), count * len(levels) + 1
    faces = []
    for i in range(count):
        j = (i + 1) % count
        faces += [(bottom, j, i), (top, top - 1 - count + i, top - 1 - count + j)]
        for level in range(len(levels) - 1):
            a, b = level * count, (level + 1) * count
            faces += [(a + i, a + j, b + j), (a + i, b + j, b + i)]
    return Mesh(np.concatenate(vertices), np.array(faces))


def bevelled_box(size: Sequence[float], bevel: float) -> Mesh:
    """Return a box that stands on z = 0, with a bevelled upper edge."""
    x, y, z = size
    levels = ((x, y, 0.0), (x, y, z - bevel), (x - 2.0 * bevel, y - 2.0 * bevel, z))
    corners = [(sx * a / 2.0, sy * b / 2.0, h) for a, b, h in levels for sx in (-1, 1) for sy in (-1, 1)]
    return hull_of(np.round(np.array(corners), 6))


def hull_prism(points: FloatArray, low: float, high: float) -> Mesh:
    """Return the convex prism over points (n, 2)."""
    return hull_of(np.round(np.concatenate([np.column_stack([points, np.full(len(points), z)]) for z in (low, high)]), 6))


def mark(points: Sequence[Point] | FloatArray, height: float, axis: Literal["x", "z"]) -> Mesh:
    """Return a flat convex mark on a surface, seen from one side alone.

    Args:
        points: y, z of its corners on a wall, x, y on a top, in any order.
        height: Where it lies along `axis` [m]; above 0.
        axis: What it faces.
    """
    corners = np.asarray(points, dtype=float)
    corners = np.round(corners[ConvexHull(corners).vertices], 6)
    across = np.full(len(corners), height)
    columns = (across, *corners.T) if axis == "x" else (*corners.T, across)
    return Mesh(np.column_stack(columns), np.array([(0, i, i + 1) for i in range(1, len(corners) - 1)]))


def grown(outline: FloatArray, distance: float) -> FloatArray:
    """Move every edge of an outline outwards by `distance`, or inwards when it is negative."""
    edges = np.roll(outline, -1, axis=0) - outline
    normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1, keepdims=True)
    before = np.roll(normals, 1, axis=0)
    turn = 1.0 + np.einsum("ij,ij->i", before, normals)
    return outline + distance * (before + normals) / turn[:, None]


def pieces_around(outline: FloatArray, cell: Rectangle, center: Point) -> list[FloatArray]:
    """Cut a rectangle with a hole into convex pieces: one per edge of the hole, between it and the border.

    Args:
        outline: Corners (n, 2) of the hole, counter-clockwise, all of them seen from `center`.
        cell: The rectangle around it.
        center: A point inside the hole.
    """
    middle = np.array(center)
    corners = np.array([(cell[0], cell[1]), (cell[2], cell[1]), (cell[2], cell[3]), (cell[0], cell[3])])
    pieces = []
    for a, b in pairwise([*outline, outline[0]]):
        far_a, far_b = _on_border(a, middle, cell), _on_border(b, middle, cell)
        between = [c for c in corners if _is_between(c - middle, a - middle, b - middle)]
        points = np.array([a, b, far_b, *between, far_a])
        if np.ptp(points, axis=0).min() > 1e-6 and _area(a, b, far_b, far_a, between) > 1e-8:
            pieces.append(points)
    return pieces


def _area(a: FloatArray, b: FloatArray, far_b: FloatArray, far_a: FloatArray, between: list[FloatArray]) -> float:
    points = np.array([a, far_a, *between, far_b, b])
    x, y = points[:, 0], points[:, 1]
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def _is_between(direction: FloatArray, first: FloatArray, second: FloatArray) -> bool:
    return _cross(first, direction) > 1e-12 and _cross(direction, second) > 1e-12


def _cross(a: FloatArray, b: FloatArray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _on_border(point: FloatArray, middle: FloatArray, cell: Rectangle) -> FloatArray:
    """Return where the ray from `middle` through `point` leaves the rectangle."""
    direction = point - middle
    low, high = np.array(cell[:2]), np.array(cell[2:])
    with np.errstate(divide="ignore"):
        scales = np.where(
            direction > 0.0, (high - middle) / direction, np.where(direction < 0.0, (low - middle) / direction, np.inf)
        )
    return middle + direction * max(1.0, float(scales.min()))
