"""Things to clean with, and dirt: sponge, stain, broom, its holder, dustpan, crumb."""

from __future__ import annotations

import numpy as np

from assets_lib.cabinets import bevelled_box
from assets_lib.mesh import Mesh, box, cylinder, hull_of, lathe, merge, rod
from assets_lib.prisms import mark, regular_polygon
from assets_lib.urdf import Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape, patterned

SPONGE = (0.09, 0.055, 0.035)
STAIN = (0.012, 0.001)
"""Diameter and height of a stain [m]."""
CRUMB = 0.012
BROWN = (0.30, 0.14, 0.02)
HEAD = (0.02, 0.12, 0.05)
HANDLE_RADIUS, HANDLE = 0.0125, 0.18
SLOT, WALL, HOLDER_TALL = 0.0235, 0.006, 0.034
"""Width of the slot in the holder, its walls, its height [m]."""
PAN, PAN_FLOOR, PAN_WALL, LIP = (0.14, 0.20, 0.03), 0.003, 0.005, 0.02
PANS = {"dustpan": PAN[2], "dustpan_tall": 0.09}
"""Model of a dustpan -> height of its walls [m]."""


def _sponge() -> Model:
    x, y, z = SPONGE
    scourer = 0.009
    soft = bevelled_box((x, y, z - scourer), (0.0, 0.0, -scourer / 2.0), 0.003)
    scouring = bevelled_box((x, y, scourer), (0.0, 0.0, (z - scourer) / 2.0), 0.002)
    visuals = (
        Visual(mesh_shape("soft", soft), (1.0, 0.86, 0.36), crease=0.9),
        Visual(mesh_shape("pores", _pores()), (0.72, 0.52, 0.10)),
        Visual(mesh_shape("scourer", scouring), patterned((0.16, 0.45, 0.20), "cloth"), crease=0.9),
    )
    link = Link("sponge", 0.04, visuals, (box_shape(SPONGE),), friction=0.8)
    notes = (f"long side along x; rests with its origin at {z / 2.0} m; grasp across y ({y} wide)",)
    return Model("sponge", "objects/sponge", "centre", (link,), notes=notes)


def _pores() -> Mesh:
    """Return the pores in the sides of the sponge as flat marks."""
    x, y, z = SPONGE
    low, high = -z / 2.0 + 0.006, z / 2.0 - 0.016
    rng = np.random.default_rng(5)
    pores = []
    for depth, width, yaw, count in ((x, y, 0.0, 7), (y, x, np.pi / 2.0, 12), (x, y, np.pi, 7), (y, x, -np.pi / 2.0, 12)):
        for n in range(count):
            along = width * ((n + rng.uniform(0.25, 0.75)) / count - 0.5) * 0.86
            radii = rng.uniform(0.7, 1.0, 8) * rng.uniform(0.0010, 0.0024)
            pore = regular_polygon(1.0, 8) * radii[:, None] * (1.3, 1.0) + (along, rng.uniform(low, high))
            pores.append(mark(pore, depth / 2.0 + 0.0002, "x").moved(rpy=(0.0, 0.0, yaw)))
    return merge(pores)


def _stain() -> Model:
    """Return a round stain, a flat cone of few triangles, since fifty are drawn."""
    across, tall = STAIN

    def blot(sides: int) -> Shape:
        return mesh_shape("blot", lathe([(across / 2.0, -tall / 2.0), (0.0, tall / 2.0)], sides))

    stain = Link("stain", 0.001, (Visual(blot(16), BROWN),), weighs=(blot(8),))
    notes = (f"visual only, {across} across and {tall} high",)
    return Model("stain", "objects/stain", "centre", (stain,), notes=notes)


def _crumb() -> Model:
    side = (CRUMB, CRUMB, CRUMB)
    link = Link("crumb", 0.01, (Visual(box_shape(side), (0.20, 0.10, 0.05)),), (box_shape(side),), friction=0.6)
    return Model("crumb", "objects/crumb", "centre", (link,), notes=(f"rests with its origin at {CRUMB / 2.0} m",))


def _bristles() -> Mesh:
    """Return tufts that spread towards the floor."""
    x, y, z = HEAD
    top, tall = z - 0.018, z - 0.018
    tufts = []
    for i in range(12):
        v = -y / 2.0 + y * (i + 0.5) / 12
        low = np.array([[a * x / 2.0, v + b * y / 25.0, 0.0] for a in (-1.0, 1.0) for b in (-1.0, 1.0)])
        high = np.array([[a * x / 2.6, v * 0.96 + b * y / 28.0, tall] for a in (-1.0, 1.0) for b in (-1.0, 1.0)])
        tufts.append(hull_of(np.round(np.concatenate([low, high]), 5)))
    assert top > 0.0
    return merge(tufts)


