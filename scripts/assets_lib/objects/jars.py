"""A hollow jar with a neck, and its lid; no thread is simulated."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, lathe, merge
from assets_lib.objects.saucepan import wall_boxes
from assets_lib.urdf import Joint, Link, Model, Visual, cylinder_shape, glass, mesh_shape, metal

RADIUS, HEIGHT, FLOOR, WALL = 0.0375, 0.10, 0.006, 0.005
"""Of the belly; the rim of the neck is at `HEIGHT` above the foot [m]."""
NECK, MOUTH, SHOULDER, NECK_START = 0.025, 0.020, 0.064, 0.078
"""Outer and inner radius of the neck; heights where the belly ends and the neck begins [m]."""
LID_RADIUS, LID_HEIGHT, LID_WALL, LID_ROOF = 0.030, 0.02, 0.003, 0.005
SEGMENTS, LID_SEGMENTS = 16, 12
SEATED = HEIGHT / 2.0 - (LID_HEIGHT / 2.0 - LID_ROOF)
"""Height of the lid's origin, its middle, in the frame of a jar that it closes [m]."""
CLAY, PAPER, SHADE = glass((0.85, 0.20, 0.15)), (0.93, 0.90, 0.80), (0.20, 0.16, 0.13)
GRAY, DARK = metal((0.50, 0.51, 0.53)), (0.27, 0.28, 0.30)


def _pot() -> Mesh:
    """Return the outside of the jar up to its neck; the origin is the middle of its height."""
    foot = [(0.0, 0.0), (RADIUS - 0.004, 0.0), (RADIUS, 0.004), (RADIUS, SHOULDER), (RADIUS - 0.004, SHOULDER + 0.008)]
    return lathe([*foot, (NECK - 0.001, NECK_START)], 24).moved((0.0, 0.0, -HEIGHT / 2.0))


def _neck() -> Mesh:
    """Return the outside of the neck with two rings of thread, and the rim."""
    outline = [(NECK - 0.001, NECK_START)]
    for k in range(2):
        z = NECK_START + 0.006 + 0.007 * k
        outline += [(NECK - 0.001, z), (NECK, z + 0.002), (NECK - 0.001, z + 0.004)]
    outline += [(NECK - 0.001, HEIGHT - 0.001), (NECK - 0.002, HEIGHT), (MOUTH, HEIGHT)]
    return lathe(outline, 20).moved((0.0, 0.0, -HEIGHT / 2.0))


def _hollow() -> Mesh:
    """Return the wall of the hollow, a skin of 1 mm."""
    inner, skin = RADIUS - WALL, 0.001
    seen = [(MOUTH, HEIGHT), (MOUTH, NECK_START - 0.002), (inner, SHOULDER), (inner, FLOOR), (0.0, FLOOR)]
    back = [(0.0, FLOOR - skin), *((radius + skin, z) for radius, z in reversed(seen[:-1]))]
    return lathe([*seen, *back, seen[0]], 16).moved((0.0, 0.0, -HEIGHT / 2.0))


def _label() -> Mesh:
    """Return a band of paper around the belly."""
    return lathe([(RADIUS - 0.001, 0.022), (RADIUS + 0.0006, 0.022), (RADIUS + 0.0006, 0.034), (RADIUS - 0.001, 0.034)], 24)


def _jar() -> Model:
    low = -HEIGHT / 2.0
    visuals = (Visual(mesh_shape("pot", _pot()), CLAY), Visual(mesh_shape("neck", _neck()), CLAY))
    trim = (
        Visual(mesh_shape("label", _label().moved((0.0, 0.0, low))), PAPER),
        Visual(mesh_shape("hollow", _hollow()), SHADE),
    )
    shapes = (
        cylinder_shape(RADIUS - 0.001, FLOOR, (0.0, 0.0, low + FLOOR / 2.0)),
        *wall_boxes(RADIUS, low + SHOULDER + 0.004, WALL, low + FLOOR, SEGMENTS),
        *wall_boxes(RADIUS - 0.004, low + NECK_START - 0.003, 0.012, low + SHOULDER + 0.004, SEGMENTS),
        *wall_boxes(NECK, low + HEIGHT, NECK - MOUTH, low + NECK_START - 0.003, SEGMENTS),
    )
    links = (Link("jar", 0.35, visuals, shapes, friction=0.6), Link("trim", 0.002, trim))
    joint = Joint("glue", "fixed", "jar", "trim", (0.0, 0.0, 0.0))
    notes = (
        f"hollow; belly of diameter {2 * RADIUS}, neck of diameter {2 * NECK} from {NECK_START - HEIGHT / 2.0:.3f} to the rim at "
        f"z = {HEIGHT / 2.0}, mouth of diameter {2 * MOUTH}",
        f"a `jar_lid` that closes it has its origin at z = {SEATED:.3f}",
        "recolour the link `jar` alone",
    )
    return Model("jar", "objects/jar", "middle of its height, on the axis", links, (joint,), notes)


def _cover() -> Mesh:
    """Return the hollow lid."""
    top, inner = LID_HEIGHT / 2.0, LID_RADIUS - LID_WALL
    roof = top - LID_ROOF
    inside = [(0.0, roof), (inner, roof), (inner, -top)]
    outside = [(LID_RADIUS - 0.001, -top), (LID_RADIUS, -top + 0.001), (LID_RADIUS, top - 0.003), (LID_RADIUS - 0.003, top)]
    return lathe([*inside, *outside, (0.0, top)], 24)


def _marks() -> Mesh:
    """Return a bar on the lid and ribs around it, so that turning is seen."""
    bar = box((0.040, 0.006, 0.001), (0.0, 0.0, LID_HEIGHT / 2.0 + 0.0003))
    rib = box((0.0012, 0.003, 0.013), (LID_RADIUS - 0.0002, 0.0, -0.001))
    return merge([bar, *(rib.moved(rpy=(0.0, 0.0, np.pi * k / 6.0)) for k in range(12))])


def _lid() -> Model:
    top = LID_HEIGHT / 2.0
    roof = top - LID_ROOF
    walls = wall_boxes(LID_RADIUS, roof, LID_WALL, -top, LID_SEGMENTS)
    shapes = (cylinder_shape(LID_RADIUS, LID_ROOF, (0.0, 0.0, top - LID_ROOF / 2.0)), *walls)
    visuals = (Visual(mesh_shape("lid", _cover()), GRAY), Visual(mesh_shape("marks", _marks()), DARK))
    link = Link("lid", 0.05, visuals, shapes, friction=0.8)
    notes = (
        f"hollow from below: diameter {2 * LID_RADIUS}, height {LID_HEIGHT}, inside {2 * (LID_RADIUS - LID_WALL):.3f} wide and "
        f"{LID_HEIGHT - LID_ROOF} deep",
    )
    return Model("jar_lid", "objects/jar_lid", "middle", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_jar(), _lid())
