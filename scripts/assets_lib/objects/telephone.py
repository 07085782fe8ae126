"""A cordless handset and its charging cradle."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, box, cylinder, hull_of, merge, rod
from assets_lib.prisms import bevelled_box
from assets_lib.urdf import (
    Link,
    Model,
    Shape,
    Vec3,
    Visual,
    box_shape,
    cylinder_shape,
    glass,
    mesh_shape,
    metal,
    plastic,
    shining,
)

HANDSET = (0.15, 0.045, 0.025)
ANTENNA = (0.005, 0.022, 0.013)
"""Radius, length, and distance from the middle of the upper end [m]."""
SLOPE = 0.42
"""Angle between the bed of the cradle and the table [rad]."""
FOOT = (-0.045, 0.014)
"""x and z of the lower end of the bed [m]."""
CRADLE = (0.12, 0.10)
GAP, CHEEK = 0.003, 0.007
"""Gap beside the handset, and height of the cheeks over the bed [m]."""
STOP = (0.012, 0.017)
"""Thickness of the wall below the lower end of the handset, and its height over the bed [m]."""
SKIN = 0.001
"""Skin that PyBullet puts around collision meshes [m]."""
BODY, DARK, BASE, BRASS = plastic((0.88, 0.88, 0.86)), (0.11, 0.12, 0.14), plastic((0.20, 0.22, 0.26)), metal((0.83, 0.66, 0.30))
TURN: Vec3 = (0.0, -SLOPE, 0.0)


def _both_bevels(size: Vec3, bevel: float) -> Mesh:
    """Return a box around the origin with all its edges bevelled."""
    corners = []
    for axis in range(3):
        half = np.array(size) / 2.0 - bevel
        half[axis] += bevel
        corners += [half * (a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
    return hull_of(np.round(np.array(corners), 6))


def _handset() -> Model:
    x, y, z = HANDSET
    top = z / 2.0
    screen = bevelled_box((0.034, 0.034, 0.0012), 0.0008).moved((0.032, 0.0, top - 0.0004))
    keys = [
        bevelled_box((0.009, 0.0095, 0.0022), 0.0009).moved((-0.012 - 0.0135 * row, 0.0125 * column, top - 0.0004))
        for row in range(4)
        for column in (-1, 0, 1)
    ]
    call, hang = (
        bevelled_box((0.007, 0.013, 0.0022), 0.0009).moved((0.006, side * 0.0105, top - 0.0004)) for side in (1.0, -1.0)
    )
    slots = [box((0.0016, 0.016 - 0.004 * abs(i), 0.0008), (0.060 + 0.0035 * i, 0.0, top)) for i in (-1, 0, 1)]
    contacts = [box((0.007, 0.004, 0.0006), (-x / 2.0 + 0.010, s * 0.010, -top)) for s in (-1, 1)]
    radius, length, side = ANTENNA
    stub = cylinder(radius, length, 14, bevel=0.0015).moved((x / 2.0 + length / 2.0 - 0.002, side, 0.0), (0.0, np.pi / 2.0, 0.0))
    visuals = (
        Visual(mesh_shape("body", _both_bevels(HANDSET, 0.004)), BODY, crease=0.3),
        Visual(mesh_shape("screen", screen), glass((0.10, 0.16, 0.18))),
        Visual(mesh_shape("keys", merge(keys)), DARK),
        Visual(mesh_shape("call", call), (0.22, 0.58, 0.30)),
        Visual(mesh_shape("hang_up", hang), (0.74, 0.22, 0.20)),
        Visual(mesh_shape("slots", merge(slots)), DARK),
        Visual(mesh_shape("contacts", merge(contacts)), BRASS),
        Visual(mesh_shape("antenna", stub), DARK),
    )
    shapes = (
        box_shape(HANDSET),
        cylinder_shape(radius, length, (x / 2.0 + length / 2.0 - 0.002, side, 0.0), (0.0, float(np.pi / 2.0), 0.0)),
    )
    link = Link("handset", 0.12, visuals, shapes, friction=0.6, center=(0.0, 0.0, 0.0))
    notes = (
        f"{HANDSET} m, keys on top, antenna at +x, contacts below at -x; grasp it across y",
        f"rests on its back with its origin at {z / 2.0} m",
    )
    return Model("phone_handset", "objects/phone_handset", "centre of the body without the antenna", (link,), notes=notes)


def _on_bed(along: float, above: float, side: float = 0.0) -> Vec3:
    """Return the place at a distance along the bed from its lower end, and above it."""
    cos, sin = float(np.cos(SLOPE)), float(np.sin(SLOPE))
    return (FOOT[0] + along * cos - above * sin, side, FOOT[1] + along * sin + above * cos)


def _wedge(width: float, shrink: float) -> Mesh:
    """Return what carries the bed, its sides moved inwards."""
    length = (CRADLE[0] / 2.0 - FOOT[0]) / float(np.cos(SLOPE))
    low, high = _on_bed(-STOP[0], -shrink), _on_bed(length, -shrink)
    front, back, half = -CRADLE[0] / 2.0 + shrink, CRADLE[0] / 2.0 - shrink, width / 2.0 - shrink
    outline = [(front, shrink), (back, shrink), (back, high[2]), (low[0], low[2]), (front, min(low[2], 0.008))]
    points: FloatArray = np.array([(x, s * half, z) for x, z in outline for s in (-1.0, 1.0)])
    return hull_of(np.round(points, 6))


def _cradle() -> Model:
    inner, outer = HANDSET[1] / 2.0 + GAP, CRADLE[1] / 2.0
    length = (CRADLE[0] / 2.0 - FOOT[0]) / float(np.cos(SLOPE)) - 0.004
    thick = outer - inner
    cheeks: list[Shape] = [
        box_shape((length, thick, 2.0 * CHEEK), _on_bed(length / 2.0, 0.0, s * (inner + outer) / 2.0), TURN) for s in (-1.0, 1.0)
    ]
    stop = box_shape((STOP[0], CRADLE[1], STOP[1] + 0.006), _on_bed(-STOP[0] / 2.0, (STOP[1] - 0.006) / 2.0), TURN)
    seen = [
        bevelled_box((length, thick, CHEEK + 0.004), 0.002).moved(_on_bed(length / 2.0, -0.004, c.xyz[1]), TURN) for c in cheeks
    ]
    seen.append(bevelled_box((STOP[0], CRADLE[1], STOP[1] + 0.006), 0.002).moved(_on_bed(-STOP[0] / 2.0, -0.006), TURN))
    pins = [bevelled_box((0.006, 0.003, 0.0014), 0.0005).moved(_on_bed(0.010, 0.0, s * 0.010), TURN) for s in (-1, 1)]
    light = bevelled_box((0.004, 0.010, 0.001), 0.0004).moved(_on_bed(-STOP[0] / 2.0, STOP[1], 0.034), TURN)
    bed = bevelled_box((length - 0.004, 2.0 * inner - 0.002, 0.0006), 0.0003).moved(_on_bed(length / 2.0, -0.0002), TURN)
    end = CRADLE[0] / 2.0
    relief = [(0.0052, end - 0.004, end + 0.004), (0.0040, end + 0.004, end + 0.009), (0.0030, end + 0.009, end + 0.014)]
    visuals = (
        Visual(mesh_shape("wedge", _wedge(CRADLE[1], 0.0)), BASE),
        Visual(mesh_shape("cheeks", merge(seen)), BASE),
        Visual(mesh_shape("bed", bed), (0.30, 0.32, 0.36)),
        Visual(mesh_shape("pins", merge(pins)), BRASS),
        Visual(mesh_shape("light", light), shining((0.25, 0.85, 0.35))),
        Visual(mesh_shape("cord", merge(rod((a, 0.0, 0.0055), (b, 0.0, 0.0055), radius, 12) for radius, a, b in relief)), DARK),
    )
    shapes = (mesh_shape("wedge_hull", _wedge(CRADLE[1], SKIN)), *cheeks, stop)
    middle = _on_bed(HANDSET[0] / 2.0, HANDSET[2] / 2.0)
    notes = (
        f"trough along x, {2 * inner:.3f} wide, rising towards +x by {SLOPE} rad from x = {FOOT[0]}, z = {FOOT[1]}",
        f"a handset that lies in it has its origin at ({middle[0]:.4f}, 0, {middle[2]:.4f}), pitched by -{SLOPE} rad",
    )
    link = Link("phone_cradle", 0.4, visuals, shapes, friction=0.4)
    return Model("phone_cradle", "objects/phone_cradle", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_handset(), _cradle())
