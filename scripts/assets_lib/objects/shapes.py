"""Five toy shapes in two heights, and a sorter box with a hole for each in its lid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, box, cylinder, merge
from assets_lib.prisms import Rectangle, bevelled_box, grown, hull_prism, pieces_around, prism, rectangle, regular_polygon
from assets_lib.urdf import Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape, plastic

LOW, TALL = 0.025, 0.05
"""Heights of the pieces to lift and of those to sort [m]."""
CUBE, DIAMETER, PRISM = 0.035, 0.035, 0.04
STAR = (0.0235, 0.0125)
"""Radii of tips and notches [m]."""
MOON = (0.0225, 0.018, 0.016)
"""Radius of the disc, radius of what is cut off it, and how far its middle is from that of the disc [m]."""
MOON_SHIFT = 0.0044
CLEARANCE = {"cube": 0.0025, "cylinder": 0.0025, "prism": 0.0025, "star": 0.0035, "moon": 0.0025}
"""Gap between a shape and its hole [m]; a finger comes to rest more or less deep in a notch of the star."""
SKIN = 0.001
"""Skin that PyBullet puts around collision meshes [m]."""
BLUE = plastic((0.08, 0.20, 0.90))
SIDE, HEIGHT, WALL, LID, FLOOR = 0.16, 0.10, 0.006, 0.008, 0.004
WOOD = (0.87, 0.72, 0.50)


@dataclass(frozen=True)
class Hole:
    """Where a shape goes through the lid."""

    shape: str
    cell: Rectangle
    color: tuple[float, float, float]

    @property
    def center(self) -> tuple[float, float]:
        """Middle of the hole [m]."""
        return (self.cell[0] + self.cell[2]) / 2.0, (self.cell[1] + self.cell[3]) / 2.0


HOLES = (
    Hole("cube", (-0.08, 0.0, -0.028, 0.08), (0.90, 0.30, 0.25)),
    Hole("cylinder", (-0.028, 0.0, 0.022, 0.08), (0.97, 0.83, 0.25)),
    Hole("prism", (0.022, 0.0, 0.08, 0.08), (0.35, 0.75, 0.40)),
    Hole("star", (-0.08, -0.08, 0.0, 0.0), (0.95, 0.60, 0.20)),
    Hole("moon", (0.0, -0.08, 0.08, 0.0), (0.65, 0.45, 0.80)),
)


def _half_moon(growth: float) -> FloatArray:
    """Return the outline of the upper half of the crescent, its disc grown and what is cut off it shrunk."""
    radius, cut, distance = MOON[0] + growth, MOON[1] - growth, MOON[2]
    tip_x = (distance**2 + radius**2 - cut**2) / (2.0 * distance)
    tip_y = float(np.sqrt(radius**2 - tip_x**2))
    inner = np.linspace(np.pi, np.arctan2(tip_y, tip_x - distance), 7)
    outer = np.linspace(np.arctan2(tip_y, tip_x), np.pi, 10)[1:]
    points = [(distance + cut * np.cos(a), cut * np.sin(a)) for a in inner]
    points += [(radius * np.cos(a), radius * np.sin(a)) for a in outer]
    return np.array(points) + (MOON_SHIFT, 0.0)


def _outline(name: str, growth: float = 0.0) -> FloatArray:
    """Return the outline of a shape other than the moon."""
    if name == "cube":
        return rectangle(CUBE + 2.0 * growth, CUBE + 2.0 * growth)
    if name == "cylinder":
        return regular_polygon((DIAMETER / 2.0 + growth) / float(np.cos(np.pi / 24.0)), 24)
    if name == "prism":
        return grown(regular_polygon(PRISM / np.sqrt(3.0), 3), growth)
    tips, notches = regular_polygon(STAR[0], 5), regular_polygon(STAR[1], 5, np.pi / 5.0)
    return grown(np.stack([tips, notches], axis=1).reshape(-1, 2), growth)


def _middle_of(outline: FloatArray) -> tuple[float, float]:
    """Return the point from which every edge of an outline is seen best."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    grid = np.stack(np.meshgrid(*np.linspace(low, high, 80).T), axis=-1).reshape(-1, 1, 2)
    edges = np.roll(outline, -1, axis=0) - outline
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    to = grid - outline
    inside = (edges[:, 0] * to[..., 1] - edges[:, 1] * to[..., 0]).min(axis=1)
    best = grid[int(np.argmax(inside)), 0]
    assert inside.max() > 0.0, "no point sees the whole outline"
    return float(best[0]), float(best[1])


def _moon_mesh(low: float, high: float) -> Mesh:
    upper = _half_moon(0.0)
    lower = (upper * (1.0, -1.0))[::-1]
    return merge(prism(half, low, high, _middle_of(half)) for half in (upper, lower))


def _moon_pieces(low: float, high: float) -> list[Mesh]:
    """Return slices of the crescent along its arc, without the skin."""
    upper = _half_moon(-SKIN)
    inner, outer = upper[:7], upper[6:][::-1]
    pieces = []
    for i, j in ((0, 3), (3, 6)):
        a, b = round(i * 9 / 6), round(j * 9 / 6)
        strip = np.concatenate([inner[[i, j]], outer[a : b + 1]])
        pieces += [hull_prism(strip * (1.0, sign), low, high) for sign in (1.0, -1.0)]
    return pieces


