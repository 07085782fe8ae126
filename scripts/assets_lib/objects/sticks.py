"""A billiard cue, a ball and a pocket; a stick to reach with; the rests that sticks lie on."""

from __future__ import annotations

import numpy as np

from assets_lib.cabinets import bevelled_box
from assets_lib.mesh import Mesh, cylinder, hull_of, lathe, merge, rotation
from assets_lib.urdf import (
    Link,
    Model,
    Shape,
    Vec3,
    Visual,
    box_shape,
    cylinder_shape,
    mesh_shape,
    patterned,
    plastic,
    sphere_shape,
)

RADIUS = 0.01
AXIS = 0.03
"""Height of the axis of a stick that lies on its rests [m]."""
CUE, TAPER, TIP_RADIUS = 0.35, 0.06, 0.006
"""Length of the cue, of its thinner end towards +x, and the radius of its tip [m]."""
STICK = 0.30
BALL = 0.02
MARGIN = 0.001
"""The engine keeps cylinders so far from other bodies [m]."""
POCKET, WALL = (0.08, 0.10, 0.05), 0.008
"""Depth, width, height, and thickness of the walls [m]."""
V_PLATE: Vec3 = (0.02, 0.006, 0.022)
FOOT: Vec3 = (0.024, 0.05, 0.008)
MAPLE, WALNUT, RED, FELT = (0.80, 0.60, 0.36), (0.30, 0.16, 0.09), plastic((0.70, 0.06, 0.07)), (0.06, 0.36, 0.22)
BRASS, CHALK, IVORY, RUBBER = (0.78, 0.62, 0.28), (0.25, 0.45, 0.62), plastic((0.94, 0.92, 0.86)), (0.13, 0.13, 0.14)
ALONG_X: Vec3 = (0.0, float(np.pi / 2.0), 0.0)


def _turned(outline: list[tuple[float, float]], segments: int = 16) -> Mesh:
    """Turn an outline (radius, x) about the x axis."""
    return lathe([(outline[0][0] * 0.0, outline[0][1]), *outline, (0.0, outline[-1][1])], segments).moved(rpy=ALONG_X)


def _cue() -> Model:
    end, neck = CUE / 2.0, CUE / 2.0 - TAPER
    grip = _turned([(0.0075, -end), (RADIUS, -end + 0.0025), (RADIUS, -0.065)])
    shaft = _turned([(RADIUS, -0.055), (RADIUS, neck), (TIP_RADIUS, end - 0.013)])
    rings = [_turned([(RADIUS + 0.0004, x), (RADIUS + 0.0004, x + w)]) for x, w in ((-0.065, 0.010), (-0.150, 0.004))]
    ferrule = _turned([(TIP_RADIUS, end - 0.013), (TIP_RADIUS, end - 0.004)])
    chalked = _turned([(TIP_RADIUS, end - 0.004), (TIP_RADIUS, end - 0.0015), (0.004, end)])
    visuals = (
        Visual(mesh_shape("grip", grip), patterned(plastic(WALNUT), "wood")),
        Visual(mesh_shape("shaft", shaft), patterned(plastic(MAPLE), "wood")),
        Visual(mesh_shape("rings", merge(rings)), BRASS),
        Visual(mesh_shape("ferrule", ferrule), IVORY),
        Visual(mesh_shape("tip", chalked), CHALK),
    )
    thin = cylinder_shape(TIP_RADIUS, TAPER, (neck + TAPER / 2.0, 0.0, 0.0), ALONG_X)
    thick = cylinder_shape(RADIUS, CUE - TAPER, (-TAPER / 2.0, 0.0, 0.0), ALONG_X)
    link = Link("cue", 0.1, visuals, (thick, thin), friction=0.8)
    notes = (
        f"along x, tip at x = {end}; diameter {2 * RADIUS}, {2 * TIP_RADIUS} over the last {TAPER}",
        f"lies on two `stick_rest`, its axis at z = {AXIS}",
    )
    return Model("cue", "objects/cue", "centre", (link,), notes=notes)


def _reach_stick() -> Model:
    end = STICK / 2.0
    pole = _turned([(RADIUS, -end + 0.073), (RADIUS, end - 0.022)])
    sleeve = _turned([(RADIUS - 0.002, -end), (RADIUS, -end + 0.002), (RADIUS, -end + 0.072), (RADIUS - 0.001, -end + 0.073)])
    cap = _turned([(RADIUS, end - 0.022), (RADIUS, end - 0.003), (RADIUS - 0.003, end)])
    visuals = (
        Visual(mesh_shape("pole", pole), patterned((0.72, 0.50, 0.28), "wood")),
        Visual(mesh_shape("sleeve", sleeve), plastic((0.20, 0.32, 0.44))),
        Visual(mesh_shape("cap", cap), RUBBER),
    )
    link = Link("reach_stick", 0.06, visuals, (cylinder_shape(RADIUS, STICK, (0.0, 0.0, 0.0), ALONG_X),), friction=0.8)
    notes = (
        f"along x, diameter {2 * RADIUS}, length {STICK}; the sleeve for the hand is at the end towards -x",
        f"lies on two `stick_rest`, its axis at z = {AXIS}",
    )
    return Model("reach_stick", "objects/reach_stick", "centre", (link,), notes=notes)


