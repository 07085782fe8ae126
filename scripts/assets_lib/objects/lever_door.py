"""Toy doors in their frames, with a lever handle on both sides: one with panels, and a taller one of oak with a window."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from assets_lib.cabinets import bevelled_box
from assets_lib.mesh import Mesh, box, cylinder, hull_of, merge, rod
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
    Paint,
    Shape,
    Visual,
    box_shape,
    cylinder_shape,
    mesh_shape,
    metal,
    pane,
    patterned,
    plastic,
)

OPENING = 0.34
"""Width of the opening of the frame [m]."""
POST = (0.06, 0.04)
"""Depth and width of posts and lintel [m]."""
THICK, WIDE = 0.025, 0.33
"""Of the leaf [m]."""
FOOT = (0.22, 0.06, 0.02)
LEVER = (0.05, 0.25)
"""How far the pivot of the lever is from the free edge of the leaf, and its height over the table [m]."""
REACH, STANDOFF, RADIUS = 0.10, 0.05, 0.007
"""Length of a lever, distance of its middle line from the leaf, radius [m]."""
FIELD = (0.007, 0.018)
"""How far the fields of the leaf stand out, and how wide the slope around them is [m]."""
STILE, WINDOW = 0.075, (-0.03, 0.215)
"""Width of the boards beside the window of a glazed leaf, and lowest and highest z of the window in the leaf's frame [m]."""
SWING, SHORT_SWING = 1.2, 0.9
"""How far the leaf opens, and how far where a stop on the table holds it [rad]."""
STOP = (0.012, 0.03, 0.28)
"""Radius and height of the stop, and how far from the hinge the leaf meets it [m]."""
FRAME_COLOR, LEAF_COLOR, PANEL = (0.93, 0.92, 0.88), plastic((0.16, 0.42, 0.52)), plastic((0.20, 0.49, 0.59))
BRASS, DARK = metal((0.85, 0.68, 0.25)), (0.2, 0.2, 0.2)

Vec3 = tuple[float, float, float]
Box = tuple[Vec3, Vec3]


@dataclass(frozen=True)
class Design:
    """How one door differs from another; the defaults are those of `lever_door`. Lengths [m]."""

    name: str = "lever_door"
    height: float = 0.50
    """Of the opening of the frame."""
    glazed: bool = False
    """Whether the leaf has a window above, and round plates behind its levers."""
    frame: Vec3 | Paint = FRAME_COLOR
    leaf: Paint = LEAF_COLOR
    panel: Paint = PANEL
    plate: Paint = BRASS
    lever: Vec3 | Paint = (0.95, 0.80, 0.35)

    @property
    def leaf_size(self) -> Vec3:
        """Size of the leaf."""
        return (THICK, WIDE, self.height - 0.01)

    @property
    def hinge(self) -> Vec3:
        """On the back edge of the leaf at half its height."""
        return (THICK / 2.0, WIDE / 2.0, self.height / 2.0)

    @property
    def pivot(self) -> Vec3:
        """Of the lever, in the leaf's frame."""
        return (-THICK / 2.0, -WIDE + LEVER[0], LEVER[1] - self.height / 2.0)


def _frame(design: Design) -> tuple[Box, ...]:
    """Return the boxes (size, centre) of posts, lintel and feet."""
    width, height = OPENING, design.height
    y = (width + POST[1]) / 2.0
    posts = [((POST[0], POST[1], height), (0.0, side * y, height / 2.0)) for side in (-1, 1)]
    feet = [(FOOT, (0.0, side * (y + 0.01), FOOT[2] / 2.0)) for side in (-1, 1)]
    return (*posts, *feet, ((POST[0], width + 2 * POST[1], POST[1]), (0.0, 0.0, height + POST[1] / 2.0)))


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _panels() -> Mesh:
    """Return two fields on each side of the leaf; the leaf's origin is on the hinge."""
    x, y, wide = -THICK / 2.0, -WIDE / 2.0 + 0.01, 0.17
    return merge(_field((wide, tall), side).moved((x, y, z)) for z, tall in ((0.125, 0.17), (-0.105, 0.21)) for side in (-1, 1))


