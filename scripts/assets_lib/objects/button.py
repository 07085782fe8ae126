"""A push button on a pedestal. Its cap stands above a guard ring by less than the press that counts.

What is flat and wider than the ring cannot press it; fingertips can.
"""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, cylinder, lathe, merge
from assets_lib.objects.saucepan import wall_boxes
from assets_lib.urdf import Joint, Link, Model, Visual, box_shape, cylinder_shape, glossy, mesh_shape, plastic

SIDE, HEIGHT, FLOOR = 0.08, 0.03, 0.018
"""Pedestal width, its height and the height of the floor of its well [m]."""
WELL = 0.054
"""Width of the square well in which the collar moves [m]."""
TRAVEL = 0.006
GUARD_RADIUS, GUARD_TOP, GUARD_WALL, GUARD_SEGMENTS = 0.031, 0.0395, 0.0045, 12
"""Outer radius of the guard ring, height of its rim, thickness [m], and boxes it is made of."""


def _pedestal() -> tuple[Mesh, tuple[tuple[tuple[float, float, float], tuple[float, float, float]], ...]]:
    """Return the visual mesh and the boxes (size, centre) of the pedestal."""
    rim, z = (SIDE - WELL) / 2.0, (HEIGHT + FLOOR) / 2.0
    shift = (SIDE - rim) / 2.0
    boxes = (
        ((SIDE, SIDE, FLOOR), (0.0, 0.0, FLOOR / 2.0)),
        ((rim, SIDE, HEIGHT - FLOOR), (shift, 0.0, z)),
        ((rim, SIDE, HEIGHT - FLOOR), (-shift, 0.0, z)),
        ((WELL, rim, HEIGHT - FLOOR), (0.0, shift, z)),
        ((WELL, rim, HEIGHT - FLOOR), (0.0, -shift, z)),
    )
    inner, outer = GUARD_RADIUS - GUARD_WALL, GUARD_RADIUS
    ring = lathe([(inner, HEIGHT), (outer + 0.002, HEIGHT), (outer, GUARD_TOP), (inner, GUARD_TOP), (inner, HEIGHT)], 32)
    flange = lathe([(0.0395, HEIGHT), (0.0389, HEIGHT + 0.0008), (outer, HEIGHT + 0.0008)], 32)  # over the corners of the well
    half, soft = SIDE / 2.0, 0.002
    outline = [(0.0, 0.0), (half, 0.0), (half, HEIGHT - soft), (half - soft, HEIGHT), (WELL / 2.0, HEIGHT), (WELL / 2.0, FLOOR)]
    block = lathe([(r * 2.0**0.5, z) for r, z in (*outline, (0.0, FLOOR))], 4, phase=np.pi / 4.0)
    return merge([block, ring, flange]), boxes


def _cap() -> Mesh:
    """Return the seen cap and collar; the origin is the centre of the cap's top."""
    cap = cylinder(0.0175, 0.012, 32, bevel=0.002).moved((0.0, 0.0, -0.006))
    collar = lathe([(0.0, -0.016), (0.025, -0.016), (0.025, -0.011), (0.0235, -0.0095), (0.0175, -0.0095), (0.0175, -0.012)], 32)
    return merge([cap, collar])


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    mesh, boxes = _pedestal()
    guard = wall_boxes(GUARD_RADIUS, GUARD_TOP, GUARD_WALL, HEIGHT, GUARD_SEGMENTS)
    shapes = (*(box_shape(s, c) for s, c in boxes), *guard)
    base = Link("base", 0.5, (Visual(mesh_shape("pedestal", mesh), plastic((0.5, 0.0, 0.0))),), shapes)
    parts = (cylinder_shape(0.0175, 0.012, (0.0, 0.0, -0.006)), cylinder_shape(0.025, 0.0065, (0.0, 0.0, -0.01275)))
    cap = Link("cap", 0.02, (Visual(mesh_shape("cap", _cap()), glossy((1.0, 0.0, 0.0))),), parts)
    joint = Joint("cap_joint", "prismatic", "base", "cap", (0.0, 0.0, 0.042), (0.0, 0.0, -1.0), 0.0, TRAVEL, damping=1.0)
    notes = (
        "link `cap` has its origin at the centre of the cap's top, 0.042 m above the table; pressing increases cap_joint",
        f"guard ring on link `base`: inner radius {GUARD_RADIUS - GUARD_WALL:.4f}, rim at z = {GUARD_TOP}; closed fingers fit in",
        "cap diameter 0.035, collar diameter 0.05, both on link `cap`; recolour the links `base` and `cap`",
    )
    return (Model("button", "objects/button", "bottom centre", (base, cap), (joint,), notes),)
