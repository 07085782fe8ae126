"""A screwdriver, a stand for it, and a block with a slotted screw that turns."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, hull_of, lathe, merge
from assets_lib.prisms import bevelled_box, hull_prism
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape

BLOCK = (0.08, 0.08, 0.06)
HEAD_RADIUS, HEAD_FLOOR, HEAD_TOP, GAP = 0.01, 0.005, 0.011, 0.001
"""Radius of the head, bottom of its slot and its top above the block, space below it [m]."""
SLOT = 0.004
HANDLE_RADIUS, HANDLE, SHAFT_RADIUS, SHAFT = 0.015, 0.08, 0.004, 0.08
BLADE = (0.0025, 0.016, 0.008)
STAND, STAND_HEIGHT, STAND_HOLE = 0.05, 0.092, 0.02
TIP = -HANDLE / 2.0 - SHAFT - BLADE[2]
"""z of the end of the blade [m]."""
WOOD, STEEL, RED, YELLOW = (0.76, 0.56, 0.34), (0.72, 0.73, 0.76), (0.82, 0.12, 0.10), (0.95, 0.80, 0.15)


def _half_head(side: float) -> Mesh:
    """Return one half of the head, beside the slot."""
    angles = np.linspace(-1.0, 1.0, 9) * np.arccos(SLOT / 2.0 / HEAD_RADIUS)
    points = HEAD_RADIUS * np.column_stack([np.cos(angles), np.sin(angles)]) * (side, 1.0)
    return hull_prism(points, HEAD_FLOOR, HEAD_TOP)


def _head_shapes() -> tuple[Shape, ...]:
    """Return the head as boxes, which leave the slot along y its full width."""
    height, z = HEAD_TOP - HEAD_FLOOR, (HEAD_TOP + HEAD_FLOOR) / 2.0
    halves = []
    for side in (-1.0, 1.0):
        for low, high, half_y in ((SLOT / 2.0, 0.006, 0.008), (0.006, 0.009, 0.0045)):
            halves.append(box_shape((high - low, 2.0 * half_y, height), (side * (low + high) / 2.0, 0.0, z)))
    return (cylinder_shape(HEAD_RADIUS, HEAD_FLOOR - GAP, (0.0, 0.0, (HEAD_FLOOR + GAP) / 2.0)), *halves)


def _block() -> Model:
    plate = lathe([(0.0, 0.0), (HEAD_RADIUS, 0.0), (HEAD_RADIUS, HEAD_FLOOR), (0.0, HEAD_FLOOR)], 20)
    base = Link(
        "screw_block",
        1.5,
        (Visual(mesh_shape("block", bevelled_box(BLOCK, 0.003)), WOOD),),
        (box_shape(BLOCK, (0.0, 0.0, BLOCK[2] / 2.0)),),
    )
    head = Visual(mesh_shape("head", merge([plate, _half_head(1.0), _half_head(-1.0)])), STEEL)
    screw = Link("screw_link", 0.03, (head,), _head_shapes(), friction=0.4)
    joint = Joint(
        "screw", "revolute", "screw_block", "screw_link", (0.0, 0.0, BLOCK[2]), (0.0, 0.0, -1.0), -3.2, 3.2, damping=0.002
    )
    notes = (
        f"joint `screw` grows when it is tightened; its slot lies along y at 0, {SLOT} wide, from z = {HEAD_FLOOR} to {HEAD_TOP} "
        "in `screw_link`",
        "the screw turns but does not go down; give it friction",
    )
    return Model("screw_block", "objects/screw_block", "bottom centre", (base, screw), (joint,), notes)


def _handle() -> tuple[Mesh, Mesh]:
    """Return the grip and its coloured cap."""
    h, r = HANDLE / 2.0, HANDLE_RADIUS
    grip = [(0.0, -h), (0.007, -h), (r - 0.003, -h + 0.012), (r, -h + 0.024), (r, h - 0.016), (0.0, h - 0.016)]
    cap = [(0.0, h - 0.016), (r, h - 0.016), (r, h - 0.006), (r - 0.006, h), (0.0, h)]
    return lathe(grip, 12), lathe(cap, 12)


def _steel() -> Mesh:
    """Return shaft and blade."""
    low, high = -HANDLE / 2.0 - SHAFT, -HANDLE / 2.0
    shaft = lathe([(0.0, low), (SHAFT_RADIUS, low), (SHAFT_RADIUS, high), (0.0, high)], 12)
    x, y, _ = (s / 2.0 for s in BLADE)
    corners = [
        (sx * px, sy * py, z)
        for px, py, z in ((x, y, TIP), (0.003, y, low), (0.003, 0.004, low + 0.006))
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
    return merge([shaft, hull_of(np.array(corners))])


def _driver() -> Model:
    grip, cap = _handle()
    visuals = (
        Visual(mesh_shape("grip", grip), RED),
        Visual(mesh_shape("cap", cap), YELLOW),
        Visual(mesh_shape("steel", _steel()), STEEL),
    )
    collisions = (
        cylinder_shape(HANDLE_RADIUS, HANDLE),
        cylinder_shape(SHAFT_RADIUS, SHAFT, (0.0, 0.0, -(HANDLE + SHAFT) / 2.0)),
        box_shape(BLADE, (0.0, 0.0, TIP + BLADE[2] / 2.0)),
    )
    link = Link("screwdriver", 0.12, visuals, collisions, friction=0.8)
    notes = (
        f"upright, blade below; the blade ends at z = {TIP:.3f}, {BLADE[1]} wide along y and {BLADE[0]} thick",
        f"in `screwdriver_stand` its origin is at z = {STAND_HEIGHT + HANDLE / 2.0}",
    )
    return Model("screwdriver", "objects/screwdriver", "centre of the handle", (link,), notes=notes)


def _stand() -> Model:
    wall = (STAND - STAND_HOLE) / 2.0
    middle, z = (STAND + STAND_HOLE) / 4.0, STAND_HEIGHT / 2.0
    walls = [box_shape((wall, STAND, STAND_HEIGHT), (s * middle, 0.0, z)) for s in (-1.0, 1.0)]
    walls += [box_shape((STAND_HOLE, wall, STAND_HEIGHT), (0.0, s * middle, z)) for s in (-1.0, 1.0)]
    visuals = (Visual(mesh_shape("stand", merge(box(w.size, w.xyz) for w in walls)), (0.25, 0.35, 0.45)),)
    notes = (f"square hole {STAND_HOLE} wide from top to bottom, top at z = {STAND_HEIGHT}",)
    link = Link("screwdriver_stand", 0.5, visuals, tuple(walls), friction=0.8)
    return Model("screwdriver_stand", "objects/screwdriver_stand", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_block(), _driver(), _stand())
