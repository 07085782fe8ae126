"""Microwave ovens with a door on the left edge: a silver one, and a wider, lower one in cream with two dials."""

from __future__ import annotations

from dataclasses import dataclass

from assets_lib.cabinets import bevelled, bevelled_box, cabinet
from assets_lib.mesh import Mesh, box, cylinder, merge, rod
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
    plastic,
    shining,
)

DEPTH, FOOT = 0.28, 0.01
THICK, GAP = 0.018, 0.0015
"""Of the door, and between it and the body [m]."""
FRONT = -DEPTH / 2.0 + THICK + GAP
"""x of the front of the body behind the door [m]."""
WALL = 0.012
HANDLE = (-0.018 - 0.042, 0.025)
"""x of the handle bar in the door frame, and how far it is from the free edge [m]."""
BAR_RADIUS = 0.006
SHELL, BLACK, GLASS = plastic((0.80, 0.81, 0.82)), (0.10, 0.10, 0.11), pane((0.12, 0.15, 0.17), 0.55)
STEEL = metal((0.85, 0.86, 0.88))

Vec3 = tuple[float, float, float]
Box = tuple[Vec3, Vec3]
Span = tuple[float, float]


@dataclass(frozen=True)
class Design:
    """How one microwave oven differs from another; the defaults are those of `microwave`. Lengths [m]."""

    name: str = "microwave"
    width: float = 0.38
    height: float = 0.24
    door_width: float = 0.28
    bar: float = 0.15
    """Length of the handle bar."""
    plate: float = 0.105
    """Radius of the turntable."""
    dials: bool = False
    """Whether two dials take the place of keys, display and badge."""
    shell: Paint = SHELL
    front: Vec3 | Paint = BLACK
    rim: Vec3 = (0.32, 0.33, 0.35)
    handle: Paint = STEEL

    @property
    def door(self) -> Vec3:
        """Size of the door."""
        return (THICK, self.door_width, round(self.height - 0.02, 6))

    @property
    def panel(self) -> float:
        """Width of the panel beside the door."""
        return self.width - self.door_width - GAP

    @property
    def side(self) -> float:
        """Y of the middle of that panel."""
        return -self.width / 2.0 + self.panel / 2.0

    @property
    def hinge(self) -> Vec3:
        """Where the door turns, at half its height."""
        return (FRONT - GAP, self.width / 2.0, (FOOT + self.height) / 2.0)

    @property
    def grip(self) -> Span:
        """x, y of the handle bar in the door frame."""
        return (HANDLE[0], round(HANDLE[1] - self.door_width, 6))

    @property
    def middle(self) -> float:
        """Y of the middle of the hollow."""
        return round((self.width / 2.0 - WALL - self.width / 2.0 + self.panel) / 2.0, 3)


def _body(design: Design) -> tuple[Box, ...]:
    """Return the boxes (size, centre) of the shell around the hollow."""
    width, height = design.width, design.height
    depth, mid = DEPTH / 2.0 - FRONT, (DEPTH / 2.0 + FRONT) / 2.0
    z, tall = (FOOT + height) / 2.0, height - FOOT
    left, right = width / 2.0, -width / 2.0 + design.panel
    return (
        ((depth, width, WALL), (mid, 0.0, FOOT + WALL / 2.0)),
        ((depth, width, WALL), (mid, 0.0, height - WALL / 2.0)),
        ((depth, WALL, tall - 2 * WALL), (mid, left - WALL / 2.0, z)),
        ((WALL, left - WALL - right, tall - 2 * WALL), (DEPTH / 2.0 - WALL / 2.0, (left - WALL + right) / 2.0, z)),
        ((depth, design.panel, tall - 2 * WALL), (mid, right - design.panel / 2.0, z)),
    )


def _shell(design: Design) -> Mesh:
    """Return the shell around the hollow."""
    hollow = (FOOT + WALL, design.height - WALL)
    opening = (-design.width / 2.0 + design.panel, design.width / 2.0 - WALL)
    spans = ((FRONT, DEPTH / 2.0), (-design.width / 2.0, design.width / 2.0), (FOOT, design.height))
    return cabinet(*spans, opening, (hollow,), DEPTH / 2.0 - WALL - FRONT)


