"""The hot-wire game: a rod between two posts, and a wand with a ring around the rod."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, cylinder, lathe, merge, rod
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape, metal, shining

PLATE, POST_TALL = (0.36, 0.08, 0.02), 0.15
ROD_RADIUS, ROD_LENGTH = 0.004, 0.28
ROD_HEIGHT = 0.155
"""Height of the rod's axis [m]."""
RING_INNER, RING_OUTER, RING_THICK, SEGMENTS = 0.025, 0.032, 0.01, 12
GRIP = (0.02, 0.10, 0.02)
GRIP_START = 0.030
"""Where the grip bar begins, from the middle of the ring along -y [m]."""
CRADLE_X = -0.12
FREE = 0.04
"""How long the ends of the rod are that may be touched [m]."""
RED, DARK, GREEN, COPPER = (0.80, 0.12, 0.10), (0.14, 0.14, 0.16), (0.10, 0.62, 0.24), metal((0.86, 0.48, 0.26))
OFF, ON = (0.30, 0.30, 0.32), (0.15, 0.95, 0.25)


def _dome() -> list[tuple[float, float]]:
    """Return the outline of the lamp: a dome on a ring."""
    angles = np.linspace(0.0, np.pi / 2.0, 7)[:-1]
    dome = [(0.012 * float(np.cos(a)), 0.006 + 0.014 * float(np.sin(a))) for a in angles]
    return [(0.0, 0.0), (0.014, 0.0), (0.014, 0.005), *dome, (0.0, 0.020)]


def _base() -> Model:
    x, y, z = PLATE
    post_x, bar_z = ROD_LENGTH / 2.0 + 0.005, ROD_HEIGHT - GRIP[2] / 2.0
    posts = tuple(box_shape((0.012, 0.03, POST_TALL), (s * post_x, 0.0, z + POST_TALL / 2.0)) for s in (-1.0, 1.0))
    wire = cylinder_shape(ROD_RADIUS, ROD_LENGTH, (0.0, 0.0, ROD_HEIGHT), (0.0, float(np.pi / 2.0), 0.0))
    props = tuple(box_shape((0.02, 0.012, bar_z), (CRADLE_X, v, bar_z / 2.0)) for v in (-0.055, -0.12))
    beam = box_shape((0.024, 0.085, z), (CRADLE_X, -0.0825, z / 2.0))
    stripes = merge(box((0.03, y - 0.002, 0.0006), (0.06 * i, 0.0, z + 0.0003)) for i in range(-2, 3))
    solid_lamp = cylinder(0.013, 0.020, 16, bevel=0.005).moved((post_x, 0.0, z + POST_TALL + 0.010))
    lamp = lathe(_dome(), 20).moved((post_x, 0.0, z + POST_TALL))
    inner = ROD_LENGTH / 2.0 - FREE
    sleeves = [rod((s * inner, 0.0, ROD_HEIGHT), (s * post_x, 0.0, ROD_HEIGHT), ROD_RADIUS + 0.0008, 12) for s in (-1.0, 1.0)]
    visuals = (
        Visual(mesh_shape("plate", merge([box(PLATE, (0.0, 0.0, z / 2.0)), beam.mesh()])), (0.93, 0.78, 0.16), crease=0.1),
        Visual(mesh_shape("stripes", stripes), DARK),
        Visual(mesh_shape("posts", merge(shape.mesh() for shape in posts)), (0.20, 0.36, 0.68), crease=0.1),
        Visual(mesh_shape("wire", rod((-post_x, 0.0, ROD_HEIGHT), (post_x, 0.0, ROD_HEIGHT), ROD_RADIUS, 12)), COPPER),
        Visual(mesh_shape("props", merge(shape.mesh() for shape in props)), (0.20, 0.36, 0.68), crease=0.1),
        Visual(mesh_shape("start", sleeves[0]), (0.92, 0.92, 0.90)),
        Visual(mesh_shape("finish", sleeves[1]), GREEN),
    )
    shapes: tuple[Shape, ...] = (box_shape(PLATE, (0.0, 0.0, z / 2.0)), *posts, wire, beam, *props)
    notes = (
        f"rod along x at z = {ROD_HEIGHT}, diameter {2 * ROD_RADIUS}, from x = {-ROD_LENGTH / 2.0} to {ROD_LENGTH / 2.0}",
        f"the ends of {FREE} that may be touched have sleeves, white at the start and green at the end",
        f"link `lamp` is on the post at the end; coloured {ON} it shines",
        f"the grip of `buzz_wand` rests on two props with the wand at ({CRADLE_X}, 0, {ROD_HEIGHT})",
    )
    links = (
        Link("buzz_base", 2.0, visuals, shapes, friction=0.4),
        Link(
            "lamp",
            0.001,
            (Visual(mesh_shape("lamp", lamp), shining(OFF, emission=ON), crease=0.6),),
            weighs=(mesh_shape("lamp", solid_lamp),),
        ),
    )
    holder = Joint("lamp_holder", "fixed", "buzz_base", "lamp", (0.0, 0.0, 0.0))
    return Model("buzz_base", "objects/buzz_base", "bottom centre", links, (holder,), notes)


def _ring_mesh() -> Mesh:
    """Return the ring around the x axis."""
    h = RING_THICK / 2.0
    turned = lathe([(RING_OUTER, -h), (RING_OUTER, h), (RING_INNER, h), (RING_INNER, -h), (RING_OUTER, -h)], 28)
    return turned.moved(rpy=(0.0, float(np.pi / 2.0), 0.0))


def _ring_shapes() -> tuple[Shape, ...]:
    middle, tall = (RING_INNER + RING_OUTER) / 2.0, RING_OUTER - RING_INNER
    width = 2.0 * RING_OUTER * float(np.tan(np.pi / SEGMENTS))
    shapes = []
    for i in range(SEGMENTS):
        a = 2.0 * float(np.pi) * i / SEGMENTS
        place = (0.0, middle * float(np.cos(a)), middle * float(np.sin(a)))
        shapes.append(box_shape((RING_THICK, tall, width), place, (a, 0.0, 0.0)))
    return tuple(shapes)


def _wand() -> Model:
    middle = (0.0, -GRIP_START - GRIP[1] / 2.0, 0.0)
    rings = merge(box((GRIP[0] + 0.0016, 0.004, GRIP[2] + 0.0016), (0.0, -GRIP_START - v, 0.0)) for v in (0.012, 0.088))
    visuals = (
        Visual(mesh_shape("ring", _ring_mesh()), (0.85, 0.66, 0.20)),
        Visual(mesh_shape("grip", box(GRIP, middle)), RED, crease=0.1),
        Visual(mesh_shape("bands", rings), DARK, crease=0.1),
    )
    link = Link("buzz_wand", 0.08, visuals, (*_ring_shapes(), box_shape(GRIP, middle)), friction=0.8)
    notes = (
        f"ring around x, inner diameter {2 * RING_INNER}, outer {2 * RING_OUTER}, {RING_THICK} thick",
        f"grip bar along -y, {GRIP[0]} x {GRIP[2]}, from y = {-GRIP_START} to {-GRIP_START - GRIP[1]}",
    )
    return Model("buzz_wand", "objects/buzz_wand", "middle of the ring", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_base(), _wand())
