"""A rack for wine bottles, its lower row full and its upper row empty, and a corked bottle that fits in."""

from __future__ import annotations

import numpy as np

from assets_lib.cabinets import bevelled
from assets_lib.mesh import Mesh, lathe, merge
from assets_lib.prisms import hull_prism
from assets_lib.urdf import (
    Link,
    Model,
    Paint,
    Shape,
    Vec3,
    Visual,
    box_shape,
    cylinder_shape,
    glass,
    mesh_shape,
    patterned,
    plastic,
)

RADIUS, BELLY, SHOULDER, NECK_RADIUS, HEIGHT = 0.0325, 0.162, 0.18, 0.014, 0.26
"""Of the belly, height where it ends, height of the neck's foot, radius of the neck, height of the rim [m]."""
LABEL, FOIL = (0.04, 0.115), 0.215
"""Lowest and highest z of the label, and where the foil of the neck begins [m]."""
WIDTH, DEPTH, TOP, PANEL = 0.26, 0.20, 0.18, 0.004
"""Of the rack; its panels are thin, so that three bottles lie between them [m]."""
PITCH, BOARD_X, BOARD = 0.084, 0.054, 0.014
"""From notch to notch, and where the notched boards stand and how thick they are [m]."""
LOWER, UPPER = 0.066, 0.188
"""Heights of the axes of bottles in both rows [m]."""
RIDGE, GROOVE, FOOT = 0.008, 0.042, 0.062
"""How far below the axis a board has its ridges, the bottoms of its notches, and its lower side [m]."""
SLOPE = RADIUS * float(np.sqrt(2.0))
"""How far below the axis both flanks of a notch, at 45 degrees, would meet [m]."""
STORED = -0.105
"""Where the bottoms of the bottles in the lower row are, along x [m]."""
GREEN, DARK, PAPER, BURGUNDY = (
    glass((0.09, 0.20, 0.12)),
    glass((0.12, 0.10, 0.06)),
    (0.92, 0.89, 0.80),
    (0.42, 0.07, 0.12),
)
WOOD, GOLD = patterned(plastic((0.58, 0.38, 0.22)), "wood"), plastic((0.72, 0.58, 0.28))


def _band(radius: float, low: float, high: float) -> Mesh:
    """Return a closed ring around a bottle."""
    return lathe([(RADIUS - 0.001, low), (radius, low), (radius, high), (RADIUS - 0.001, high)], 20)


def _glass() -> Mesh:
    belly = [(0.0, 0.0), (RADIUS - 0.004, 0.0), (RADIUS - 0.001, 0.0012), (RADIUS, 0.005), (RADIUS, BELLY)]
    neck = [
        (0.030, 0.167),
        (0.024, 0.173),
        (0.0165, SHOULDER),
        (NECK_RADIUS - 0.001, 0.19),
        (NECK_RADIUS - 0.001, HEIGHT - 0.002),
    ]
    return lathe([*belly, *neck, (0.0, HEIGHT - 0.002)], 20)


def _foil() -> Mesh:
    """Return the foil of the neck, with the ring below the rim."""
    ring = [(NECK_RADIUS - 0.0006, 0.243), (NECK_RADIUS, 0.244), (NECK_RADIUS, 0.252), (NECK_RADIUS - 0.0006, 0.253)]
    top = [(NECK_RADIUS - 0.0006, HEIGHT - 0.0015), (NECK_RADIUS - 0.002, HEIGHT), (0.0, HEIGHT)]
    return lathe([(0.0, FOIL), (NECK_RADIUS - 0.0006, FOIL), *ring, *top], 16)


def _parts() -> dict[str, Mesh]:
    """Return the parts of a bottle that stands on z = 0, by name."""
    low, high = LABEL
    stripes = merge([_band(RADIUS + 0.0006, z, z + 0.004) for z in (low + 0.004, high - 0.008)])
    return {
        "glass": _glass(),
        "label": _band(RADIUS + 0.0004, low, high),
        "stripes": stripes,
        "crest": _band(RADIUS + 0.0006, 0.070, 0.088),
        "foil": _foil(),
    }


PAINTS: dict[str, Vec3 | Paint] = {"glass": GREEN, "label": PAPER, "stripes": GOLD, "crest": BURGUNDY, "foil": plastic(BURGUNDY)}


def _stored_parts() -> dict[str, Mesh]:
    """Return the parts of a bottle in the lower row, with few triangles."""
    low, high = LABEL
    foot = [(0.0, 0.0), (RADIUS - 0.002, 0.0), (RADIUS, 0.004), (RADIUS, BELLY)]
    return {
        "glass": lathe([*foot, (0.0165, SHOULDER), (NECK_RADIUS - 0.001, FOIL)], 14),
        "label": lathe([(RADIUS + 0.0006, low), (RADIUS + 0.0006, high)], 14),
        "foil": lathe([(NECK_RADIUS, FOIL), (NECK_RADIUS, HEIGHT), (0.0, HEIGHT)], 10),
    }


