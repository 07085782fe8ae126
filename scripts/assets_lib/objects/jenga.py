"""Bricks of a tower game: pale ones and blue ones for crossed layers, and a red one to take."""

from __future__ import annotations

from itertools import product

import numpy as np

from assets_lib.mesh import Mesh, box, hull_of, merge
from assets_lib.urdf import Link, Model, Visual, box_shape, mesh_shape, patterned

LENGTH, WIDTH, HEIGHT = 0.0975, 0.0325, 0.0195
THIN = 0.0185
"""Height of a brick without load: the loose one, and those in the middle of a layer, whose outer two carry the next [m]."""
BEVEL = 0.001
MASS = 0.04
PALE, BLUE, RED = (0.96, 0.88, 0.70), (0.16, 0.42, 0.68), (0.86, 0.14, 0.10)


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
    sizes = ((0.021, height * 0.55), (0.010, height * 0.25))
    boxes = []
    for side in (-1, 1):
        for w, h in sizes:
            boxes += [box((t, w, 0.0012), (side * x, 0.0, z)) for z in (-h / 2.0, h / 2.0)]
            boxes += [box((t, 0.0012, h), (side * x, y, 0.0)) for y in (-w / 2.0, w / 2.0)]
    return merge(boxes)


def _model(name: str, height: float, color: tuple[float, float, float]) -> Model:
    red, green, blue = color
    visuals = (
        Visual(mesh_shape(name, _brick(height)), patterned(color, "wood")),
        Visual(mesh_shape(f"{name}_rings", _end_rings(height)), (0.65 * red, 0.65 * green, 0.65 * blue)),
    )
    link = Link("brick", MASS, visuals, (box_shape((LENGTH, WIDTH, height)),), friction=0.4, anchored=True)
    notes = (f"{LENGTH} x {WIDTH} x {height} along x, y, z",)
    return Model(name, f"objects/{name}", "centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (
        _model("jenga_brick", HEIGHT, PALE),
        _model("jenga_inner_brick", THIN, PALE),
        _model("jenga_blue_brick", HEIGHT, BLUE),
        _model("jenga_blue_inner_brick", THIN, BLUE),
        _model("jenga_loose_brick", THIN, RED),
    )
