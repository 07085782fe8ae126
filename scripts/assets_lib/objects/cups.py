"""Open cups without handles, and a drop of liquid."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import icosphere, lathe
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
    Shape,
    Visual,
    box_shape,
    cylinder_shape,
    glass,
    glossy,
    mesh_shape,
    plastic,
    sphere_shape,
)

SEGMENTS = 12
DROP, SWELL = 0.005, 0.0025
"""Radius of a drop, and how much larger it is seen [m]."""
WATER = (0.20, 0.62, 1.0)
FLOOR, NESTING_FLOOR = 0.004, 0.026
"""Height of the floor of a cup; of one that nests, which rests on the floor of the one below, so that walls do not wedge [m]."""
THINNER = 0.0006
"""How much thinner the collision parts of a cup that nests are, whose inner faces then touch the seen wall from inside [m]."""
RIM = (0.93, 0.91, 0.86)


def leaning_walls(
    bottom: float, top: float, height: float, wall: float, floor: float, *, segments: int = SEGMENTS, nests: bool = False
) -> tuple[Shape, ...]:
    """Return boxes around a hollow cone, from the floor to the rim; their outer faces touch the cone from inside.

    Args:
        bottom: Outer radius at the foot [m].
        top: Outer radius at the rim [m].
        height: Height [m].
        wall: Thickness of the wall [m].
        floor: Thickness of the floor [m].
        segments: Number of boxes.
        nests: Make the boxes as wide as the foot allows, with gaps above, so that one such cone fits in another at any yaw.
    """
    lean = float(np.arctan2(top - bottom, height))
    fit = float(np.cos(np.pi / segments))
    middle = (floor + height) / 2.0
    radius = (bottom + (top - bottom) * middle / height) * fit - wall / 2.0
    size = (
        wall,
        2.0 * (bottom if nests else top) * float(np.sin(np.pi / segments)),
        (height - floor) / float(np.cos(lean)) - wall * float(np.sin(lean)),
    )
    shapes = []
    for i in range(segments):
        a = 2.0 * float(np.pi) * i / segments
        shapes.append(box_shape(size, (radius * float(np.cos(a)), radius * float(np.sin(a)), middle), (0.0, lean, a)))
    return tuple(shapes)


def _cup(name: str, bottom: float, top: float, height: float, wall: float, *, nests: bool = False) -> Model:
    floor = NESTING_FLOOR if nests else FLOOR
    lip = wall / 2.0
    outer = [(0.0, 0.0), (bottom - 0.002, 0.0), (bottom, 0.002), (top, height - lip), (top - lip, height)]
    inner = [(top - wall, height - lip), (bottom - wall + (top - bottom) * floor / height, floor), (0.0, floor)]
    body = Visual(mesh_shape("cup", lathe([*outer, *inner], 32)), glossy((0.85, 0.20, 0.18)), crease=0.9)
    foot = cylinder_shape(bottom * float(np.cos(np.pi / SEGMENTS)), floor, (0.0, 0.0, floor / 2.0))
    if nests:
        shapes = (foot, *leaning_walls(bottom, top, height, wall - THINNER, FLOOR, segments=16, nests=True))
    else:
        shapes = (foot, *leaning_walls(bottom, top, height, wall, floor))
    links = (
        Link("cup", 0.079, (body,), shapes, friction=0.8, center=(0.0, 0.0, 0.4 * height)),
        _lining(inner, top, height, wall),
    )
    holder = Joint("lining_holder", "fixed", "cup", "lining", (0.0, 0.0, 0.0))
    notes = (
        f"hollow, open above; outer radius {bottom} below and {top} at the rim (z = {height}), wall {wall}, floor at z = {floor}",
        "recolour the link `cup`; the link `lining` is its pale rim",
    )
    return Model(name, f"objects/{name}", "bottom centre", links, (holder,), notes)


def _lining(inner: list[tuple[float, float]], top: float, height: float, wall: float) -> Link:
    """Return the pale rim, which keeps its colour when a task colours the cup; a lining of the inside has a part of the mass."""
    t, (high, upper), (low, floor) = 0.0006, inner[0], inner[1]
    middle = 0.55 * height
    half = low + (high - low) * (middle - floor) / (upper - floor)
    inside = [(low, floor), (half, middle), (half - t, middle), (low - t, floor + t), (0.0, floor + t)]
    angles = np.linspace(-0.25 * np.pi, 1.75 * np.pi, 5)
    tube = wall / 2.0 + 0.0012
    rim = [(top - wall / 2.0 + tube * float(np.cos(a)), height - wall / 2.0 + tube * float(np.sin(a))) for a in angles]
    ring, spread = (mesh_shape("rim", lathe(rim, sides)) for sides in (32, 24))
    visuals = (Visual(ring, plastic(RIM), crease=1.2),)
    return Link("lining", 0.001, visuals, center=(0.0, 0.0, 0.4 * height), weighs=(mesh_shape("", lathe(inside, 14)), spread))


def _drop() -> Model:
    """Return a drop, seen a little larger than it is, so that drops in a cup look like one liquid."""
    seen = mesh_shape("drop", icosphere(DROP + SWELL, 1))
    link = Link(
        "drop", 0.001, (Visual(seen, glass(WATER), crease=3.0),), (sphere_shape(DROP),), friction=0.1, rolling=0.0002, spins=True
    )
    notes = (f"diameter {2 * DROP}; seen {SWELL} larger all round, less than the wall of a cup is thick",)
    return Model("drop", "objects/drop", "centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (
        _cup("cup", 0.029, 0.035, 0.09, 0.004),
        _cup("cup_slim", 0.028, 0.0325, 0.09, 0.004),
        _cup("cup_conical", 0.025, 0.0375, 0.09, 0.003, nests=True),
        _cup("cup_straight", 0.0325, 0.0325, 0.09, 0.004),
        _drop(),
    )
