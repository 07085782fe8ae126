"""A roll of toilet paper, a stand with an arm for it, and a block on which it lies."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, cylinder, icosphere, lathe, merge, rod
from assets_lib.prisms import bevelled_box
from assets_lib.urdf import Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape, metal, patterned, sphere_shape

OUTER, INNER, LENGTH, SEGMENTS = 0.035, 0.0175, 0.09, 12
"""Radius of the roll and of its hole, its length [m], and parts of its collision geometry."""
FOOT, POST, POST_RADIUS = (0.065, 0.014), 0.18, 0.007
"""Radius and height of the foot, height of the post, and its radius [m]."""
ARM_HEIGHT, ARM_RADIUS, ARM, TIP = 0.17, 0.010, 0.11, (0.114, 0.004)
"""Height of the arm's axis, its radius and length, and where its tip turns up: distance from the post and rise [m]."""
BLOCK, RIDGE = (0.12, 0.10, 0.05), (0.12, 0.010, 0.010)
RIDGE_INSIDE = 0.022
"""How far the inner edges of the ridges are from the middle of the block [m]."""
PAPER, CARD, STEEL = (0.95, 0.94, 0.92), (0.66, 0.52, 0.38), metal((0.72, 0.73, 0.76))
HALF_PI = 1.57079633


def _turned(profile: list[tuple[float, float]]) -> Mesh:
    """Turn an outline about the x axis."""
    return lathe(profile, 24).moved(rpy=(0.0, HALF_PI, 0.0))


def _roll() -> Model:
    h, bevel = LENGTH / 2.0, 0.002
    core = INNER + 0.0015
    paper = [(core, -h), (OUTER - bevel, -h), (OUTER, -h + bevel), (OUTER, h - bevel), (OUTER - bevel, h), (core, h), (core, -h)]
    card = [(INNER, -h - 0.0003), (core, -h - 0.0003), (core, h + 0.0003), (INNER, h + 0.0003), (INNER, -h - 0.0003)]
    layers = [
        _turned([(r, s * (h + 0.0002)), (r + 0.0005, s * (h + 0.0002))][:: -1 if s > 0 else 1])
        for r in (0.0215, 0.0245, 0.0275, 0.0305)
        for s in (-1.0, 1.0)
    ]
    sheet = box((LENGTH - 0.004, 0.0006, 0.03), (0.0, OUTER + 0.0003, -0.014))
    perforation = merge(box((0.005, 0.0004, 0.0008), (x, OUTER + 0.0007, -0.020)) for x in np.linspace(-0.036, 0.036, 9))
    visuals = (
        Visual(mesh_shape("paper", _turned(paper)), patterned(PAPER, "cloth")),
        Visual(mesh_shape("core", _turned(card)), patterned(CARD, "cardboard")),
        Visual(mesh_shape("layers", merge(layers)), (0.80, 0.79, 0.77)),
        Visual(mesh_shape("sheet", sheet), PAPER, crease=0.1),
        Visual(mesh_shape("perforation", perforation), (0.70, 0.70, 0.69), crease=0.1),
    )
    width = 2.0 * OUTER * float(np.tan(np.pi / SEGMENTS))
    middle = (OUTER + INNER) / 2.0
    shapes: list[Shape] = []
    for a in 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS:
        place = (0.0, middle * float(np.cos(a)), middle * float(np.sin(a)))
        shapes.append(box_shape((LENGTH, OUTER - INNER, width), place, (float(a), 0.0, 0.0)))
    notes = (f"its axis is x; diameter {2 * OUTER}, hole {2 * INNER}, length {LENGTH}; flat at y = +-{OUTER} and z = +-{OUTER}",)
    link = Link("toilet_roll", 0.1, visuals, tuple(shapes), friction=0.7, rolling=0.0005, center=(0.0, 0.0, 0.0))
    return Model("toilet_roll", "objects/toilet_roll", "centre", (link,), notes=notes)


def _stand() -> Model:
    radius, tall = FOOT
    out, rise = TIP
    straight = ARM - ARM_RADIUS
    visuals = (
        Visual(
            mesh_shape("foot", cylinder(radius, tall, 36, bevel=0.003).moved((0.0, 0.0, tall / 2.0))), metal((0.30, 0.31, 0.33))
        ),
        Visual(
            mesh_shape(
                "post",
                merge([rod((0.0, 0.0, tall), (0.0, 0.0, POST), POST_RADIUS, 16), icosphere(0.012, 1).moved((0.0, 0.0, POST))]),
            ),
            STEEL,
        ),
        Visual(
            mesh_shape(
                "arm",
                merge(
                    [
                        rod((0.0, 0.0, ARM_HEIGHT), (straight, 0.0, ARM_HEIGHT), ARM_RADIUS, 20),
                        rod((straight, 0.0, ARM_HEIGHT), (out, 0.0, ARM_HEIGHT + rise), ARM_RADIUS, 20),
                        icosphere(ARM_RADIUS, 1).moved((out, 0.0, ARM_HEIGHT + rise)),
                        icosphere(ARM_RADIUS, 1).moved((straight, 0.0, ARM_HEIGHT)),
                    ]
                ),
            ),
            STEEL,
        ),
        Visual(mesh_shape("collar", cylinder(0.013, 0.008, 24, bevel=0.002).moved((0.0, 0.0, tall + 0.004))), STEEL),
    )
    shapes = (
        cylinder_shape(radius, tall, (0.0, 0.0, tall / 2.0)),
        cylinder_shape(POST_RADIUS, POST - tall, (0.0, 0.0, (POST + tall) / 2.0)),
        cylinder_shape(ARM_RADIUS, straight, (straight / 2.0, 0.0, ARM_HEIGHT), (0.0, HALF_PI, 0.0)),
        sphere_shape(ARM_RADIUS, (out, 0.0, ARM_HEIGHT + rise)),
    )
    notes = (
        f"arm along +x, diameter {2 * ARM_RADIUS}, axis at z = {ARM_HEIGHT}, from x = 0 to x = {out + ARM_RADIUS:.3f}",
        f"its tip turns up by {rise}; a roll hung on it has its axis at z = {ARM_HEIGHT + ARM_RADIUS - INNER:.4f}",
    )
    link = Link("toilet_roll_stand", 2.0, visuals, shapes, friction=0.5)
    return Model("toilet_roll_stand", "objects/toilet_roll_stand", "bottom centre of the foot", (link,), notes=notes)


def _block() -> Model:
    x, y, z = BLOCK
    low = z - RIDGE[2]
    side = RIDGE_INSIDE + RIDGE[1] / 2.0
    ridges = tuple(box_shape(RIDGE, (0.0, s * side, low + RIDGE[2] / 2.0)) for s in (-1.0, 1.0))
    bevelled = merge(
        [bevelled_box((x, y, low), 0.003), *(bevelled_box(RIDGE, 0.002).moved((0.0, s * side, low)) for s in (-1.0, 1.0))]
    )
    visuals = (Visual(mesh_shape("block", bevelled), patterned((0.55, 0.44, 0.33), "wood"), crease=0.1),)
    axis = z + (OUTER - np.sin(np.pi / 6.0) * RIDGE_INSIDE) / np.cos(np.pi / 6.0)
    notes = (f"two ridges along x hold `toilet_roll` with its axis along x at z = {axis:.4f}",)
    link = Link("toilet_roll_block", 0.8, visuals, (box_shape((x, y, low), (0.0, 0.0, low / 2.0)), *ridges), friction=0.6)
    return Model("toilet_roll_block", "objects/toilet_roll_block", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_roll(), _stand(), _block())
