"""Boxes with bevelled edges, and hollow boxes with openings in the front."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from assets_lib.mesh import Mesh, hull_of, merge

BEVEL = 0.0025
"""How much is taken off edges [m]."""

Vec3 = tuple[float, float, float]
Span = tuple[float, float]


def bevelled_box(size: Sequence[float], center: Sequence[float] = (0.0, 0.0, 0.0), bevel: float = BEVEL) -> Mesh:
    """Return a box of `size` x, y, z without sharp edges."""
    half = np.array(size) / 2.0
    cut = min(bevel, 0.45 * float(half.min()))
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = [signs * (half - cut * (np.arange(3) != axis)) for axis in range(3)]
    return hull_of(np.concatenate(corners)).moved(center)


def bevelled(boxes: Sequence[tuple[Vec3, Vec3]], bevel: float = BEVEL) -> Mesh:
    """Return boxes (size, centre) without sharp edges as one mesh."""
    return merge(bevelled_box(size, center, bevel) for size, center in boxes)


def rectangle_at(x: float, y: Span, z: Span) -> Mesh:
    """Return a rectangle across x that is seen from -x."""
    corners = np.array([(x, y[1], z[0]), (x, y[0], z[0]), (x, y[0], z[1]), (x, y[1], z[1])])
    return Mesh(corners, np.array([(0, 1, 2), (0, 2, 3)]))


def cabinet(x: Span, y: Span, z: Span, opening: Span, openings: Sequence[Span], depth: float) -> Mesh:
    """Return a hollow box that is open to -x, its outer edges bevelled.

    Args:
        x: What it spans [m].
        y: What it spans [m].
        z: What it spans [m].
        opening: What all openings span along y [m].
        openings: What each spans along z, from below [m].
        depth: How deep they go [m].
    """
    size, center = zip(*((high - low, (high + low) / 2.0) for low, high in (x, y, z)))
    skin = bevelled_box(size, center)
    corners = skin.vertices[skin.faces]
    skin = Mesh(skin.vertices, skin.faces[corners[..., 0].max(axis=1) > x[0] + 1e-9])
    inner_y, inner_z = ((low + BEVEL, high - BEVEL) for low, high in (y, z))
    edges = [inner_z[0], *(edge for span in openings for edge in span), inner_z[1]]
    front = [rectangle_at(x[0], (inner_y[0], opening[0]), inner_z), rectangle_at(x[0], (opening[1], inner_y[1]), inner_z)]
    front += [rectangle_at(x[0], opening, span) for span in zip(edges[0::2], edges[1::2], strict=True)]
    return merge([skin, *front, *(_hollow((x[0], x[0] + depth), opening, span) for span in openings)])


def _hollow(x: Span, y: Span, z: Span) -> Mesh:
    """Return the inner sides of an opening: back, left, right, floor and ceiling, seen from inside."""
    corners = np.array([(a, b, c) for a in x for b in y for c in z])
    quads = ((4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    faces = []
    middle = corners.mean(axis=0)
    for a, b, c, d in quads:
        normal = np.cross(corners[b] - corners[a], corners[c] - corners[a])
        inwards = normal @ (middle - corners[a]) > 0.0
        faces += [(a, b, c), (a, c, d)] if inwards else [(a, c, b), (a, d, c)]
    return Mesh(corners, np.array(faces))
