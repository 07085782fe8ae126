"""Where a new thing is put: on the table, at a place that is free."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from rlbench_pin.builder.view.snapping import body_triangles, resting_on
from rlbench_pin.scene import BodySpec, SceneSpec
from rlbench_pin.spatial import IDENTITY, TABLE_HEIGHT
from rlbench_pin.viewer.places import Places, places_at_rest

_STEP = 0.05
_GAP = 0.01


def standing_pose(spec: SceneSpec, body: BodySpec) -> tuple[float, float, float]:
    """Return where a new body stands on the table, in the frame of the root: near its origin, beside what is there."""
    alone = SceneSpec(format=2, body=(body,), file=spec.file)
    points = body_triangles(alone, body, places_at_rest(alone, {body.name: IDENTITY.copy()}).links).reshape(-1, 3)
    places = places_at_rest(spec)
    root = places.things["root"]
    height = float(resting_on(IDENTITY, points, TABLE_HEIGHT)[2]) - float(root[2])
    taken = list(_patches(spec, places))
    low, high = (points.min(axis=0)[:2], points.max(axis=0)[:2]) if len(points) else (np.zeros(2), np.zeros(2))
    for x, y in _spiral():
        here = np.array([x, y])
        if not any((low + here - _GAP < top).all() and (high + here + _GAP > bottom).all() for bottom, top in taken):
            return x, y, round(height, 4)
    return 0.0, 0.0, round(height, 4)


def _patches(spec: SceneSpec, places: Places) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield lowest and highest x, y of bodies, from the root."""
    root = places.things["root"][:2]
    for body in spec.body:
        points = body_triangles(spec, body, places.links).reshape(-1, 3)
        if len(points):
            yield points.min(axis=0)[:2] - root, points.max(axis=0)[:2] - root


def _spiral() -> Iterator[tuple[float, float]]:
    """Yield places on a grid, the nearest first."""
    cells = sorted(product(range(-4, 5), range(-6, 7)), key=lambda cell: (cell[0] ** 2 + cell[1] ** 2, cell[1] < 0, cell))
    yield from ((round(x * _STEP, 4), round(y * _STEP, 4)) for x, y in cells)