def _dial(design: Design) -> Mesh:
    """Return the knob for the time below the keys, or two large ones."""
    turn = (0.0, 1.57079633, 0.0)
    if design.dials:
        heights = (0.3 * design.height + 0.005, 0.7 * design.height + 0.005)
        knobs = [cylinder(0.026, 0.010, 24, bevel=0.003).moved((-DEPTH / 2.0 - 0.005, design.side, z), turn) for z in heights]
        grips = [bevelled_box((0.010, 0.008, 0.046), (-DEPTH / 2.0 - 0.014, design.side, z), 0.002) for z in heights]
        return merge([*knobs, *grips])
    return cylinder(0.016, 0.010, 20, bevel=0.002).moved((-DEPTH / 2.0 - 0.005, design.side, 0.038), turn)


def _rim(design: Design) -> Mesh:
    """Return the bright line around the window."""
    _, w, h = design.door
    x, y, z = -THICK - 0.0006, (-w + 0.058, -0.038), (-h / 2.0 + 0.038, h / 2.0 - 0.038)
    bars = [box((0.0012, y[1] - y[0], 0.002), (x, (y[0] + y[1]) / 2.0, at)) for at in z]
    return merge([*bars, *(box((0.0012, 0.002, z[1] - z[0]), (x, at, 0.0)) for at in y)])


def _control_panel(design: Design) -> Box:
    """Return the block beside the door, flush with it."""
    size = (THICK + GAP, design.panel, design.height - FOOT)
    return (size, (-DEPTH / 2.0 + size[0] / 2.0, design.side, (FOOT + design.height) / 2.0))


def _keys(design: Design) -> Mesh:
    """Return twelve keys of the control panel."""
    y = design.side
    places = [(y + dy, z) for dy in (-0.024, 0.0, 0.024) for z in (0.062, 0.086, 0.110, 0.134)]
    return merge(box((0.003, 0.017, 0.014), (-DEPTH / 2.0 - 0.0015, py, pz)) for py, pz in places)


def _feet(design: Design) -> Mesh:
    return _merged(_foot_boxes(design))


def _foot_boxes(design: Design) -> tuple[Box, ...]:
    side = round(design.width / 2.0 - 0.04, 6)
    return tuple(((0.03, 0.03, FOOT), (x, y, FOOT / 2.0)) for x in (-0.08, 0.1) for y in (-side, side))


def _vents(design: Design) -> Mesh:
    """Return the slots in the back and in both sides, and a label."""
    back, side = DEPTH / 2.0 + 0.0005, design.width / 2.0 + 0.0005
    slots = [box((0.001, 0.10, 0.006), (back, 0.09, 0.09 + 0.014 * i)) for i in range(8)]
    slots += [box((0.09, 0.001, 0.006), (0.06, y, 0.14 + 0.014 * i)) for y in (-side, side) for i in range(5)]
    return merge([*slots, box((0.001, 0.08, 0.05), (back, -0.09, 0.16))])


def _turntable(design: Design) -> Mesh:
    """Return the glass plate inside."""
    return cylinder(design.plate, 0.005, 24).moved((0.0, design.middle, FOOT + WALL + 0.0025))


def _frame(design: Design) -> tuple[Box, ...]:
    """Return the four bars of the door around its window; the origin is the hinge."""
    t, w, h = design.door
    border = 0.04
    y = -w / 2.0
    return (
        ((t, w, border), (-t / 2.0, y, (h - border) / 2.0)),
        ((t, w, border), (-t / 2.0, y, -(h - border) / 2.0)),
        ((t, border, h - 2 * border), (-t / 2.0, -border / 2.0, 0.0)),
        ((t, border + 0.02, h - 2 * border), (-t / 2.0, -w + (border + 0.02) / 2.0, 0.0)),
    )


def _window(design: Design) -> Box:
    t, w, h = design.door
    return ((0.008, w - 0.1, h - 0.08), (-t / 2.0, -w / 2.0 + 0.01, 0.0))


def _handle_mesh(design: Design) -> Mesh:
    (x, y), half = design.grip, design.bar / 2.0
    bar = rod((x, y, -half), (x, y, half), BAR_RADIUS, 10)
    return merge([bar, *(rod((x, y, z), (-THICK, y, z), 0.005, 8) for z in (0.015 - half, half - 0.015))])


