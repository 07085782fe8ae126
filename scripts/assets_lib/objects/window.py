"""A window with two glazed wings in a frame; the left one swings, once its handle is turned."""

from __future__ import annotations

from assets_lib.mesh import Mesh, box, cylinder, merge, rod
from assets_lib.urdf import Joint, Link, Model, Visual, box_shape, cylinder_shape, mesh_shape, metal, pane

FRAME = (0.03, 0.50, 0.45)
BORDER = 0.018
"""Width of the bars of the frame [m]."""
WING = (0.02, 0.23, 0.405)
STILE = 0.028
"""Width of the bars of a wing around its pane [m]."""
FOOT = (0.18, 0.05, 0.015)
HINGE = (WING[0] / 2.0, FRAME[1] / 2.0 - BORDER - 0.001, FRAME[2] / 2.0)
"""On the outer side of the left wing, at half its height [m]."""
PIVOT = (-WING[0] / 2.0, -WING[1] + STILE / 2.0, 0.0)
"""Of the handle, in the frame of the wing at half its thickness [m]."""
LENGTH, WIDTH, STANDOFF = 0.10, 0.02, 0.045
"""Length and width of the handle, distance of its middle from the middle of the wing's inner side [m]."""
WHITE, GREEN, RED = (0.93, 0.94, 0.93), (0.10, 0.42, 0.30), (0.80, 0.14, 0.10)
PANE, STEEL = pane((0.62, 0.82, 0.92), 0.30), metal((0.55, 0.57, 0.6))

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _frame() -> tuple[Box, ...]:
    """Return the boxes (size, centre) of the frame and its two feet."""
    depth, width, height = FRAME
    y, z = (width - BORDER) / 2.0, BORDER / 2.0
    upright = (depth, BORDER, height - 2 * BORDER)
    across = (depth, width, BORDER)
    feet = tuple((FOOT, (0.0, side * (y - 0.016), FOOT[2] / 2.0)) for side in (-1, 1))
    return (
        *((upright, (0.0, side * y, height / 2.0)) for side in (-1, 1)),
        (across, (0.0, 0.0, z)),
        (across, (0.0, 0.0, height - z)),
        *feet,
    )


def _bars(x: float, y: float, z: float) -> tuple[Box, ...]:
    """Return the four bars of a wing whose middle is at a place."""
    t, w, h = WING
    side, high = (w - STILE) / 2.0, (h - STILE) / 2.0
    return (
        *(((t, STILE, h), (x, y + s * side, z)) for s in (-1, 1)),
        *(((t, w - 2 * STILE, STILE), (x, y, z + s * high)) for s in (-1, 1)),
    )


def _pane(x: float, y: float, z: float) -> Box:
    return ((0.006, WING[1] - 2 * STILE, WING[2] - 2 * STILE), (x, y, z))


def _fixed() -> Link:
    right = (0.0, -HINGE[1] + WING[1] / 2.0, HINGE[2])
    visuals = (
        Visual(mesh_shape("frame", _merged(_frame())), WHITE),
        Visual(mesh_shape("right_bars", _merged(_bars(*right))), GREEN),
        Visual(mesh_shape("right_pane", _merged((_pane(*right),))), PANE),
    )
    boxes = (*_frame(), (WING, right))
    return Link("frame", 6.0, visuals, tuple(box_shape(size, center) for size, center in boxes))


def _wing() -> Link:
    middle = (-WING[0] / 2.0, -WING[1] / 2.0, 0.0)
    plate = box((WING[0] + 0.006, 0.024, 0.06), (-WING[0] / 2.0, PIVOT[1], 0.0))
    hinges = merge(cylinder(0.006, 0.05, 10).moved((0.0, 0.0, z)) for z in (-0.14, 0.14))
    visuals = (
        Visual(mesh_shape("left_bars", _merged(_bars(*middle))), GREEN),
        Visual(mesh_shape("left_pane", _merged((_pane(*middle),))), PANE),
        Visual(mesh_shape("plate", plate), STEEL),
        Visual(mesh_shape("hinges", hinges), STEEL),
    )
    return Link("wing", 0.8, visuals, (box_shape(WING, middle),))


def _handle() -> Link:
    """Return the handle; its origin is on the pivot, and at 0 the grip hangs down."""
    x, low = -WING[0] / 2.0 - STANDOFF, WIDTH / 2.0 - LENGTH
    grip = ((0.014, WIDTH, LENGTH), (x, 0.0, low + LENGTH / 2.0))
    spindle = rod((-WING[0] / 2.0, 0.0, 0.0), (x, 0.0, 0.0), 0.008, 12)
    visuals = (
        Visual(mesh_shape("grip", box(*grip)), RED),
        Visual(mesh_shape("spindle", spindle), STEEL),
    )
    length = STANDOFF - 0.012
    post = cylinder_shape(0.008, length, (-WING[0] / 2.0 - 0.004 - length / 2.0, 0.0, 0.0), (0.0, 1.57079633, 0.0))
    return Link("handle_link", 0.1, visuals, (box_shape(*grip), post), friction=1.0)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    swing = Joint("wing_hinge", "revolute", "frame", "wing", HINGE, (0.0, 0.0, 1.0), 0.0, 1.2, damping=0.05)
    turn = Joint("handle", "revolute", "wing", "handle_link", PIVOT, (1.0, 0.0, 0.0), 0.0, 1.6, damping=0.01)
    hinge, pivot = (tuple(round(v, 4) for v in place) for place in (HINGE, PIVOT))
    notes = (
        "stands across x, inside towards -x; for a viewer there the left wing, at +y, opens outwards, towards +x; "
        "the right one is fixed",
        f"link `wing` has its origin on the hinge at half height {hinge}; closed, it spans x -{WING[0]}..0, "
        f"y -{WING[1]}..0, z -+{WING[2] / 2.0} there",
        f"link `handle_link` has its origin on the pivot {pivot} in `wing`; at 0 its grip hangs down, "
        f"z {WIDTH / 2.0 - LENGTH:.3f}..{WIDTH / 2.0}, {WIDTH} wide, 0.014 thick, "
        f"its middle at x = {-WING[0] / 2.0 - STANDOFF:.3f}; "
        "at 1.57 it points to the hinge of the wing, +y",
    )
    links = (_fixed(), _wing(), _handle())
    return (Model("window", "objects/window", "bottom centre", links, (swing, turn), notes),)
