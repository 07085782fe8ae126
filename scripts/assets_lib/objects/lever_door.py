"""A toy door in its frame, with a lever handle on both sides."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from assets_lib.cabinets import bevelled_box
from assets_lib.mesh import Mesh, box, cylinder, hull_of, merge, rod
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape, metal, plastic

OPENING = (0.34, 0.50)
"""Width and height of the opening of the frame [m]."""
POST = (0.06, 0.04)
"""Depth and width of posts and lintel [m]."""
LEAF = (0.025, 0.33, 0.49)
FOOT = (0.22, 0.06, 0.02)
HINGE = (LEAF[0] / 2.0, LEAF[1] / 2.0, 0.25)
"""On the back edge of the leaf at half its height [m]."""
PIVOT = (-LEAF[0] / 2.0, -LEAF[1] + 0.05, 0.0)
"""Of the lever, in the leaf's frame [m]."""
REACH, STANDOFF, RADIUS = 0.10, 0.05, 0.007
"""Length of a lever, distance of its middle line from the leaf, radius [m]."""
FIELD = (0.007, 0.018)
"""How far the fields of the leaf stand out, and how wide the slope around them is [m]."""
SWING, SHORT_SWING = 1.2, 0.9
"""How far the leaf opens, and how far where a stop on the table holds it [rad]."""
STOP = (0.012, 0.03, 0.28)
"""Radius and height of the stop, and how far from the hinge the leaf meets it [m]."""
FRAME_COLOR, LEAF_COLOR, PANEL = (0.93, 0.92, 0.88), plastic((0.16, 0.42, 0.52)), plastic((0.20, 0.49, 0.59))
BRASS, DARK = metal((0.85, 0.68, 0.25)), (0.2, 0.2, 0.2)

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _frame() -> tuple[Box, ...]:
    """Return the boxes (size, centre) of posts, lintel and feet."""
    width, height = OPENING
    y = (width + POST[1]) / 2.0
    posts = [((POST[0], POST[1], height), (0.0, side * y, height / 2.0)) for side in (-1, 1)]
    feet = [(FOOT, (0.0, side * (y + 0.01), FOOT[2] / 2.0)) for side in (-1, 1)]
    return (*posts, *feet, ((POST[0], width + 2 * POST[1], POST[1]), (0.0, 0.0, height + POST[1] / 2.0)))


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _panels() -> Mesh:
    """Return two fields on each side of the leaf; the leaf's origin is on the hinge."""
    x, y, wide = -LEAF[0] / 2.0, -LEAF[1] / 2.0 + 0.01, 0.17
    return merge(_field((wide, tall), side).moved((x, y, z)) for z, tall in ((0.125, 0.17), (-0.105, 0.21)) for side in (-1, 1))


def _field(size: tuple[float, float], side: int) -> Mesh:
    """Return a raised field of a size along y and z on one side of the leaf: its edge rises in a step and a slope."""
    foot, step, top = (LEAF[0] / 2.0 + height for height in (-0.001, 0.002, FIELD[0]))
    inset = FIELD[1]
    levels = ((0.0, foot), (0.0, step), (inset, top))
    corners = [
        (side * x, sy * (size[0] / 2.0 - inwards), sz * (size[1] / 2.0 - inwards))
        for inwards, x in levels
        for sy in (-1, 1)
        for sz in (-1, 1)
    ]
    return hull_of(np.round(np.array(corners), 6))


def _plates() -> Mesh:
    """Return the plates behind the levers, with keyholes left to the eye."""
    return bevelled_box((LEAF[0] + 0.006, 0.032, 0.11), (-LEAF[0] / 2.0, PIVOT[1], -0.015), 0.002)


def _hinges() -> Mesh:
    return merge(cylinder(0.006, 0.05, 10).moved((0.0, 0.0, z)) for z in (-0.17, 0.17))


def _lever_mesh() -> Mesh:
    """Return both levers; the origin is on the pivot at half the thickness of the leaf."""
    x = LEAF[0] / 2.0 + STANDOFF
    spindle = rod((-x - RADIUS, 0.0, 0.0), (x + RADIUS, 0.0, 0.0), 0.008, 12)
    return merge([spindle, *(rod((side * x, 0.0, 0.0), (side * x, REACH, 0.0), RADIUS, 12) for side in (-1, 1))])


