"""A coat hanger, a clothes rail for it, and a low stand in which it waits."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from assets_lib.mesh import Mesh, box, cylinder, icosphere, merge, rod
from assets_lib.prisms import bevelled_box
from assets_lib.urdf import Link, Model, Shape, Vec3, Visual, box_shape, cylinder_shape, mesh_shape, metal, patterned

RAIL_LENGTH, RAIL_RADIUS, RAIL_HEIGHT = 0.45, 0.0075, 0.3425
"""Length, radius and height of the axis of the rail [m]."""
FOOT = (0.03, 0.18, 0.018)
HOOK_INNER, WIRE = 0.0175, 0.003
"""Inner radius of the hook and radius of its wire [m]."""
HOOK_END, HOOK_PARTS = np.deg2rad(20.0), 8
"""Angle at which the hook ends [rad], and its straight parts; one of them lies level on the rail."""
APEX, SLOPE, HALF, THICK, DEEP = -0.068, 0.32, 0.10, 0.012, 0.016
"""Height of the shoulders under the middle of the hook, their slope [rad], half width, thickness and height [m]."""
BAR = (-0.118, 0.085, 0.004)
"""Height, half length and half thickness of the lower bar, which is flat below [m]."""
PEG, PEG_Y = (0.010, 0.020, 0.038), 0.07
"""Size of the two flat pegs on the shoulders, and how far they are from the middle [m]."""
PEG_TOP = -0.048
SLOT, PLATE = 0.0135, (0.006, 0.09, 0.055)
"""Width of the slot of the stand, and size of the plates on its sides [m]."""
BASE = (0.10, 0.15, 0.016)
STEEL, BRASS, WOOD, DARK = metal((0.74, 0.75, 0.78)), metal((0.70, 0.48, 0.16)), (0.36, 0.19, 0.10), (0.20, 0.20, 0.22)


def _hook_points() -> list[Vec3]:
    """Return the middle line of the hook, from the shoulders to its end; it is open towards +y."""
    radius = HOOK_INNER + WIRE
    angles = np.linspace(np.pi, HOOK_END, HOOK_PARTS + 1)
    arc = [(0.0, radius * float(np.cos(a)), radius * float(np.sin(a))) for a in angles]
    return [(0.0, 0.0, APEX), (0.0, 0.0, -0.055), (0.0, -radius, -0.034), *arc]


def _tube(points: list[Vec3], radius: float) -> Mesh:
    """Return a bent round bar with round joints."""
    rods = [rod(a, b, radius, 8) for a, b in pairwise(points)]
    return merge([*rods, *(icosphere(radius, 0).moved(p) for p in points)])


def _segment(a: Vec3, b: Vec3, radius: float) -> Shape:
    """Return a round bar in the yz plane."""
    along = np.subtract(b, a)
    middle = tuple(float(v) for v in np.add(a, b) / 2.0)
    roll = float(np.arctan2(-along[1], along[2]))
    return cylinder_shape(radius, float(np.linalg.norm(along)), (middle[0], middle[1], middle[2]), (roll, 0.0, 0.0))


def _hanger() -> Model:
    points = _hook_points()
    length = HALF / float(np.cos(SLOPE))
    z, half, radius = BAR
    end = APEX - half * float(np.tan(SLOPE))
    shoulders = tuple(
        box_shape((THICK, length, DEEP), (0.0, s * HALF / 2.0, APEX - HALF / 2.0 * float(np.tan(SLOPE))), (-s * SLOPE, 0.0, 0.0))
        for s in (-1.0, 1.0)
    )
    pegs = tuple(box_shape(PEG, (0.0, s * PEG_Y, PEG_TOP - PEG[2] / 2.0)) for s in (-1.0, 1.0))
    sides = tuple(((0.0, s * half, end), (0.0, s * half, z)) for s in (-1.0, 1.0))
    flat = box_shape((2.0 * radius, 2.0 * (half + radius), 2.0 * radius), (0.0, 0.0, z))
    rounded = merge(bevelled_box((PEG[0], PEG[1], PEG[2]), 0.002).moved((0.0, s * PEG_Y, PEG_TOP - PEG[2])) for s in (-1.0, 1.0))
    tips = [
        icosphere(DEEP / 2.0, 1).scaled((0.75, 1.0, 1.0)).moved((0.0, s * HALF, APEX - HALF * np.tan(SLOPE))) for s in (-1, 1)
    ]
    visuals = (
        Visual(mesh_shape("hook", _tube(points, WIRE)), BRASS),
        Visual(
            mesh_shape("shoulders", merge([*(shape.mesh() for shape in shoulders), *tips])), patterned(WOOD, "wood"), crease=0.5
        ),
        Visual(mesh_shape("pegs", rounded), patterned(WOOD, "wood"), crease=0.1),
        Visual(
            mesh_shape("bar", merge([*(_tube(list(side), radius) for side in sides), flat.mesh()])),
            patterned(WOOD, "wood"),
            crease=0.5,
        ),
        Visual(mesh_shape("collar", cylinder(0.006, 0.006, 14).moved((0.0, 0.0, APEX + DEEP / 2.0 + 0.002))), STEEL),
    )
    shapes = (
        *(_segment(a, b, WIRE) for a, b in pairwise(points)),
        *shoulders,
        *pegs,
        *(_segment(a, b, radius) for a, b in sides),
        flat,
    )
    notes = (
        f"flat in the yz plane, {THICK} thick; hook above, inner diameter {2 * HOOK_INNER}, open towards +y",
        f"hung on `clothes_rail` its origin is {HOOK_INNER - RAIL_RADIUS:.3f} below the axis of the rail",
        f"two flat pegs {PEG} at y = +-{PEG_Y}, upper side at z = {PEG_TOP}; lower bar at z = {z}",
    )
    link = Link("hanger", 0.08, visuals, shapes, friction=0.5, center=(0.0, 0.0, -0.085))
    return Model("hanger", "objects/hanger", "middle of the hook", (link,), notes=notes)


def _rail() -> Model:
    x, y, z = FOOT
    out = RAIL_LENGTH / 2.0
    posts = tuple(cylinder_shape(0.009, RAIL_HEIGHT - z, (s * out, 0.0, (RAIL_HEIGHT + z) / 2.0)) for s in (-1.0, 1.0))
    feet = tuple(box_shape(FOOT, (s * out, 0.0, z / 2.0)) for s in (-1.0, 1.0))
    rail = cylinder_shape(RAIL_RADIUS, RAIL_LENGTH, (0.0, 0.0, RAIL_HEIGHT), (0.0, float(np.pi / 2.0), 0.0))
    wood = merge(bevelled_box(FOOT, 0.003).moved((s * out, 0.0, 0.0)) for s in (-1.0, 1.0))
    knobs = [icosphere(0.012, 1).moved((s * out, 0.0, RAIL_HEIGHT)) for s in (-1.0, 1.0)]
    visuals = (
        Visual(mesh_shape("feet", wood), patterned((0.34, 0.22, 0.14), "wood"), crease=0.1),
        Visual(mesh_shape("posts", merge(shape.mesh() for shape in posts)), patterned(DARK, "brushed")),
        Visual(mesh_shape("rail", rod((-out, 0.0, RAIL_HEIGHT), (out, 0.0, RAIL_HEIGHT), RAIL_RADIUS, 16)), STEEL),
        Visual(mesh_shape("knobs", merge(knobs)), DARK),
    )
    notes = (f"rail along x, diameter {2 * RAIL_RADIUS}, {RAIL_LENGTH} long, axis at z = {RAIL_HEIGHT}, on a post at each end",)
    link = Link("clothes_rail", 3.0, visuals, (*posts, *feet, rail), friction=0.5)
    return Model("clothes_rail", "objects/clothes_rail", "bottom centre", (link,), notes=notes)


def _stand() -> Model:
    z = BASE[2]
    x = (SLOT + PLATE[0]) / 2.0
    plates = tuple(box_shape(PLATE, (s * x, 0.0, z + PLATE[2] / 2.0)) for s in (-1.0, 1.0))
    lids = merge([bevelled_box(BASE, 0.003), *(bevelled_box(PLATE, 0.002).moved((s * x, 0.0, z)) for s in (-1.0, 1.0))])
    edge = merge(box((BASE[0] + 0.001, 0.006, 0.004), (0.0, s * 0.06, 0.006)) for s in (-1.0, 1.0))
    visuals = (
        Visual(mesh_shape("stand", lids), (0.62, 0.68, 0.70), crease=0.1),
        Visual(mesh_shape("edge", edge), DARK, crease=0.1),
    )
    bottom = -(BAR[0] - BAR[2])
    notes = (f"slot along y, {SLOT} wide, in which `hanger` stands upright, its origin at z = {z + bottom:.3f}",)
    link = Link("hanger_stand", 0.6, visuals, (box_shape(BASE, (0.0, 0.0, z / 2.0)), *plates), friction=0.5)
    return Model("hanger_stand", "objects/hanger_stand", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_hanger(), _rail(), _stand())
