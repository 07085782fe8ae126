"""A screwdriver, an open stand for it, and a block with a slotted screw that turns."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from assets_lib.mesh import Mesh, box, hull_of, lathe, merge
from assets_lib.prisms import bevelled_box, hull_prism, mark, rectangle
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape, metal, plastic

BLOCK = (0.08, 0.08, 0.06)
HEAD_RADIUS, HEAD_BOTTOM, HEAD_FLOOR, HEAD_TOP, GAP = 0.01, 0.02, 0.024, 0.03, 0.001
"""Radius of the head; its lower side, bottom of its slot and its top above the block; space below the screw [m]."""
THREAD_RADIUS, TURNS = 0.006, 4
SLOT = 0.004
HANDLE_RADIUS, HANDLE, SHAFT_RADIUS, SHAFT = 0.015, 0.08, 0.004, 0.08
BLADE = (0.0025, 0.016, 0.008)
STAND, STAND_HEIGHT, STAND_HOLE, STAND_PLATE, POST = 0.05, 0.092, 0.02, 0.012, 0.007
TIP = -HANDLE / 2.0 - SHAFT - BLADE[2]
"""z of the end of the blade [m]."""
WOOD, GRAIN, BLUE, STEEL, DARK = (
    (0.58, 0.38, 0.21),
    (0.40, 0.25, 0.13),
    (0.16, 0.36, 0.56),
    metal((0.80, 0.82, 0.86)),
    (0.10, 0.10, 0.12),
)
ARROW = (0.95, 0.93, 0.86)
RED, YELLOW = plastic((0.82, 0.12, 0.10)), plastic((0.95, 0.80, 0.15))


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
    plate = cylinder_shape(HEAD_RADIUS, HEAD_FLOOR - HEAD_BOTTOM, (0.0, 0.0, (HEAD_FLOOR + HEAD_BOTTOM) / 2.0))
    shaft = cylinder_shape(THREAD_RADIUS, HEAD_BOTTOM - GAP, (0.0, 0.0, (HEAD_BOTTOM + GAP) / 2.0))
    return (plate, shaft, *halves)


def _thread() -> Mesh:
    """Return the shaft of the screw with its turns, from the block to below the head."""
    pitch = (HEAD_BOTTOM - GAP) / TURNS
    outline = [(0.0, GAP)]
    for i in range(TURNS):
        outline += [(THREAD_RADIUS - 0.002, GAP + i * pitch), (THREAD_RADIUS, GAP + (i + 0.6) * pitch)]
    return lathe([*outline, (THREAD_RADIUS, HEAD_BOTTOM), (0.0, HEAD_BOTTOM)], 10)


def _dial() -> Mesh:
    """Return an arrow for a quarter turn to the right, on the block around the screw."""
    z, radius, half, first, last = BLOCK[2] + 0.0006, 0.027, 0.003, np.deg2rad(180.0), np.deg2rad(60.0)
    around = [np.array([np.cos(a), np.sin(a)]) for a in np.linspace(first, last, 7)]
    arc = [[u * (radius + s * half) for u in pair for s in (-1.0, 1.0)] for pair in pairwise(around)]
    out, ahead = around[-1], np.array([np.sin(last), -np.cos(last)])
    tip = [out * (radius + 0.011), out * (radius - 0.011), out * radius + 0.018 * ahead]
    return merge(mark(np.array(points), z, "z") for points in (*arc, tip))


def _grain() -> Mesh:
    """Return the lines of the grain on the sides of the block."""
    lines = []
    for z, start, end in ((0.012, -0.46, 0.2), (0.024, -0.2, 0.46), (0.036, -0.46, 0.35), (0.048, -0.3, 0.46)):
        length, middle = BLOCK[0] * (end - start), BLOCK[0] * (start + end) / 2.0
        line = mark(rectangle(length, 0.002) + (middle, z), BLOCK[0] / 2.0 + 0.0004, "x")
        lines += [line.moved(rpy=(0.0, 0.0, quarter * np.pi / 2.0)) for quarter in range(4)]
    return merge(lines)


def _block() -> Model:
    plate = lathe([(0.0, HEAD_BOTTOM), (HEAD_RADIUS, HEAD_BOTTOM), (HEAD_RADIUS, HEAD_FLOOR), (0.0, HEAD_FLOOR)], 16)
    slot = mark(rectangle(SLOT, 2.0 * HEAD_RADIUS - 0.001), HEAD_FLOOR + 0.0004, "z")
    base = Link(
        "screw_block",
        1.5,
        (
            Visual(mesh_shape("block", bevelled_box(BLOCK, 0.003)), WOOD),
            Visual(mesh_shape("grain", _grain()), GRAIN),
            Visual(mesh_shape("dial", _dial()), ARROW),
        ),
        (box_shape(BLOCK, (0.0, 0.0, BLOCK[2] / 2.0)),),
    )
    visuals = (
        Visual(mesh_shape("head", merge([plate, _half_head(1.0)])), STEEL),
        Visual(mesh_shape("marked_half", _half_head(-1.0)), RED),
        Visual(mesh_shape("thread", _thread()), STEEL, crease=0.2),
        Visual(mesh_shape("slot", slot), DARK),
    )
    screw = Link("screw_link", 0.03, visuals, _head_shapes(), friction=0.4)
    joint = Joint(
        "screw", "revolute", "screw_block", "screw_link", (0.0, 0.0, BLOCK[2]), (0.0, 0.0, -1.0), -3.2, 3.2, damping=0.002
    )
    notes = (
        f"tightening increases joint `screw`; its slot is along y at 0, {SLOT} wide, from z = {HEAD_FLOOR} to {HEAD_TOP} "
        "in `screw_link`",
        "the screw turns but does not go down; give it friction",
    )
    return Model("screw_block", "objects/screw_block", "bottom centre", (base, screw), (joint,), notes=notes)


def _handle() -> tuple[Mesh, Mesh]:
    """Return the grip and its coloured cap."""
    h, r = HANDLE / 2.0, HANDLE_RADIUS
    grip = [(0.0, -h), (0.007, -h), (r - 0.003, -h + 0.012), (r, -h + 0.024), (r, h - 0.016), (0.0, h - 0.016)]
    cap = [(0.0, h - 0.016), (r, h - 0.016), (r, h - 0.006), (r - 0.006, h), (0.0, h)]
    return lathe(grip, 12), lathe(cap, 12)


def _grooves() -> Mesh:
    """Return dark lines along the grip."""
    line = mark(rectangle(0.0026, HANDLE - 0.044) + (0.0, 0.003), HANDLE_RADIUS + 0.0003, "x")
    return merge(line.moved(rpy=(0.0, 0.0, k * np.pi / 4.0)) for k in range(8))


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
        Visual(mesh_shape("grooves", _grooves()), DARK),
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


def _plate() -> list[Shape]:
    """Return the upper plate of the stand, with its hole."""
    wall, middle = (STAND - STAND_HOLE) / 2.0, (STAND + STAND_HOLE) / 4.0
    z = STAND_HEIGHT - STAND_PLATE / 2.0
    shapes = [box_shape((wall, STAND, STAND_PLATE), (s * middle, 0.0, z)) for s in (-1.0, 1.0)]
    return shapes + [box_shape((STAND_HOLE, wall, STAND_PLATE), (0.0, s * middle, z)) for s in (-1.0, 1.0)]


def _stand() -> Model:
    """Return a plate on four posts, between which shaft and blade are seen."""
    tall, place = STAND_HEIGHT - STAND_PLATE, (STAND - POST) / 2.0
    posts = [box_shape((POST, POST, tall), (x, y, tall / 2.0)) for x in (-place, place) for y in (-place, place)]
    shapes = (*_plate(), *posts)
    visuals = (Visual(mesh_shape("stand", merge(box(s.size, s.xyz) for s in shapes)), BLUE),)
    notes = (f"square hole {STAND_HOLE} wide in a plate {STAND_PLATE} thick on four posts, top at z = {STAND_HEIGHT}",)
    link = Link("screwdriver_stand", 0.5, visuals, shapes, friction=0.8)
    return Model("screwdriver_stand", "objects/screwdriver_stand", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_block(), _driver(), _stand())