def _handle_shapes(design: Design) -> tuple[Shape, ...]:
    (x, y), half = design.grip, design.bar / 2.0
    length = -x - THICK
    posts = (box_shape((length, 0.009, 0.009), (x + length / 2.0, y, z)) for z in (0.015 - half, half - 0.015))
    return (cylinder_shape(BAR_RADIUS, design.bar, (x, y, 0.0)), *posts)


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _controls(design: Design) -> tuple[Visual, ...]:
    """Return what is on the panel beside the door."""
    y, x = design.side, -DEPTH / 2.0
    dial = Visual(mesh_shape("dial", _dial(design)), design.handle)
    if design.dials:
        return (dial,)
    display = box((0.003, 0.068, 0.03), (x - 0.0015, y, 0.19))
    return (
        dial,
        Visual(mesh_shape("badge", box((0.001, 0.05, 0.008), (x - 0.0005, y, 0.163))), (0.70, 0.71, 0.73)),
        Visual(mesh_shape("keys", _keys(design)), (0.75, 0.76, 0.78)),
        Visual(mesh_shape("display", display), shining((0.15, 0.85, 0.45))),
    )


def _body_link(design: Design) -> Link:
    visuals = (
        Visual(mesh_shape("shell", _shell(design)), design.shell),
        Visual(mesh_shape("control_panel", bevelled((_control_panel(design),))), design.front),
        *_controls(design),
        Visual(mesh_shape("feet", _feet(design)), BLACK),
        Visual(mesh_shape("vents", _vents(design)), (0.30, 0.31, 0.33)),
        Visual(mesh_shape("turntable", _turntable(design)), (0.62, 0.72, 0.76)),
    )
    shapes = tuple(box_shape(size, center) for size, center in (*_body(design), _control_panel(design), *_foot_boxes(design)))
    plate = cylinder_shape(design.plate, 0.005, (0.0, design.middle, FOOT + WALL + 0.0025))
    return Link("microwave", 5.0, visuals, (*shapes, plate))


def _model(design: Design) -> Model:
    visuals = (
        Visual(mesh_shape("door_frame", _merged(_frame(design))), design.front),
        Visual(mesh_shape("mesh_rim", _rim(design)), design.rim),
        Visual(mesh_shape("window", _merged((_window(design),))), GLASS),
        Visual(mesh_shape("handle", _handle_mesh(design)), design.handle),
    )
    (t, w, _), hinge = design.door, design.hinge
    slab = box_shape(design.door, (-t / 2.0, -w / 2.0, 0.0))
    door = Link("door_link", 0.6, visuals, (slab, *_handle_shapes(design)))
    joint = Joint("door", "revolute", "microwave", "door_link", hinge, (0.0, 0.0, -1.0), 0.0, 1.8, damping=0.05)
    left, right = design.width / 2.0, design.panel - design.width / 2.0
    notes = (
        "front faces -x; hollow; the door hangs on the left edge for a viewer in front (at +y) and opens towards -x",
        f"link `door_link` has its origin on the hinge at half door height {tuple(round(v, 4) for v in hinge)}; closed, the door "
        f"spans y -{w}..0 and x -{t}..0 there",
        f"handle bar vertical, diameter {2 * BAR_RADIUS}, length {design.bar}, centre {(*design.grip, 0.0)} in `door_link`; "
        f"{-HANDLE[0] - t - BAR_RADIUS:.3f} m free behind it",
        f"inside: x {FRONT:.3f}..{DEPTH / 2.0 - WALL:.3f}, y {right:.4f}..{left - WALL:.3f}, floor at z = 0.022",
        f"turntable of radius {design.plate} at (0, {design.middle}), upper side at z = 0.027",
    )
    return Model(design.name, f"objects/{design.name}", "bottom centre", (_body_link(design), door), (joint,), notes)


CREAM = Design(
    "microwave_with_dials",
    width=0.43,
    height=0.22,
    door_width=0.32,
    bar=0.12,
    plate=0.11,
    dials=True,
    shell=plastic((0.90, 0.84, 0.70)),
    front=plastic((0.62, 0.20, 0.14)),
    rim=(0.90, 0.84, 0.70),
    handle=metal((0.85, 0.70, 0.36)),
)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_model(Design()), _model(CREAM))
