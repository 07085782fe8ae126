"""A small basketball, the nest that it lies in, and a hoop on a post."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, box, cylinder, icosphere, lathe, merge, rod
from assets_lib.prisms import bevelled_box
from assets_lib.urdf import Link, Model, Vec3, Visual, box_shape, cylinder_shape, mesh_shape, metal, patterned, sphere_shape

BALL = 0.0325
NEST, STOP, STOP_RADIUS = (0.045, 0.004), (0.008, 0.016, 0.012), 0.030
"""Radius and height of the plate; size of a stop, and distance of its middle from that of the nest [m]."""
RIM, RIM_HEIGHT, WIRE, SEGMENTS = 0.055, 0.30, 0.004, 16
"""Inner radius of the ring, its height over the table, and the radius of its wire [m]."""
BOARD, BOARD_X, BOARD_Z = (0.006, 0.18, 0.11), 0.082, 0.345
POST, POST_X, FOOT = 0.018, 0.098, (0.15, 0.13, 0.014)
ORANGE, SEAM, STEEL = (0.83, 0.40, 0.14), (0.13, 0.10, 0.09), metal((0.34, 0.36, 0.40))
WHITE, RED = (0.93, 0.93, 0.91), (0.80, 0.22, 0.13)
HALF_PI = float(np.pi / 2.0)


def _seam(radius: float, rpy: Vec3, offset: float = 0.0) -> Mesh:
    """Return a thin band around the ball, `offset` away from its middle."""
    inner, outer, half = radius - 0.001, radius + 0.0006, 0.0007
    profile = [(inner, -half), (outer, -half), (outer, half), (inner, half)]
    return lathe(profile, 24).moved((0.0, 0.0, offset)).moved((0.0, 0.0, 0.0), rpy)


def _ball() -> Model:
    small = float(np.sqrt(BALL**2 - 0.018**2))
    seams = [_seam(BALL, (0.0, 0.0, 0.0)), _seam(BALL, (HALF_PI, 0.0, 0.0))]
    seams += [_seam(small, (0.0, HALF_PI, 0.0), s * 0.018) for s in (-1.0, 1.0)]
    visuals = (
        Visual(mesh_shape("ball", icosphere(BALL, 2)), ORANGE, crease=1.2),
        Visual(mesh_shape("seams", merge(seams)), SEAM),
    )
    link = Link("basketball", 0.05, visuals, (sphere_shape(BALL),), friction=0.8, rolling=0.001)
    return Model("basketball", "objects/basketball", "centre", (link,), notes=(f"diameter {2 * BALL}",))


def _nest() -> Model:
    radius, height = NEST
    angles = [2.0 * float(np.pi) * i / 3 for i in range(3)]
    stops = tuple(
        box_shape(STOP, (STOP_RADIUS * float(np.cos(a)), STOP_RADIUS * float(np.sin(a)), height + STOP[2] / 2.0), (0.0, 0.0, a))
        for a in angles
    )
    blocks = [bevelled_box(STOP, 0.002).moved((*s.xyz[:2], height), s.rpy) for s in stops]
    plate = cylinder(radius, height, 32, bevel=0.001).moved((0.0, 0.0, height / 2.0))
    visuals = (Visual(mesh_shape("plate", plate), (0.30, 0.32, 0.36)), Visual(mesh_shape("stops", merge(blocks)), WHITE))
    shapes = (cylinder_shape(radius, height, (0.0, 0.0, height / 2.0)), *stops)
    notes = (f"the ball `basketball` rests between three stops, its middle at z = {height + BALL}",)
    return Model("ball_nest", "objects/ball_nest", "bottom centre", (Link("ball_nest", 0.2, visuals, shapes),), notes=notes)


def _around(radius: float, z: float, count: int, phase: float = 0.0) -> FloatArray:
    """Return points (count, 3) on a circle."""
    angles = 2.0 * np.pi * (np.arange(count) + phase) / count
    return np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full(count, z)])


def _net() -> Mesh:
    """Return the strings of the net: diamonds that grow narrower downwards."""
    count, rows = 9, ((0.056, 0.0), (0.050, -0.022), (0.044, -0.044), (0.041, -0.066))
    rings = [_around(radius, RIM_HEIGHT + z, count, 0.5 * (i % 2)) for i, (radius, z) in enumerate(rows)]
    strings = []
    for i, (upper, lower) in enumerate(zip(rings[:-1], rings[1:], strict=True)):
        for shift in (0, -1 if i % 2 == 0 else 1):
            strings += [rod(a, b, 0.0009, 3) for a, b in zip(upper, np.roll(lower, -shift, axis=0), strict=True)]
    return merge(strings)


def _ring() -> Mesh:
    middle = RIM + WIRE
    angles = 2.0 * np.pi * np.arange(7) / 6
    profile = [(middle + WIRE * float(np.sin(a)), -WIRE * float(np.cos(a))) for a in angles]
    return lathe(profile, 22).moved((0.0, 0.0, RIM_HEIGHT))


def _hoop() -> Model:
    middle = RIM + WIRE
    length = 2.0 * (RIM + 2.0 * WIRE) * float(np.tan(np.pi / SEGMENTS))
    wires = []
    for i in range(SEGMENTS):
        a = 2.0 * float(np.pi) * i / SEGMENTS
        place = (middle * float(np.cos(a)), middle * float(np.sin(a)), RIM_HEIGHT)
        wires.append(box_shape((2.0 * WIRE, length, 2.0 * WIRE), place, (0.0, 0.0, a)))
    front = BOARD_X - BOARD[0] / 2.0
    bracket = box_shape((front - RIM - WIRE, 0.03, 0.008), ((front + RIM + WIRE) / 2.0, 0.0, RIM_HEIGHT))
    board = box_shape(BOARD, (BOARD_X, 0.0, BOARD_Z))
    tall = BOARD_Z - FOOT[2]
    post = box_shape((POST, POST, tall), (POST_X, 0.0, FOOT[2] + tall / 2.0))
    foot = box_shape(FOOT, (POST_X + 0.03, 0.0, FOOT[2] / 2.0))
    border, square, face = 0.005, (0.07, 0.05), front - 0.0004
    low = BOARD_Z - BOARD[2] / 2.0
    lines = [box((0.001, BOARD[1], border), (face, 0.0, z)) for z in (low + border / 2.0, low + BOARD[2] - border / 2.0)]
    lines += [box((0.001, border, BOARD[2]), (face, s * (BOARD[1] - border) / 2.0, BOARD_Z)) for s in (-1, 1)]
    bottom = RIM_HEIGHT + 0.012
    lines += [box((0.001, square[0], 0.004), (face, 0.0, bottom + z)) for z in (0.0, square[1])]
    lines += [box((0.001, 0.004, square[1]), (face, s * square[0] / 2.0, bottom + square[1] / 2.0)) for s in (-1, 1)]
    panel = bevelled_box((BOARD[1], BOARD[2], BOARD[0]), 0.002)
    visuals = (
        Visual(mesh_shape("foot", bevelled_box(FOOT, 0.003).moved((POST_X + 0.03, 0.0, 0.0))), (0.22, 0.24, 0.28)),
        Visual(
            mesh_shape("post", bevelled_box((POST, POST, tall), 0.002).moved((POST_X, 0.0, FOOT[2]))), patterned(STEEL, "brushed")
        ),
        Visual(mesh_shape("board", panel.moved((front, 0.0, BOARD_Z), (HALF_PI, 0.0, HALF_PI))), WHITE),
        Visual(mesh_shape("lines", merge(lines)), RED),
        Visual(mesh_shape("ring", merge([_ring(), box(bracket.size, bracket.xyz)])), metal((0.85, 0.34, 0.10))),
        Visual(mesh_shape("net", _net()), WHITE, crease=0.1),
    )
    link = Link("basketball_hoop", 1.5, visuals, (*wires, bracket, board, post, foot), friction=0.5)
    notes = (
        f"ring around the z axis, inner diameter {2 * RIM}, its middle at z = {RIM_HEIGHT}, {2 * WIRE} thick",
        "the net is only seen",
        f"backboard in front of the post, its face towards -x at x = {front:.3f}, up to z = {BOARD_Z + BOARD[2] / 2.0}",
    )
    return Model("basketball_hoop", "objects/basketball_hoop", "on the floor below the middle of the ring", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_ball(), _nest(), _hoop())