def _notch(below: float) -> tuple[Shape, ...]:
    """Return the two sloping plates of a notch, a distance below the place where they touch a stick."""
    plates = []
    for side in (-1.0, 1.0):
        roll = (side * float(np.pi / 4.0), 0.0, 0.0)
        _, y, z = rotation(roll) @ np.array([0.0, side * 0.003, -RADIUS - below - V_PLATE[1] / 2.0])
        plates.append(box_shape((V_PLATE[0], V_PLATE[2], V_PLATE[1]), (0.0, float(y), AXIS + float(z)), roll))
    return tuple(plates)


def _rest() -> Model:
    """Return a block with a notch along x."""
    foot = box_shape(FOOT, (0.0, 0.0, FOOT[2] / 2.0))
    x = V_PLATE[0] / 2.0 - 0.0005
    root = AXIS - 1.42 * RADIUS
    halves = [
        hull_of(
            np.array([(u, s * y, z) for u in (-x, x) for y, z in ((0.022, FOOT[2]), (0.016, 0.024), (0.0, root), (0.0, FOOT[2]))])
        )
        for s in (-1.0, 1.0)
    ]
    lining = merge(plate.mesh() for plate in _notch(0.0))
    visuals = (
        Visual(
            mesh_shape("block", merge([*halves, bevelled_box(FOOT, (0.0, 0.0, FOOT[2] / 2.0))])),
            patterned(WALNUT, "wood"),
            crease=0.1,
        ),
        Visual(mesh_shape("lining", lining), FELT, crease=0.1),
    )
    link = Link("stick_rest", 0.3, visuals, (*_notch(MARGIN), foot), friction=0.8)
    notes = (f"holds a stick of radius {RADIUS} along x in a notch, its axis at z = {AXIS}",)
    return Model("stick_rest", "objects/stick_rest", "bottom centre", (link,), notes=notes)


def _zone(low: float, high: float) -> Mesh:
    """Return the part of the ball between two latitudes [rad]."""
    outline = [(BALL * float(np.cos(a)), BALL * float(np.sin(a))) for a in np.linspace(low, high, 6)]
    return lathe([(0.0, outline[0][1]), *outline, (0.0, outline[-1][1])], 24)


def _ball() -> Model:
    pole, edge, lying = 1.57, 0.45, (0.9, 0.3, 0.0)
    caps = merge([_zone(edge, pole), _zone(-pole, -edge)]).moved(rpy=lying)
    visuals = (
        Visual(mesh_shape("caps", caps), IVORY, crease=0.9),
        Visual(mesh_shape("band", _zone(-edge, edge).moved(rpy=lying)), RED, crease=0.9),
    )
    link = Link("billiard_ball", 0.05, visuals, (sphere_shape(BALL),), friction=0.5, rolling=0.0002)
    return Model("billiard_ball", "objects/billiard_ball", "centre", (link,), notes=(f"rests with its origin at {BALL} m",))


def _pocket() -> Model:
    """Return a corner of a billiard table that opens towards -x."""
    x, y, z = POCKET
    boxes: list[tuple[Vec3, Vec3]] = [((WALL, y, z), (x - WALL / 2.0, 0.0, z / 2.0))]
    boxes += [((x - WALL, WALL, z), ((x - WALL) / 2.0, s * (y - WALL) / 2.0, z / 2.0)) for s in (-1.0, 1.0)]
    shapes = tuple(box_shape(*one) for one in boxes)
    low = merge(bevelled_box((size[0], size[1], z - 0.010), (at[0], at[1], (z - 0.010) / 2.0)) for size, at in boxes)
    rails = merge(bevelled_box((size[0], size[1], 0.012), (at[0], at[1], z - 0.006)) for size, at in boxes)
    hole = cylinder(0.031, 0.001, 32).moved((0.0385, 0.0, 0.0012))
    inner = cylinder(0.036, 0.001, 32).moved((0.036, 0.0, 0.0008))
    rim = [(0.0405, 0.0008), (0.0395, 0.0028), (0.0375, 0.0034), (0.0358, 0.0024), (0.0355, 0.0010)]
    ring = lathe(rim, 32).moved((0.036, 0.0, 0.0))
    ring = Mesh(np.column_stack([np.clip(ring.vertices[:, 0], 0.0, x - WALL), *ring.vertices.T[1:]]), ring.faces)
    cloth = box_shape((x - WALL, y - 2.0 * WALL, 0.001), ((x - WALL) / 2.0, 0.0, 0.0005))
    visuals = (
        Visual(mesh_shape("cushions", low), patterned(FELT, "cloth"), crease=0.1),
        Visual(mesh_shape("rails", rails), patterned(plastic(WALNUT), "wood"), crease=0.1),
        Visual(mesh_shape("cloth", cloth.mesh()), patterned(FELT, "cloth")),
        Visual(mesh_shape("hole_wall", inner), (0.17, 0.13, 0.10)),
        Visual(mesh_shape("hole", hole), (0.015, 0.015, 0.015)),
        Visual(mesh_shape("hole_rim", ring), plastic((0.42, 0.25, 0.13))),
    )
    link = Link("billiard_pocket", 1.0, visuals, shapes, friction=0.6)
    notes = (f"opens towards -x and upwards; {x} deep, {y} wide, {z} high, walls {WALL}; floor and hole are only seen",)
    return Model("billiard_pocket", "objects/billiard_pocket", "on the floor, middle of the open side", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_cue(), _reach_stick(), _rest(), _ball(), _pocket())
