"""A microwave oven with a door on its left edge."""

from __future__ import annotations

from assets_lib.cabinets import bevelled, cabinet
from assets_lib.mesh import Mesh, box, cylinder, merge, rod
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
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

DEPTH, WIDTH, HEIGHT, FOOT = 0.28, 0.38, 0.24, 0.01
DOOR = (0.018, 0.28, 0.22)
GAP = 0.0015
FRONT = -DEPTH / 2.0 + DOOR[0] + GAP
"""x of the front of the body behind the door [m]."""
WALL = 0.012
PANEL_WIDTH = WIDTH - DOOR[1] - GAP
HINGE = (FRONT - GAP, WIDTH / 2.0, (FOOT + HEIGHT) / 2.0)
HANDLE = (-0.018 - 0.042, -0.255, 0.0)
"""Centre of the handle bar in the door frame [m]."""
BAR_RADIUS, BAR_LENGTH = 0.006, 0.15
SHELL, BLACK, GLASS = plastic((0.80, 0.81, 0.82)), (0.10, 0.10, 0.11), pane((0.12, 0.15, 0.17), 0.55)

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _body() -> tuple[Box, ...]:
    """Return the boxes (size, centre) of the shell around the hollow."""
    depth, mid = DEPTH / 2.0 - FRONT, (DEPTH / 2.0 + FRONT) / 2.0
    z, tall = (FOOT + HEIGHT) / 2.0, HEIGHT - FOOT
    left, right = WIDTH / 2.0, -WIDTH / 2.0 + PANEL_WIDTH
    return (
        ((depth, WIDTH, WALL), (mid, 0.0, FOOT + WALL / 2.0)),
        ((depth, WIDTH, WALL), (mid, 0.0, HEIGHT - WALL / 2.0)),
        ((depth, WALL, tall - 2 * WALL), (mid, left - WALL / 2.0, z)),
        ((WALL, left - WALL - right, tall - 2 * WALL), (DEPTH / 2.0 - WALL / 2.0, (left - WALL + right) / 2.0, z)),
        ((depth, PANEL_WIDTH, tall - 2 * WALL), (mid, right - PANEL_WIDTH / 2.0, z)),
    )


def _shell() -> Mesh:
    """Return the shell around the hollow."""
    hollow = (FOOT + WALL, HEIGHT - WALL)
    opening = (-WIDTH / 2.0 + PANEL_WIDTH, WIDTH / 2.0 - WALL)
    spans = ((FRONT, DEPTH / 2.0), (-WIDTH / 2.0, WIDTH / 2.0), (FOOT, HEIGHT))
    return cabinet(*spans, opening, (hollow,), DEPTH / 2.0 - WALL - FRONT)


def _dial() -> Mesh:
    """Return the knob for the time below the keys."""
    place = (-DEPTH / 2.0 - 0.005, -WIDTH / 2.0 + PANEL_WIDTH / 2.0, 0.038)
    return cylinder(0.016, 0.010, 20, bevel=0.002).moved(place, (0.0, 1.57079633, 0.0))


def _rim() -> Mesh:
    """Return the bright line around the window."""
    _, w, h = DOOR
    x, y, z = -DOOR[0] - 0.0006, (-w + 0.058, -0.038), (-h / 2.0 + 0.038, h / 2.0 - 0.038)
    bars = [box((0.0012, y[1] - y[0], 0.002), (x, (y[0] + y[1]) / 2.0, at)) for at in z]
    return merge([*bars, *(box((0.0012, 0.002, z[1] - z[0]), (x, at, 0.0)) for at in y)])


def _control_panel() -> Box:
    """Return the block beside the door, flush with it."""
    size = (DOOR[0] + GAP, PANEL_WIDTH, HEIGHT - FOOT)
    return (size, (-DEPTH / 2.0 + size[0] / 2.0, -WIDTH / 2.0 + PANEL_WIDTH / 2.0, (FOOT + HEIGHT) / 2.0))


def _keys() -> Mesh:
    """Return twelve keys of the control panel."""
    y = -WIDTH / 2.0 + PANEL_WIDTH / 2.0
    places = [(y + dy, z) for dy in (-0.024, 0.0, 0.024) for z in (0.062, 0.086, 0.110, 0.134)]
    return merge(box((0.003, 0.017, 0.014), (-DEPTH / 2.0 - 0.0015, py, pz)) for py, pz in places)


def _feet() -> Mesh:
    return merge(box((0.03, 0.03, FOOT), (x, y, FOOT / 2.0)) for x in (-0.08, 0.1) for y in (-0.15, 0.15))


def _vents() -> Mesh:
    """Return the slots in the back and in both sides, and a label."""
    back, side = DEPTH / 2.0 + 0.0005, WIDTH / 2.0 + 0.0005
    slots = [box((0.001, 0.10, 0.006), (back, 0.09, 0.09 + 0.014 * i)) for i in range(8)]
    slots += [box((0.09, 0.001, 0.006), (0.06, y, 0.14 + 0.014 * i)) for y in (-side, side) for i in range(5)]
    return merge([*slots, box((0.001, 0.08, 0.05), (back, -0.09, 0.16))])


