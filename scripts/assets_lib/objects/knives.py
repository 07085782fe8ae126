"""A kitchen knife, a slanted block with a slot for it, and a chopping board."""

from __future__ import annotations

import numpy as np

from assets_lib.cabinets import bevelled_box
from assets_lib.mesh import Mesh, hull_of, merge
from assets_lib.prisms import grown, hull_prism, mark, rectangle, regular_polygon
from assets_lib.urdf import Link, Model, Shape, Vec3, Visual, box_shape, mesh_shape, metal, patterned, plastic

HANDLE, BLADE = (0.10, 0.025, 0.02), (0.11, 0.028, 0.003)
TIP = HANDLE[0] / 2.0 + BLADE[0]
"""x of the end of the blade in the knife [m]."""
SLANT = np.pi / 4.0
"""Angle of the slots below the horizontal [rad]."""
SLOT = (0.10, 0.035, 0.010)
"""Depth, width and height of the open slot [m]."""
BLOCK_LENGTH, BLOCK_WIDTH, ABOVE, BELOW, LOW_EDGE, FOOT = 0.125, 0.10, 0.035, 0.075, 0.06, 0.02
"""Of the block along the slots and across, over and under the open slot; its front ends so high, and the foot is set back [m]."""
BLOCK_BEVEL, LAYER, RUBBER = 0.003, 0.018, (0.10, 0.10, 0.11)
"""Of the block: bevel of its outer edges, half the thickness of the layer in the middle [m], and colour of its foot."""
BOARD, BOARD_BEVEL = (0.24, 0.16, 0.015), 0.003
WALNUT, MAPLE, GROOVE = patterned((0.50, 0.31, 0.18), "wood"), patterned((0.86, 0.72, 0.50), "wood"), (0.62, 0.47, 0.29)
GRIP, STEEL, EDGE, DARK = plastic((0.09, 0.09, 0.10)), metal((0.78, 0.80, 0.83)), metal((0.92, 0.93, 0.95)), (0.05, 0.03, 0.02)


def _blade() -> Mesh:
    x = HANDLE[0] / 2.0
    edge = [(x, -0.014), (0.105, -0.0135), (0.138, -0.007), (0.152, 0.0), (TIP, 0.008)]
    spine = [(0.148, 0.0125), (0.12, 0.014), (x, 0.014)]
    return hull_prism(np.array(edge + spine), -BLADE[2] / 2.0, BLADE[2] / 2.0)


def _both_sides(points: list[tuple[float, float]] | np.ndarray, height: float) -> Mesh:
    """Return a mark on the upper and on the lower side, symmetric about the x axis."""
    flat = mark(points, height, "z")
    return merge([flat, flat.moved(rpy=(np.pi, 0.0, 0.0))])


def _edge() -> Mesh:
    """Return the ground edge of the blade, on both sides."""
    strip = [(0.054, -0.0138), (0.105, -0.0133), (0.138, -0.0068), (0.154, 0.0022)]
    strip += [(0.136, -0.0045), (0.104, -0.0095), (0.054, -0.0095)]
    height = BLADE[2] / 2.0 + 0.0003
    parts = [strip[0:2] + strip[5:7], strip[1:3] + strip[4:6], strip[2:5]]
    above = merge(mark(part, height, "z") for part in parts)
    below = merge(mark([(x, -y) for x, y in part], height, "z") for part in parts).moved(rpy=(np.pi, 0.0, 0.0))
    return merge([above, below])