def _field(size: tuple[float, float], side: int) -> Mesh:
    """Return a raised field of a size along y and z on one side of the leaf: its edge rises in a step and a slope."""
    foot, step, top = (THICK / 2.0 + height for height in (-0.001, 0.002, FIELD[0]))
    inset = FIELD[1]
    levels = ((0.0, foot), (0.0, step), (inset, top))
    corners = [
        (side * x, sy * (size[0] / 2.0 - inwards), sz * (size[1] / 2.0 - inwards))
        for inwards, x in levels
        for sy in (-1, 1)
        for sz in (-1, 1)
    ]
    return hull_of(np.round(np.array(corners), 6))


def _boards(design: Design) -> tuple[Box, ...]:
    """Return the boards around the window of a glazed leaf, and the bars across it; the leaf's origin is on the hinge."""
    x, (low, high), half = -THICK / 2.0, WINDOW, design.leaf_size[2] / 2.0
    inner, middle = WIDE - 2 * STILE, -WIDE / 2.0
    boards = [((THICK, STILE, 2 * half), (x, y, 0.0)) for y in (-STILE / 2.0, STILE / 2.0 - WIDE)]
    boards += [((THICK, inner, up - down), (x, middle, (up + down) / 2.0)) for down, up in ((-half, low), (high, half))]
    bars = [
        ((0.014, 0.008, high - low), (x, middle, (low + high) / 2.0)),
        ((0.014, inner, 0.008), (x, middle, (low + high) / 2.0)),
    ]
    return (*boards, *bars)


def _pane() -> Mesh:
    """Return the glass of a window."""
    low, high = WINDOW
    return box((0.004, WIDE - 2 * STILE, high - low), (-THICK / 2.0, -WIDE / 2.0, (low + high) / 2.0))


def _low_panels(design: Design) -> Mesh:
    """Return the field below the window, on each side of the leaf."""
    half = design.leaf_size[2] / 2.0
    tall = WINDOW[0] + half - 0.10
    return merge(
        _field((WIDE - 2 * STILE, tall), side).moved((-THICK / 2.0, -WIDE / 2.0, tall / 2.0 + 0.05 - half)) for side in (-1, 1)
    )


def _plates(design: Design) -> Mesh:
    """Return the plates behind the levers, with keyholes left to the eye."""
    x, y, z = design.pivot
    if design.glazed:
        return cylinder(0.021, THICK + 0.006, 24, bevel=0.001).moved((x, y, z), (0.0, 1.57079633, 0.0))
    return bevelled_box((THICK + 0.006, 0.032, 0.11), (x, y, z - 0.015), 0.002)


def _hinges(design: Design) -> Mesh:
    shift = design.height / 2.0 - 0.08
    return merge(cylinder(0.006, 0.05, 10).moved((0.0, 0.0, z)) for z in (-shift, shift))


def _lever_mesh() -> Mesh:
    """Return both levers; the origin is on the pivot at half the thickness of the leaf."""
    x = THICK / 2.0 + STANDOFF
    spindle = rod((-x - RADIUS, 0.0, 0.0), (x + RADIUS, 0.0, 0.0), 0.008, 12)
    return merge([spindle, *(rod((side * x, 0.0, 0.0), (side * x, REACH, 0.0), RADIUS, 12) for side in (-1, 1))])


def _lever_shapes() -> tuple[Shape, ...]:
    x, half_pi = THICK / 2.0 + STANDOFF, 1.57079633
    bars = tuple(
        cylinder_shape(RADIUS, REACH + RADIUS, (s * x, (REACH - RADIUS) / 2.0, 0.0), (half_pi, 0.0, 0.0)) for s in (-1, 1)
    )
    length = STANDOFF - 0.003
    middle = THICK / 2.0 + 0.003 + length / 2.0
    posts = tuple(cylinder_shape(0.008, length, (s * middle, 0.0, 0.0), (0.0, half_pi, 0.0)) for s in (-1, 1))
    return (*bars, *posts)


def _stop() -> Shape:
    """Return the stop: it touches the back of the leaf that is open by `SHORT_SWING`."""
    radius, height, along = STOP
    sine, cosine = math.sin(SHORT_SWING), math.cos(SHORT_SWING)
    x, y = THICK / 2.0 + along * sine + radius * cosine, WIDE / 2.0 - along * cosine + radius * sine
    return cylinder_shape(radius, height, (x, y, height / 2.0))