def _star_pieces(low: float, high: float) -> list[Mesh]:
    outline = _outline("star", -SKIN)
    kites = [np.array([(0.0, 0.0), outline[2 * i - 1], outline[2 * i], outline[2 * i + 1]]) for i in range(5)]
    return [hull_prism(kite, low, high) for kite in kites]


def _solid(name: str, height: float) -> tuple[Mesh, tuple[Shape, ...]]:
    """Return what is seen of a shape, and what it touches with."""
    low, high = -height / 2.0, height / 2.0
    if name == "cube":
        return bevelled_box((CUBE, CUBE, height), 0.002).moved((0.0, 0.0, low)), (box_shape((CUBE, CUBE, height)),)
    if name == "cylinder":
        return cylinder(DIAMETER / 2.0, height, 40, bevel=0.002), (cylinder_shape(DIAMETER / 2.0, height),)
    inner = (low + SKIN, high - SKIN)
    if name == "moon":
        pieces = _moon_pieces(*inner)
        return _moon_mesh(low, high), tuple(mesh_shape(f"moon_part{i}", piece) for i, piece in enumerate(pieces))
    outline = _outline(name)
    seen = prism(outline, low, high, (0.0, 0.0), bevel=0.002)
    pieces = _star_pieces(*inner) if name == "star" else [hull_prism(_outline(name, -SKIN), *inner)]
    return seen, tuple(mesh_shape(f"{name}_part{i}", piece) for i, piece in enumerate(pieces))


def _shape(name: str, height: float, prefix: str) -> Model:
    seen, parts = _solid(name, height)
    link = Link(f"{prefix}_{name}", 0.04, (Visual(mesh_shape(f"{prefix}_{name}", seen), BLUE, crease=0.5),), parts, friction=0.9)
    notes = [
        f"{height} high; rests with its origin at {height / 2.0} m; matches the hole `{name}` of `shape_sorter` at equal yaw"
    ]
    if name == "moon":
        thick = MOON_SHIFT - MOON[0], MOON_SHIFT + MOON[2] - MOON[1]
        notes.append(f"hollow towards +x; thickest from x = {thick[0]:.4f} to {thick[1]:.4f}: grasp it across x at x = -0.006")
    return Model(f"{prefix}_{name}", f"objects/{prefix}_{name}", "centre", (link,), notes=tuple(notes))


def _hole_outlines(hole: Hole, growth: float) -> list[tuple[FloatArray, Rectangle]]:
    """Return the outlines of a hole around the middle of its cell, each with the part of the cell around it."""
    half_x, half_y = (hole.cell[2] - hole.cell[0]) / 2.0, (hole.cell[3] - hole.cell[1]) / 2.0
    if hole.shape != "moon":
        return [(_outline(hole.shape, growth), (-half_x, -half_y, half_x, half_y))]
    upper = _half_moon(growth)
    lower = (upper * (1.0, -1.0))[::-1]
    return [(upper, (-half_x, 0.0, half_x, half_y)), (lower, (-half_x, -half_y, half_x, 0.0))]


def _around(hole: Hole, growth: float, low: float, high: float) -> list[Mesh]:
    """Return the lid around a hole as convex pieces."""
    places = [(outline, cell, _middle_of(outline)) for outline, cell in _hole_outlines(hole, growth)]
    pieces = [piece for outline, cell, middle in places for piece in pieces_around(outline, cell, middle)]
    return [hull_prism(piece + hole.center, low, high) for piece in pieces]


def _box_walls() -> tuple[Shape, ...]:
    height = HEIGHT - LID - FLOOR
    z, middle = FLOOR + height / 2.0, (SIDE - WALL) / 2.0
    sides = [box_shape((WALL, SIDE, height), (s * middle, 0.0, z)) for s in (-1.0, 1.0)]
    sides += [box_shape((SIDE - 2.0 * WALL, WALL, height), (0.0, s * middle, z)) for s in (-1.0, 1.0)]
    return (box_shape((SIDE, SIDE, FLOOR), (0.0, 0.0, FLOOR / 2.0)), *sides)


def _sorter() -> Model:
    walls = _box_walls()
    seen = merge(box(wall.size, wall.xyz) for wall in walls)
    visuals = [Visual(mesh_shape("sorter_walls", seen), WOOD)]
    lids: list[Shape] = []
    for hole in HOLES:
        seen = merge(_around(hole, CLEARANCE[hole.shape], HEIGHT - LID, HEIGHT))
        visuals.append(Visual(mesh_shape(f"lid_{hole.shape}", seen), hole.color, crease=0.3))
        solid = _around(hole, CLEARANCE[hole.shape] + SKIN, HEIGHT - LID + SKIN, HEIGHT - SKIN)
        lids += [mesh_shape(f"lid_{hole.shape}_part{i}", piece) for i, piece in enumerate(solid)]
    link = Link("shape_sorter", 0.8, tuple(visuals), (*walls, *lids))
    holes = ", ".join(f"{hole.shape} ({hole.center[0]:.3f}, {hole.center[1]:.3f})" for hole in HOLES)
    notes = (
        f"hollow; lid {LID} thick, its upper side at z = {HEIGHT}, floor at z = {FLOOR}; middles of the holes: {holes}",
        f"{min(CLEARANCE.values())} or more free all round a shape in its hole",
    )
    return Model("shape_sorter", "objects/shape_sorter", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    names = [hole.shape for hole in HOLES]
    low = [_shape(name, CUBE if name == "cube" else LOW, "shape") for name in names]
    return (*low, *(_shape(name, TALL, "tall") for name in names), _sorter())
