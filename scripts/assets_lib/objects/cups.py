"""Open cups without handles, and a drop of liquid."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import icosphere, lathe
from assets_lib.urdf import Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape, plastic, sphere_shape

SEGMENTS = 12
DROP, SWELL = 0.005, 0.0025
"""Radius of a drop, and how much larger it is seen [m]."""
WATER = (0.20, 0.62, 1.0)


def leaning_walls(bottom: float, top: float, height: float, wall: float, floor: float) -> tuple[Shape, ...]:
    """Return boxes around a hollow cone, from the floor to the rim; their outer faces touch the cone from inside.

    Args:
        bottom: Outer radius at the foot [m].
        top: Outer radius at the rim [m].
        height: Height [m].
        wall: Thickness of the wall [m].
        floor: Thickness of the floor [m].
    """
    lean = float(np.arctan2(top - bottom, height))
    fit = float(np.cos(np.pi / SEGMENTS))
    middle = (floor + height) / 2.0
    radius = (bottom + (top - bottom) * middle / height) * fit - wall / 2.0
    size = (
        wall,
        2.0 * top * float(np.sin(np.pi / SEGMENTS)),
        (height - floor) / float(np.cos(lean)) - wall * float(np.sin(lean)),
    )
    shapes = []
    for i in range(SEGMENTS):
        a = 2.0 * float(np.pi) * i / SEGMENTS
        shapes.append(box_shape(size, (radius * float(np.cos(a)), radius * float(np.sin(a)), middle), (0.0, lean, a)))
    return tuple(shapes)


def _cup(name: str, bottom: float, top: float, height: float, wall: float) -> Model:
    floor = 0.004
    lip = wall / 2.0
    outer = [(0.0, 0.0), (bottom - 0.002, 0.0), (bottom, 0.002), (top, height - lip), (top - lip, height)]
    inner = [(top - wall, height - lip), (bottom - wall + (top - bottom) * floor / height, floor), (0.0, floor)]
    body = Visual(mesh_shape("cup", lathe([*outer, *inner], 28)), plastic((0.85, 0.20, 0.18)))
    foot = cylinder_shape(bottom * float(np.cos(np.pi / SEGMENTS)), floor, (0.0, 0.0, floor / 2.0))
    shapes = (foot, *leaning_walls(bottom, top, height, wall, floor))
    link = Link(name, 0.08, (body,), shapes, friction=0.8, center=(0.0, 0.0, 0.4 * height))
    notes = (
        f"hollow, open above; outer radius {bottom} below and {top} at the rim (z = {height}), wall {wall}, floor at z = {floor}",
        "one visual: recolour the whole body",
    )
    return Model(name, f"objects/{name}", "bottom centre", (link,), notes=notes)


def _drop() -> Model:
    """Return a drop, seen a little larger than it is, so that drops in a cup look like one liquid."""
    seen = mesh_shape("drop", icosphere(DROP + SWELL, 1))
    link = Link(
        "drop", 0.001, (Visual(seen, WATER, crease=3.0),), (sphere_shape(DROP),), friction=0.1, rolling=0.0002, spins=True
    )
    notes = (f"diameter {2 * DROP}; seen {SWELL} larger all round, less than the wall of a cup is thick",)
    return Model("drop", "objects/drop", "centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (
        _cup("cup", 0.029, 0.035, 0.09, 0.004),
        _cup("cup_slim", 0.028, 0.0325, 0.09, 0.004),
        _cup("cup_conical", 0.025, 0.0375, 0.09, 0.003),
        _cup("cup_straight", 0.0325, 0.0325, 0.09, 0.004),
        _drop(),
    )