def _frame_link(design: Design) -> Link:
    boxes = _frame(design)
    visuals = (Visual(mesh_shape("frame", _merged(boxes)), design.frame),)
    return Link("frame", 8.0, visuals, tuple(box_shape(s, c) for s, c in boxes))


def _leaf_link(design: Design) -> Link:
    size, middle = design.leaf_size, (-THICK / 2.0, -WIDE / 2.0, 0.0)
    leaf, fields, panes = box(size, middle), _panels, []
    if design.glazed:
        leaf, fields = _merged(_boards(design)), lambda: _low_panels(design)
        panes = [Visual(mesh_shape("pane", _pane()), pane((0.72, 0.84, 0.88)))]
    visuals = (
        Visual(mesh_shape("leaf", leaf), design.leaf),
        Visual(mesh_shape("panels", fields()), design.panel, crease=0.1),
        Visual(mesh_shape("plates", _plates(design)), design.plate),
        Visual(mesh_shape("hinges", _hinges(design)), DARK),
        *panes,
    )
    return Link("leaf", 1.2, visuals, (box_shape(size, middle),))


def _lever_link(design: Design) -> Link:
    visual = Visual(mesh_shape("lever", _lever_mesh()), design.lever)
    return Link("lever_link", 0.1, (visual,), _lever_shapes(), friction=1.0)


def _joints(design: Design, upper: float) -> tuple[Joint, ...]:
    """Return the hinge of a leaf that opens up to an angle [rad], and the pivot of its lever."""
    return (
        Joint("leaf_hinge", "revolute", "frame", "leaf", design.hinge, (0.0, 0.0, 1.0), 0.0, upper, damping=0.05),
        Joint("lever", "revolute", "leaf", "lever_link", design.pivot, (-1.0, 0.0, 0.0), 0.0, 0.8, damping=0.01),
    )


def _notes(design: Design) -> tuple[str, ...]:
    half = design.leaf_size[2] / 2.0
    return (
        f"stands across x; opening {OPENING} wide, {design.height} high; the leaf hangs at +y and opens towards +x, away from -x",
        f"link `leaf` has its origin on the hinge at half height {tuple(round(v, 4) for v in design.hinge)}; closed, it spans "
        f"x -{THICK}..0, y -{WIDE}..0, z -{half}..{half} there",
        f"link `lever_link` has its origin on the pivot inside the leaf, {tuple(round(v, 4) for v in design.pivot)} in `leaf`; "
        f"the levers are bars of diameter {2 * RADIUS} from y 0 to {REACH} at x = -+{THICK / 2.0 + STANDOFF:.4f}; "
        f"{STANDOFF - RADIUS:.3f} m free behind them; the joint `lever` grows when they go down",
    )


DOOR = Design()
GLAZED = Design(
    "glazed_door",
    height=0.58,
    glazed=True,
    frame=(0.34, 0.36, 0.38),
    leaf=patterned(plastic((0.72, 0.50, 0.29)), "wood"),
    panel=patterned(plastic((0.66, 0.45, 0.25)), "wood"),
    plate=metal((0.72, 0.73, 0.76)),
    lever=metal((0.72, 0.73, 0.76)),
)


def _links(design: Design) -> tuple[Link, ...]:
    return (_frame_link(design), _leaf_link(design), _lever_link(design))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    (frame, *others), stop = _links(DOOR), _stop()
    stopped = replace(
        frame, visuals=(*frame.visuals, Visual(mesh_shape("stop", stop.mesh()), DARK)), collisions=(*frame.collisions, stop)
    )
    stops = (f"as lever_door, but a stop on the table behind it holds the leaf at {SHORT_SWING} rad",)
    origin = "bottom centre of the leaf's opening"
    return (
        Model("lever_door", "objects/lever_door", origin, (frame, *others), _joints(DOOR, SWING), _notes(DOOR)),
        Model("lever_door_with_stop", "objects/lever_door", origin, (stopped, *others), _joints(DOOR, SHORT_SWING), stops),
        Model(GLAZED.name, f"objects/{GLAZED.name}", origin, _links(GLAZED), _joints(GLAZED, SWING), _notes(GLAZED)),
    )