def _knife() -> Model:
    x, y, z = HANDLE
    rivets = [regular_polygon(0.003, 12) + (at, 0.0) for at in (-0.03, 0.0, 0.03)]
    visuals = (
        Visual(mesh_shape("grip", bevelled_box((x - 0.006, y, z), (-0.003, 0.0, 0.0), 0.004)), GRIP),
        Visual(mesh_shape("bolster", bevelled_box((0.012, y - 0.002, z - 0.004), (x / 2.0 - 0.006, 0.0, 0.0), 0.002)), STEEL),
        Visual(mesh_shape("rivets", merge(_both_sides(rivet, z / 2.0 + 0.0003) for rivet in rivets)), STEEL),
        Visual(mesh_shape("blade", _blade()), STEEL),
        Visual(mesh_shape("edge", _edge()), EDGE),
    )
    broad = 0.08
    collisions = (
        box_shape(HANDLE),
        box_shape((broad, BLADE[1], BLADE[2]), ((x + broad) / 2.0, 0.0, 0.0)),
        box_shape((BLADE[0] - broad, 0.014, BLADE[2]), ((x + broad + BLADE[0]) / 2.0, 0.005, 0.0)),
    )
    notes = (f"lies on its handle, {y} wide along y; the blade is {BLADE[1]} wide, {BLADE[2]} thick, and ends at x = {TIP}",)
    link = Link("kitchen_knife", 0.08, visuals, collisions, friction=0.6)
    return Model("kitchen_knife", "objects/kitchen_knife", "centre of the handle", (link,), notes=notes)


