"""Open trays of two sizes."""

from __future__ import annotations

from assets_lib.mesh import Mesh, box, merge
from assets_lib.urdf import Link, Model, Shape, Vec3, Visual, box_shape, mesh_shape

WALL, FLOOR = 0.005, 0.005
BIG, SMALL = (0.34, 0.28, 0.045), (0.18, 0.16, 0.045)
"""Low, because the palm is 0.04 m above the finger tips."""
RIM = 0.004
"""How far the rim stands out [m]."""


def _walls(size: Vec3) -> tuple[Shape, ...]:
    """Return floor and four walls."""
    x, y, z = size
    tall, middle = z - FLOOR, (z + FLOOR) / 2.0
    long_sides = tuple(box_shape((x, WALL, tall), (0.0, s * (y - WALL) / 2.0, middle)) for s in (-1.0, 1.0))
    short_sides = tuple(box_shape((WALL, y - 2 * WALL, tall), (s * (x - WALL) / 2.0, 0.0, middle)) for s in (-1.0, 1.0))
    return (box_shape((x, y, FLOOR), (0.0, 0.0, FLOOR / 2.0)), *long_sides, *short_sides)


def _rim(size: Vec3) -> Mesh:
    """Return the thicker edge around the opening; it covers the upper edges of the walls."""
    x, y, z = size
    bar, over = 0.008, 0.0006
    wide, up = WALL + RIM + over, z + over - bar / 2.0
    long_sides = [box((x + 2 * RIM, wide, bar), (0.0, s * (y + RIM - WALL - over) / 2.0, up)) for s in (-1.0, 1.0)]
    short_sides = [box((wide, y - 2 * WALL, bar), (s * (x + RIM - WALL - over) / 2.0, 0.0, up)) for s in (-1.0, 1.0)]
    return merge([*long_sides, *short_sides])


def _tray(name: str, size: Vec3, color: Vec3, rim_color: Vec3) -> Model:
    walls = _walls(size)
    visuals = (
        Visual(mesh_shape("walls", merge(shape.mesh() for shape in walls)), color, crease=0.1),
        Visual(mesh_shape("rim", _rim(size)), rim_color, crease=0.1),
    )
    x, y, z = size
    notes = (
        "hollow, open above, long side along x",
        f"inside {x - 2 * WALL:.2f} x {y - 2 * WALL:.2f}, floor at z = {FLOOR}, rim at z = {z}",
    )
    return Model(name, f"objects/{name}", "bottom centre", (Link(name, 0.6, visuals, walls),), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (
        _tray("tray_big", BIG, (0.84, 0.87, 0.90), (0.30, 0.36, 0.43)),
        _tray("tray_small", SMALL, (0.9, 0.1, 0.1), (0.9, 0.1, 0.1)),
    )
