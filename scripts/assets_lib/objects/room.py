"""Table, floor, four walls and ceiling, all in world coordinates.

Every mesh is made of rectangles, because `sim.render.backdrop` draws them by formulas.
"""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, merge
from assets_lib.textures import ROOM_X, ROOM_Y, TABLE_X, TABLE_Y
from assets_lib.urdf import Link, Model, Visual, box_shape, mesh_shape
from rlbench_pin.spatial import TABLE_HEIGHT

ROOM_Z = 2.8
"""Height of the ceiling [m]."""


def quad(corners: list[tuple[float, float, float]]) -> Mesh:
    """Return a rectangle with texture, counter-clockwise from the lower left corner."""
    return Mesh(np.array(corners), np.array([(0, 1, 2), (0, 2, 3)]), np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float))


def _table() -> Model:
    (x0, x1), (y0, y1) = TABLE_X, TABLE_Y
    size, center = (x1 - x0, y1 - y0, 0.04), ((x0 + x1) / 2.0, (y0 + y1) / 2.0, TABLE_HEIGHT - 0.02)
    top = quad([(x0, y0, TABLE_HEIGHT), (x1, y0, TABLE_HEIGHT), (x1, y1, TABLE_HEIGHT), (x0, y1, TABLE_HEIGHT)])
    apron = _without_top(box((size[0], size[1], 0.0398), (center[0], center[1], TABLE_HEIGHT - 0.0201)))
    feet = [(x, y) for x in (x0 + 0.06, x1 - 0.06) for y in (y0 + 0.06, y1 - 0.06)]
    legs = merge(_without_top(box((0.06, 0.06, TABLE_HEIGHT - 0.04), (x, y, (TABLE_HEIGHT - 0.04) / 2.0))) for x, y in feet)
    visuals = (
        Visual(mesh_shape("table_top", top), (1.0, 1.0, 1.0), texture="wood"),
        Visual(mesh_shape("table_edge", apron), (0.60, 0.475, 0.35)),
        Visual(mesh_shape("table_legs", legs), (0.56, 0.45, 0.335)),
    )
    link = Link("table", 40.0, visuals, (box_shape(size, center),), friction=0.8)
    notes = (f"top at z = {TABLE_HEIGHT}, spans x {x0}..{x1}, y {y0}..{y1}; the legs are only seen",)
    return Model("table", "room", "world", (link,), notes=notes)


def _without_top(mesh: Mesh) -> Mesh:
    """Return a mesh without the triangles that lie at its greatest height, which the table top hides."""
    heights = mesh.vertices[mesh.faces][..., 2]
    return Mesh(mesh.vertices, mesh.faces[heights.min(axis=1) < mesh.vertices[:, 2].max()], mesh.uv)


def _floor() -> Model:
    (x0, x1), (y0, y1) = ROOM_X, ROOM_Y
    mesh = quad([(x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0)])
    shape = box_shape((x1 - x0, y1 - y0, 0.1), ((x0 + x1) / 2.0, (y0 + y1) / 2.0, -0.05))
    link = Link("floor", 100.0, (Visual(mesh_shape("floor", mesh), (1.0, 1.0, 1.0), texture="floor"),), (shape,), friction=0.8)
    return Model("floor", "room", "world", (link,), notes=("upper side at z = 0",))


def _wall(name: str, corners: list[tuple[float, float, float]], tint: float) -> Model:
    mesh = quad(corners)
    link = Link(name, 100.0, (Visual(mesh_shape(name, mesh), (tint, tint, tint), texture="wall"),))
    return Model(name, "room", "world", (link,), notes=("only seen",))


def _ceiling() -> Model:
    (x0, x1), (y0, y1), h = ROOM_X, ROOM_Y, ROOM_Z
    mesh = quad([(x0, y1, h), (x1, y1, h), (x1, y0, h), (x0, y0, h)])
    link = Link("ceiling", 100.0, (Visual(mesh_shape("ceiling", mesh), (1.0, 0.99, 0.96)),))
    return Model("ceiling", "room", "world", (link,), notes=("only seen",))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    (x0, x1), (y0, y1), h = ROOM_X, ROOM_Y, ROOM_Z
    return (
        _table(),
        _floor(),
        _wall("wall_front", [(x1, y1, 0.0), (x1, y0, 0.0), (x1, y0, h), (x1, y1, h)], 1.0),
        _wall("wall_back", [(x0, y0, 0.0), (x0, y1, 0.0), (x0, y1, h), (x0, y0, h)], 0.97),
        _wall("wall_left", [(x0, y1, 0.0), (x1, y1, 0.0), (x1, y1, h), (x0, y1, h)], 1.0),
        _wall("wall_right", [(x1, y0, 0.0), (x0, y0, 0.0), (x0, y0, h), (x1, y0, h)], 0.98),
        _ceiling(),
    )
