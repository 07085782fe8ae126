"""Wooden bricks of a tower game."""

from __future__ import annotations

from itertools import product

import numpy as np

from assets_lib.mesh import Mesh, box, hull_of, merge
from assets_lib.urdf import Link, Model, Visual, box_shape, mesh_shape

LENGTH, WIDTH, HEIGHT = 0.075, 0.025, 0.015
THIN = 0.014
"""Height of a brick without load: the loose one, and those in the middle of a layer, whose outer two carry the next [m]."""
BEVEL = 0.001


def _brick(height: float) -> Mesh:
    """Return a brick with bevelled edges."""
    half = np.array([LENGTH, WIDTH, height]) / 2.0
    points = [
        np.array(signs) * (half - BEVEL * np.array([axis != k for k in range(3)]))
        for signs in product((-1.0, 1.0), repeat=3)
        for axis in range(3)
    ]
    return hull_of(np.array(points))


def _end_rings(height: float) -> Mesh:
    """Return the rings that the wood shows at both ends."""
    x, t = LENGTH / 2.0, 0.0006
    sizes = ((0.016, height * 0.55), (0.008, height * 0.25))
    boxes = []
    for side in (-1, 1):
        for w, h in sizes:
            boxes += [box((t, w, 0.0012), (side * x, 0.0, z)) for z in (-h / 2.0, h / 2.0)]
            boxes += [box((t, 0.0012, h), (side * x, y, 0.0)) for y in (-w / 2.0, w / 2.0)]
    return merge(boxes)


def _model(name: str, height: float, color: tuple[float, float, float]) -> Model:
    visuals = (
        Visual(mesh_shape(name, _brick(height)), color),
        Visual(mesh_shape(f"{name}_rings", _end_rings(height)), (0.55, 0.38, 0.22)),
    )
    link = Link("brick", 0.02, visuals, (box_shape((LENGTH, WIDTH, height)),), friction=0.4, anchored=True)
    notes = (f"{LENGTH} x {WIDTH} x {height} along x, y, z",)
    return Model(name, f"objects/{name}", "centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    plain, dark = (0.86, 0.70, 0.48), (0.78, 0.58, 0.36)
    return (
        _model("jenga_brick", HEIGHT, plain),
        _model("jenga_inner_brick", THIN, plain),
        _model("jenga_loose_brick", THIN, dark),
    )