def _broom() -> Model:
    x, y, z = HEAD
    middle = z + HANDLE / 2.0
    handle = merge([cylinder(HANDLE_RADIUS, HANDLE, 14, bevel=0.003).moved((0.0, 0.0, middle))])
    bands = [cylinder(HANDLE_RADIUS + 0.001, 0.006, 14).moved((0.0, 0.0, z + h)) for h in (0.006, 0.10)]
    visuals = (
        Visual(mesh_shape("bristles", _bristles()), (0.85, 0.68, 0.32), crease=0.1),
        Visual(mesh_shape("block", box((x, y, 0.018), (0.0, 0.0, z - 0.009))), (0.75, 0.14, 0.12), crease=0.1),
        Visual(mesh_shape("handle", handle), (0.20, 0.36, 0.68)),
        Visual(mesh_shape("bands", merge(bands)), (0.92, 0.92, 0.90)),
    )
    shapes = (box_shape(HEAD, (0.0, 0.0, z / 2.0)), cylinder_shape(HANDLE_RADIUS, HANDLE, (0.0, 0.0, middle)))
    link = Link("broom", 0.15, visuals, shapes, friction=0.8, center=(0.0, 0.0, 0.06))
    notes = (
        f"head long along y, {y} x {x} x {z}; upright handle, diameter {2 * HANDLE_RADIUS}, from z = {z} to {z + HANDLE}",
        "stands upright in `broom_holder` at the same place, 0.005 higher; leaves it upwards or towards -y",
    )
    return Model("broom", "objects/broom", "bottom centre", (link,), notes=notes)


def _holder() -> Model:
    """Return a trough for the head of the broom, open above and towards -y."""
    depth = 0.11
    sides = tuple(box_shape((WALL, depth, HOLDER_TALL), (s * (SLOT + WALL) / 2.0, 0.005, HOLDER_TALL / 2.0)) for s in (-1.0, 1.0))
    floor = box_shape((SLOT + 0.001, depth, 0.005), (0.0, 0.005, 0.0025))
    back = box_shape((SLOT + 2 * WALL, WALL, HOLDER_TALL), (0.0, 0.0635, HOLDER_TALL / 2.0))
    foot = box_shape((0.09, depth, 0.004), (0.0, 0.005, 0.002))
    shapes: tuple[Shape, ...] = (*sides, floor, back, foot)
    mesh = merge(shape.mesh() for shape in shapes)
    link = Link("broom_holder", 0.8, (Visual(mesh_shape("trough", mesh), (0.35, 0.37, 0.40), crease=0.1),), shapes)
    notes = (f"slot along y, {SLOT} wide, floor at z = 0.005, walls {HOLDER_TALL} high, open above and towards -y",)
    return Model("broom_holder", "objects/broom_holder", "bottom centre", (link,), notes=notes)


def _lip() -> Mesh:
    """Return the bevelled front edge of the dustpan, with its sharp edge on the table."""
    x, y, _ = PAN
    points = [[x / 2.0 - LIP, v, h] for v in (-y / 2.0, y / 2.0) for h in (0.0, PAN_FLOOR)]
    points += [[x / 2.0, v, h] for v in (-y / 2.0, y / 2.0) for h in (0.0, 0.0004)]
    return hull_of(np.array(points))


def _ramp() -> Mesh:
    """Return the collision shape of the bevelled edge; its slope continues below the table, so that no edge stops a crumb."""
    x, y, _ = PAN
    ends = ((x / 2.0 - LIP, PAN_FLOOR), (x / 2.0 - LIP, -PAN_FLOOR), (x / 2.0 + LIP, -PAN_FLOOR))
    return hull_of(np.array([[u, v, h] for v in (-y / 2.0, y / 2.0) for u, h in ends]))


def _dustpan(name: str, z: float) -> Model:
    """Return a dustpan with walls of height z [m]."""
    x, y, _ = PAN
    flat = x - LIP
    floor = box_shape((flat, y, PAN_FLOOR), (-LIP / 2.0, 0.0, PAN_FLOOR / 2.0))
    sides = tuple(box_shape((flat, PAN_WALL, z), (-LIP / 2.0, s * (y - PAN_WALL) / 2.0, z / 2.0)) for s in (-1.0, 1.0))
    back = box_shape((PAN_WALL, y, z), (-x / 2.0 + PAN_WALL / 2.0, 0.0, z / 2.0))
    grip = box_shape((0.09, 0.024, 0.012), (-x / 2.0 - 0.045, 0.0, 0.022))
    shapes = (floor, *sides, back)
    body = merge([*(shape.mesh() for shape in shapes), _lip()])
    handle = merge([grip.mesh(), rod((-x / 2.0 - 0.09, 0.0, 0.016), (-x / 2.0 - 0.09, 0.0, 0.028), 0.012, 12)])
    visuals = (
        Visual(mesh_shape("pan", body), (0.16, 0.60, 0.62), crease=0.1),
        Visual(mesh_shape("grip", handle), (0.10, 0.36, 0.38)),
    )
    link = Link(name, 0.3, visuals, (*shapes, mesh_shape("lip", _ramp()), grip), friction=0.5)
    notes = (
        f"open towards +x; floor {PAN_FLOOR} thick, bevelled over the last {LIP} m",
        f"inside y +-{y / 2.0 - PAN_WALL}, walls {z} high",
        "handle along -x",
    )
    return Model(name, f"objects/{name}", "bottom centre of the pan", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_sponge(), _stain(), _broom(), _holder(), *(_dustpan(*pan) for pan in PANS.items()), _crumb())