def _lever_shapes() -> tuple[Shape, ...]:
    x, half_pi = LEAF[0] / 2.0 + STANDOFF, 1.57079633
    bars = tuple(
        cylinder_shape(RADIUS, REACH + RADIUS, (s * x, (REACH - RADIUS) / 2.0, 0.0), (half_pi, 0.0, 0.0)) for s in (-1, 1)
    )
    length = STANDOFF - 0.003
    middle = LEAF[0] / 2.0 + 0.003 + length / 2.0
    posts = tuple(cylinder_shape(0.008, length, (s * middle, 0.0, 0.0), (0.0, half_pi, 0.0)) for s in (-1, 1))
    return (*bars, *posts)


def _stop() -> Shape:
    """Return the stop: it touches the back of the leaf that is open by `SHORT_SWING`."""
    radius, height, along = STOP
    sine, cosine = math.sin(SHORT_SWING), math.cos(SHORT_SWING)
    x, y = HINGE[0] + along * sine + radius * cosine, HINGE[1] - along * cosine + radius * sine
    return cylinder_shape(radius, height, (x, y, height / 2.0))


def _frame_link() -> Link:
    boxes = _frame()
    visuals = (Visual(mesh_shape("frame", _merged(boxes)), FRAME_COLOR),)
    return Link("frame", 8.0, visuals, tuple(box_shape(s, c) for s, c in boxes))


def _leaf_link() -> Link:
    middle = (-LEAF[0] / 2.0, -LEAF[1] / 2.0, 0.0)
    visuals = (
        Visual(mesh_shape("leaf", box(LEAF, middle)), LEAF_COLOR),
        Visual(mesh_shape("panels", _panels()), PANEL, crease=0.1),
        Visual(mesh_shape("plates", _plates()), BRASS),
        Visual(mesh_shape("hinges", _hinges()), DARK),
    )
    return Link("leaf", 1.2, visuals, (box_shape(LEAF, middle),))


def _swing(upper: float) -> Joint:
    """Return the hinge of a leaf that opens up to an angle [rad]."""
    return Joint("leaf_hinge", "revolute", "frame", "leaf", HINGE, (0.0, 0.0, 1.0), 0.0, upper, damping=0.05)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    frame, leaf, stop = _frame_link(), _leaf_link(), _stop()
    lever = Link(
        "lever_link", 0.1, (Visual(mesh_shape("lever", _lever_mesh()), (0.95, 0.80, 0.35)),), _lever_shapes(), friction=1.0
    )
    turn = Joint("lever", "revolute", "leaf", "lever_link", PIVOT, (-1.0, 0.0, 0.0), 0.0, 0.8, damping=0.01)
    notes = (
        f"stands across x; opening {OPENING[0]} wide, {OPENING[1]} high; the leaf hangs at +y and opens towards +x, away from -x",
        f"link `leaf` has its origin on the hinge at half height {tuple(round(v, 4) for v in HINGE)}; shut, it spans "
        f"x -{LEAF[0]}..0, y -{LEAF[1]}..0, z -0.245..0.245 there",
        f"link `lever_link` has its origin on the pivot inside the leaf, {tuple(round(v, 4) for v in PIVOT)} in `leaf`; "
        f"the levers are bars of diameter {2 * RADIUS} from y 0 to {REACH} at x = -+{LEAF[0] / 2.0 + STANDOFF:.4f}; "
        f"{STANDOFF - RADIUS:.3f} m free behind them; the joint `lever` grows when they go down",
    )
    stopped = replace(
        frame, visuals=(*frame.visuals, Visual(mesh_shape("stop", stop.mesh()), DARK)), collisions=(*frame.collisions, stop)
    )
    stops = (f"as lever_door, but a stop on the table behind it holds the leaf at {SHORT_SWING} rad",)
    origin = "bottom centre of the leaf's opening"
    return (
        Model("lever_door", "objects/lever_door", origin, (frame, leaf, lever), (_swing(SWING), turn), notes),
        Model("lever_door_with_stop", "objects/lever_door", origin, (stopped, leaf, lever), (_swing(SHORT_SWING), turn), stops),
    )