def _bottle() -> Model:
    visuals = tuple(Visual(mesh_shape(name, mesh), PAINTS[name]) for name, mesh in _parts().items())
    shapes = (
        cylinder_shape(RADIUS, BELLY, (0.0, 0.0, BELLY / 2.0)),
        cylinder_shape(0.023, SHOULDER - BELLY, (0.0, 0.0, (BELLY + SHOULDER) / 2.0)),
        cylinder_shape(NECK_RADIUS, HEIGHT - SHOULDER, (0.0, 0.0, (HEIGHT + SHOULDER) / 2.0)),
    )
    notes = (
        f"belly of diameter {2 * RADIUS} up to z = {BELLY}, neck of diameter {2 * NECK_RADIUS} up to {HEIGHT}",
        "corked and full, in one piece; its centre of mass is at z = 0.095",
    )
    link = Link("bottle", 0.5, visuals, shapes, friction=0.9, rolling=0.0005, center=(0.0, 0.0, 0.095))
    return Model("corked_bottle", "objects/corked_bottle", "bottom centre", (link,), notes=notes)


def _board_pieces(axis: float) -> list[Mesh]:
    """Return the convex pieces of a board across x with three notches: a bar, and the teeth on it."""
    half, floor, ridge = WIDTH / 2.0 - PANEL, axis - GROOVE, axis - RIDGE
    low, high = SLOPE - GROOVE, SLOPE - RIDGE
    pieces = [[(-half, axis - FOOT), (half, axis - FOOT), (half, floor), (-half, floor)]]
    for k in range(4):
        left, right = (k - 2) * PITCH, (k - 1) * PITCH
        foot = (-half if k == 0 else left + low, half if k == 3 else right - low)
        top = (-half if k == 0 else left + high, half if k == 3 else right - high)
        pieces.append([(foot[0], floor), (foot[1], floor), (top[1], ridge), (top[0], ridge)])
    return [hull_prism(np.array(points), -BOARD / 2.0, BOARD / 2.0) for points in pieces]


def _boards() -> list[tuple[Mesh, tuple[float, float, float]]]:
    """Return the pieces of all four boards: y of the outline along y, its height along z, its thickness along x."""
    upright = (np.pi / 2.0, 0.0, np.pi / 2.0)
    return [
        (piece.moved(rpy=upright), (x, 0.0, 0.0))
        for axis in (LOWER, UPPER)
        for x in (-BOARD_X, BOARD_X)
        for piece in _board_pieces(axis)
    ]


def _rack() -> Model:
    side = (WIDTH - PANEL) / 2.0
    panels = [((DEPTH, PANEL, TOP), (0.0, s * side, TOP / 2.0)) for s in (-1.0, 1.0)]
    rails = [((0.018, WIDTH - 2.0 * PANEL, 0.012), (x, 0.0, 0.006)) for x in (-0.085, 0.085)]
    boards = _boards()
    laid: dict[str, Vec3 | Paint] = {
        "glass": DARK,
        "label": PAPER,
        "foil": plastic((0.10, 0.16, 0.22)),
    }
    places = [(STORED, k * PITCH, LOWER) for k in (-1, 0, 1)]
    stored = [
        Visual(mesh_shape(name, merge(mesh.moved(place, (0.0, np.pi / 2.0, 0.0)) for place in places)), laid[name])
        for name, mesh in _stored_parts().items()
    ]
    wood = merge([bevelled([*panels, *rails]), *(mesh.moved(at) for mesh, at in boards)])
    shapes: list[Shape] = [box_shape(size, center) for size, center in (*panels, *rails)]
    shapes += [mesh_shape(f"piece_{i}", mesh, at) for i, (mesh, at) in enumerate(boards)]
    lying = (0.0, np.pi / 2.0, 0.0)
    for x, y, z in places:
        shapes.append(cylinder_shape(RADIUS, BELLY, (x + BELLY / 2.0, y, z), lying))
        shapes.append(cylinder_shape(NECK_RADIUS, HEIGHT - BELLY, (x + (BELLY + HEIGHT) / 2.0, y, z), lying))
    visuals = (Visual(mesh_shape("wood", wood), WOOD), *stored)
    notes = (
        f"front towards -x; three notches in each row, {PITCH} apart along y; boards at x = +-{BOARD_X}, {BOARD} thick",
        f"a bottle in the upper row has its axis at z = {UPPER}; that row is free, and bottles fill the lower one",
    )
    return Model(
        "wine_rack", "objects/wine_rack", "bottom centre", (Link("rack", 4.0, visuals, tuple(shapes), friction=0.6),), notes=notes
    )


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return _bottle(), _rack()