def _axes() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return in x, z the mouth of the open slot, the direction into it, and that across it, upwards."""
    into, across = np.array([np.cos(SLANT), -np.sin(SLANT)]), np.array([np.sin(SLANT), np.cos(SLANT)])
    length = float((BELOW + ABOVE) * across[0] + BLOCK_LENGTH * into[0])
    return np.array([-length / 2.0, LOW_EDGE]) + BELOW * across, into, across


def _at(along: float, across: float) -> np.ndarray:
    """Return x, z of a point in the axes of the open slot."""
    mouth, into, up = _axes()
    return np.asarray(mouth + along * into + across * up)


def _profile(top: float) -> np.ndarray:
    """Return the outline (n, 2) of the block below a height across the slot, counter-clockwise."""
    back = _at(BLOCK_LENGTH, ABOVE)
    foot = back - back[1] / np.cos(SLANT) * _axes()[2]
    front = _at(0.0, -BELOW)
    return np.array([(front[0] + FOOT, 0.0), foot, _at(BLOCK_LENGTH, top), _at(0.0, top), front])


def _upright(points: np.ndarray, half: float) -> list[Vec3]:
    return [(x, s * half, z) for x, z in points for s in (-1.0, 1.0)]


def _body() -> Mesh:
    """Return what is seen of the block: a wedge that stands on its whole length, where what collides stands on less."""
    outline, half = _standing(), BLOCK_WIDTH / 2.0
    sides = []
    for side in (-1.0, 1.0):
        points = [(outline, LAYER), (outline, half - BLOCK_BEVEL), (grown(outline, -BLOCK_BEVEL), half)]
        sides.append(hull_of(np.round(np.array([(x, side * y, z) for corners, y in points for x, z in corners]), 6)))
    return merge(sides)


def _core() -> Mesh:
    """Return the lighter layer in the middle of the block."""
    return hull_of(np.round(np.array(_upright(_standing(), LAYER)), 6))


def _foot() -> Mesh:
    """Return the rubber below the block."""
    low, high = _standing()[0, 0], _standing()[1, 0]
    return bevelled_box((high - low + 0.0012, BLOCK_WIDTH + 0.0012, 0.005), ((low + high) / 2.0, 0.0, 0.0025), 0.001)


def _face() -> Mesh:
    """Return the lighter wood of the end around the mouths of the slots."""
    low, high = 0.004 - BELOW, ABOVE - 0.004
    points = rectangle(BLOCK_WIDTH - 0.008, high - low) + (0.0, (low + high) / 2.0)
    x, z = _at(0.0, 0.0)
    return mark(points, 0.0003, "x").moved((float(x), 0.0, float(z)), (0.0, -SLANT, np.pi))


def _standing() -> np.ndarray:
    """Return the outline (n, 2) of what is seen of the block, counter-clockwise."""
    outline = _profile(ABOVE)
    outline[:2] = (outline[-1, 0], 0.0), (outline[2, 0], 0.0)
    return outline


def _in_slot(size: Vec3, along: float, side: float, across: float) -> Shape:
    """Return a box in the axes of the open slot."""
    x, z = _at(along, across)
    return box_shape(size, (float(x), side, float(z)), (0.0, SLANT, 0.0))


def _block_shapes() -> tuple[Shape, ...]:
    depth, width, height = SLOT
    wall = (BLOCK_WIDTH - width) / 2.0
    lower = hull_of(np.round(np.array(_upright(_profile(-height / 2.0), BLOCK_WIDTH / 2.0)), 6))
    middle = BLOCK_LENGTH / 2.0
    return (
        mesh_shape("lower", lower),
        _in_slot((BLOCK_LENGTH, BLOCK_WIDTH, ABOVE - height / 2.0), middle, 0.0, (ABOVE + height / 2.0) / 2.0),
        *(_in_slot((BLOCK_LENGTH, wall, height), middle, s * (width + wall) / 2.0, 0.0) for s in (-1.0, 1.0)),
        _in_slot((BLOCK_LENGTH - depth, width, height), (BLOCK_LENGTH + depth) / 2.0, 0.0, 0.0),
    )


def _mouths() -> Mesh:
    """Return the dark mouths of the slots, the open one uppermost."""
    _, width, height = SLOT
    marks = [rectangle(width, height)]
    marks += [rectangle(0.034, 0.006) + (side, down) for down in (-0.022, -0.040) for side in (-0.022, 0.022)]
    marks += [rectangle(0.024, 0.006) + (side, -0.058) for side in (-0.022, 0.022)]
    x, z = _at(0.0, 0.0)
    return merge(mark(points, 0.0008, "x") for points in marks).moved((float(x), 0.0, float(z)), (0.0, -SLANT, np.pi))


def _block() -> Model:
    visuals = (
        Visual(mesh_shape("body", _body()), WALNUT),
        Visual(mesh_shape("core", _core()), patterned((0.66, 0.45, 0.27), "wood")),
        Visual(mesh_shape("face", _face()), patterned((0.74, 0.56, 0.36), "wood")),
        Visual(mesh_shape("mouths", _mouths()), DARK),
        Visual(mesh_shape("foot", _foot()), RUBBER),
    )
    mouth = _at(0.0, 0.0)
    notes = (
        f"open slot {SLOT[1]} x {SLOT[2]}, {SLOT[0]} deep; its mouth is at x = {mouth[0]:.4f}, z = {mouth[1]:.4f}, "
        f"it goes down towards +x at {SLANT:.4f} rad; the other slots are painted",
    )
    link = Link("knife_block", 2.0, visuals, _block_shapes(), friction=0.4)
    return Model("knife_block", "objects/knife_block", "bottom centre", (link,), notes=notes)


def _groove() -> Mesh:
    """Return the groove for juice around the upper side."""
    x, y, z = BOARD
    long, short, inset, width = x - 0.024, y - 0.024, 0.012, 0.004
    sides = [rectangle(long, width) + (0.0, s * (y / 2.0 - inset)) for s in (-1.0, 1.0)]
    sides += [rectangle(width, short) + (s * (x / 2.0 - inset), 0.0) for s in (-1.0, 1.0)]
    return merge(mark(side, z + 0.0003, "z") for side in sides)


def _board() -> Model:
    visuals = (
        Visual(mesh_shape("board", bevelled_box(BOARD, (0.0, 0.0, BOARD[2] / 2.0), BOARD_BEVEL)), MAPLE),
        Visual(mesh_shape("groove", _groove()), GROOVE),
    )
    link = Link("chopping_board", 0.6, visuals, (box_shape(BOARD, (0.0, 0.0, BOARD[2] / 2.0)),), friction=0.8)
    return Model("chopping_board", "objects/chopping_board", "bottom centre", (link,))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_knife(), _block(), _board())
