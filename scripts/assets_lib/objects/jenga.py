"""Wooden bricks of a tower game: pale ones and dark ones for crossed layers, and a red one to take."""

from __future__ import annotations

from itertools import product

import numpy as np

from assets_lib.mesh import Mesh, box, hull_of, merge
from assets_lib.prisms import mark, rectangle
from assets_lib.urdf import Link, Model, Visual, box_shape, mesh_shape, patterned

LENGTH, WIDTH, HEIGHT = 0.0975, 0.0325, 0.0195
THIN = 0.0185
"""Height of a brick without load: the loose one, and those in the middle of a layer, whose outer two carry the next [m]."""
BEVEL = 0.001
MASS = 0.04
PALE, WALNUT, RED = (0.96, 0.84, 0.60), (0.46, 0.26, 0.13), (0.80, 0.13, 0.10)
GRAIN = 0.0005
"""How far the grain stands out, for the eye only [m]."""


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


def _grain(height: float) -> Mesh:
    """Return the lines of the grain along the four long sides."""
    lines = []
    for k, (start, end, at) in enumerate(((-0.46, 0.10, -0.30), (-0.20, 0.46, 0.02), (-0.44, 0.30, 0.33))):
        length, x = LENGTH * (end - start), LENGTH * (start + end) / 2.0
        for side in (-1.0, 1.0):
            turned = (0.0 if side > 0.0 else np.pi, 0.0, 0.0)
            lines.append(mark(rectangle(length, 0.0016) + (x, at * WIDTH), height / 2.0 + GRAIN, "z").moved(rpy=turned))
            if k != 1:
                line = mark(rectangle(length, 0.0014) + (x, at * height), WIDTH / 2.0 + GRAIN, "x")
                lines.append(line.moved(rpy=(0.0, 0.0, side * np.pi / 2.0)))
    return merge(lines)


def _model(name: str, height: float, color: tuple[float, float, float]) -> Model:
    red, green, blue = color
    visuals = (
        Visual(mesh_shape(name, _brick(height)), patterned(color, "wood")),
        Visual(mesh_shape(f"{name}_grain", merge([_end_rings(height), _grain(height)])), (0.66 * red, 0.62 * green, 0.58 * blue)),
    )
    link = Link("brick", MASS, visuals, (box_shape((LENGTH, WIDTH, height)),), friction=0.4, anchored=True)
    notes = (f"{LENGTH} x {WIDTH} x {height} along x, y, z",)
    return Model(name, f"objects/{name}", "centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (
        _model("jenga_brick", HEIGHT, PALE),
        _model("jenga_inner_brick", THIN, PALE),
        _model("jenga_dark_brick", HEIGHT, WALNUT),
        _model("jenga_dark_inner_brick", THIN, WALNUT),
        _model("jenga_loose_brick", THIN, RED),
    )