def _turntable() -> Mesh:
    """Return the glass plate inside."""
    return cylinder(0.105, 0.005, 24).moved((0.0, 0.043, FOOT + WALL + 0.0025))


def _frame() -> tuple[Box, ...]:
    """Return the four bars of the door around its window; the origin is the hinge."""
    t, w, h = DOOR
    border = 0.04
    y = -w / 2.0
    return (
        ((t, w, border), (-t / 2.0, y, (h - border) / 2.0)),
        ((t, w, border), (-t / 2.0, y, -(h - border) / 2.0)),
        ((t, border, h - 2 * border), (-t / 2.0, -border / 2.0, 0.0)),
        ((t, border + 0.02, h - 2 * border), (-t / 2.0, -w + (border + 0.02) / 2.0, 0.0)),
    )


def _window() -> Box:
    t, w, h = DOOR
    return ((0.008, w - 0.1, h - 0.08), (-t / 2.0, -w / 2.0 + 0.01, 0.0))


def _handle_mesh() -> Mesh:
    x, y, _ = HANDLE
    bar = rod((x, y, -BAR_LENGTH / 2.0), (x, y, BAR_LENGTH / 2.0), BAR_RADIUS, 10)
    return merge([bar, *(rod((x, y, z), (-DOOR[0], y, z), 0.005, 8) for z in (-0.06, 0.06))])


def _handle_shapes() -> tuple[Shape, ...]:
    x, y, _ = HANDLE
    length = -x - DOOR[0]
    posts = (box_shape((length, 0.009, 0.009), (x + length / 2.0, y, z)) for z in (-0.06, 0.06))
    return (cylinder_shape(BAR_RADIUS, BAR_LENGTH, HANDLE), *posts)


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _body_link() -> Link:
    y = -WIDTH / 2.0 + PANEL_WIDTH / 2.0
    display = box((0.003, 0.068, 0.03), (-DEPTH / 2.0 - 0.0015, y, 0.19))
    visuals = (
        Visual(mesh_shape("shell", _shell()), SHELL),
        Visual(mesh_shape("control_panel", bevelled((_control_panel(),))), BLACK),
        Visual(mesh_shape("dial", _dial()), metal((0.85, 0.86, 0.88))),
        Visual(mesh_shape("badge", box((0.001, 0.05, 0.008), (-DEPTH / 2.0 - 0.0005, y, 0.163))), (0.70, 0.71, 0.73)),
        Visual(mesh_shape("keys", _keys()), (0.75, 0.76, 0.78)),
        Visual(mesh_shape("display", display), shining((0.15, 0.85, 0.45))),
        Visual(mesh_shape("feet", _feet()), BLACK),
        Visual(mesh_shape("vents", _vents()), (0.30, 0.31, 0.33)),
        Visual(mesh_shape("turntable", _turntable()), (0.62, 0.72, 0.76)),
    )
    shapes = tuple(box_shape(size, center) for size, center in (*_body(), _control_panel()))
    feet = tuple(box_shape((0.03, 0.03, FOOT), (x, y, FOOT / 2.0)) for x in (-0.08, 0.1) for y in (-0.15, 0.15))
    plate = cylinder_shape(0.105, 0.005, (0.0, 0.043, FOOT + WALL + 0.0025))
    return Link("microwave", 5.0, visuals, (*shapes, *feet, plate))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    visuals = (
        Visual(mesh_shape("door_frame", _merged(_frame())), BLACK),
        Visual(mesh_shape("mesh_rim", _rim()), (0.32, 0.33, 0.35)),
        Visual(mesh_shape("window", _merged((_window(),))), GLASS),
        Visual(mesh_shape("handle", _handle_mesh()), metal((0.85, 0.86, 0.88))),
    )
    t, w, _ = DOOR
    slab = box_shape(DOOR, (-t / 2.0, -w / 2.0, 0.0))
    door = Link("door_link", 0.6, visuals, (slab, *_handle_shapes()))
    joint = Joint("door", "revolute", "microwave", "door_link", HINGE, (0.0, 0.0, -1.0), 0.0, 1.8, damping=0.05)
    notes = (
        "front faces -x; hollow; the door hangs on the left edge for a viewer in front (at +y) and opens towards -x",
        f"link `door_link` has its origin on the hinge at half door height {tuple(round(v, 4) for v in HINGE)}; shut, the door "
        f"spans y -{w}..0 and x -{t}..0 there",
        f"handle bar vertical, diameter {2 * BAR_RADIUS}, length {BAR_LENGTH}, centre {HANDLE} in `door_link`; "
        f"{-HANDLE[0] - t - BAR_RADIUS:.3f} m free behind it",
        "inside: x -0.120..0.128, y -0.0915..0.178, floor at z = 0.022",
        "turntable of radius 0.105 at (0, 0.043), upper side at z = 0.027",
    )
    return (Model("microwave", "objects/microwave", "bottom centre", (_body_link(), door), (joint,), notes),)
