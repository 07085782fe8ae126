"""A low cabinet with two halves behind two sliding doors."""

from __future__ import annotations

from assets_lib.cabinets import bevelled, bevelled_box
from assets_lib.mesh import Mesh, cylinder, merge, rod
from assets_lib.urdf import Joint, Link, Model, Visual, box_shape, cylinder_shape, mesh_shape, metal, plastic

WIDTH, HEIGHT, BOARD = 0.60, 0.31, 0.015
FRONT, INSIDE, BACK = -0.13, -0.09, 0.12
"""x of the front of the boards, of the front of the walls behind both doors, and of the back [m]."""
PLINTH = 0.04
FLOOR, CEILING = PLINTH + BOARD, HEIGHT - BOARD
THICK, GAP = 0.015, 0.0025
"""Thickness of a door, and free space before and behind it [m]."""
DOOR = (0.303, CEILING - FLOOR - 0.004)
"""Width and height of a door; the inner edges overlap [m]."""
TRAVEL = 0.25
EDGE, STANDOFF = 0.027, 0.05
"""Distances of a handle bar from the outer edge and from the face of its door [m]."""
BAR_RADIUS, BAR_LENGTH = 0.006, 0.12
WALNUT, DARK, PAPER, LINEN = (0.40, 0.25, 0.15), (0.16, 0.12, 0.10), (0.80, 0.72, 0.60), plastic((0.88, 0.87, 0.82))
PANEL, STEEL = plastic((0.80, 0.80, 0.75)), metal((0.30, 0.30, 0.32))
HALF_PI = 1.5707963267948966

Span = tuple[float, float]
Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _between(x: Span, y: Span, z: Span) -> Box:
    """Return size and centre of the box between bounds."""
    size = (x[1] - x[0], y[1] - y[0], z[1] - z[0])
    return (size, ((x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0, (z[0] + z[1]) / 2.0))


def _boards() -> tuple[Box, ...]:
    """Return bottom, top, both sides and the middle wall; the doors run in front of the walls."""
    half, walls, level = WIDTH / 2.0, (INSIDE, BACK), (FLOOR, CEILING)
    return (
        _between((FRONT, BACK), (-half, half), (PLINTH, FLOOR)),
        _between((FRONT, BACK), (-half, half), (CEILING, HEIGHT)),
        _between(walls, (half - BOARD, half), level),
        _between(walls, (-half, -half + BOARD), level),
        _between(walls, (-BOARD / 2.0, BOARD / 2.0), level),
    )


def _back() -> Box:
    return _between((BACK - 0.008, BACK - 0.001), (-WIDTH / 2.0 + BOARD, WIDTH / 2.0 - BOARD), (FLOOR, CEILING))


def _plinth() -> Box:
    return _between((INSIDE, BACK - 0.02), (-WIDTH / 2.0 + 0.03, WIDTH / 2.0 - 0.03), (0.0, PLINTH))


def _rails() -> Mesh:
    """Return two thin rails below and above, one for each door; they are seen only."""
    half, tall = WIDTH / 2.0 - 0.004, 0.0012
    places = [(door_x(number), z) for number in (0, 1) for z in (FLOOR + tall / 2.0, CEILING - tall / 2.0)]
    return bevelled([((0.004, 2.0 * half, tall), (x, 0.0, z)) for x, z in places], 0.0004)


def door_x(number: int) -> float:
    """Return x of the middle of the left door (0), which runs in front, or of the right one (1)."""
    return INSIDE - GAP - THICK / 2.0 - (1 - number) * (THICK + GAP)


def _carcass() -> Link:
    half = WIDTH / 2.0 - 0.008
    skirting = _between((FRONT + 0.012, BACK - 0.008), (-half, half), (0.0, PLINTH))  # seen around the plinth
    visuals = (
        Visual(mesh_shape("boards", bevelled(_boards())), WALNUT),
        Visual(mesh_shape("back", bevelled((_back(),))), PAPER),
        Visual(mesh_shape("plinth", bevelled((skirting,))), DARK),
        Visual(mesh_shape("rails", _rails()), STEEL),
    )
    return Link("cabinet", 10.0, visuals, tuple(box_shape(*part) for part in (*_boards(), _back(), _plinth())))


def _door(name: str, side: int) -> Link:
    """Return a door whose outer edge is at +y (side 1) or -y (side -1); the origin is the middle of the slab."""
    width, height = DOOR
    x, y = -THICK / 2.0 - STANDOFF, side * (width / 2.0 - EDGE)
    ends = [s * (BAR_LENGTH / 2.0 - 0.012) for s in (-1, 1)]
    bar = rod((x, y, -BAR_LENGTH / 2.0), (x, y, BAR_LENGTH / 2.0), BAR_RADIUS, 12)
    posts = [rod((x, y, z), (-THICK / 2.0, y, z), 0.005, 8) for z in ends]
    rosettes = [cylinder(0.010, 0.003, 12).moved((-THICK / 2.0 - 0.001, y, z), (0.0, HALF_PI, 0.0)) for z in ends]
    sheet = ((0.002, width - 0.10, height - 0.07), (-THICK / 2.0 - 0.0002, -side * 0.012, 0.0))
    visuals = (
        Visual(mesh_shape(f"{name}_door", bevelled_box((THICK, width, height))), LINEN),
        Visual(mesh_shape(f"{name}_panel", bevelled((sheet,), 0.0009)), PANEL),
        Visual(mesh_shape(f"{name}_handle", merge([bar, *posts, *rosettes])), STEEL),
    )
    shapes = (
        box_shape((THICK, width, height)),
        cylinder_shape(BAR_RADIUS, BAR_LENGTH, (x, y, 0.0)),
        *(box_shape((STANDOFF, 0.009, 0.009), (-THICK / 2.0 - STANDOFF / 2.0, y, z)) for z in ends),
    )
    return Link(f"{name}_link", 0.6, visuals, shapes, friction=1.0)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    links, joints = [_carcass()], []
    for number, (name, side) in enumerate((("left", 1), ("right", -1))):
        place = (door_x(number), side * (WIDTH - DOOR[0]) / 2.0, (FLOOR + CEILING) / 2.0)
        links.append(_door(name, side))
        axis = (0.0, -float(side), 0.0)
        joints.append(Joint(f"{name}_door", "prismatic", "cabinet", f"{name}_link", place, axis, 0.0, TRAVEL, damping=2.0))
    bar_x, bar_y, middle = -THICK / 2.0 - STANDOFF, DOOR[0] / 2.0 - EDGE, (FLOOR + CEILING) / 2.0
    notes = (
        "front faces -x; for a viewer there the left door is at +y and runs in front of the right one; "
        "joints slide the doors to the middle",
        "link origins are the middles of the doors; the handle bars are vertical, "
        f"diameter {2 * BAR_RADIUS}, length {BAR_LENGTH}, at x = {bar_x:.4f}, y = +-{bar_y:.4f} there, "
        f"height {middle:.3f} above the table",
        f"inside: x {INSIDE}..{BACK - 0.008:.3f}, y {BOARD / 2.0}..{WIDTH / 2.0 - BOARD:.3f} on either side, "
        f"z {FLOOR:.3f}..{CEILING:.3f}",
    )
    return (Model("sliding_cabinet", "objects/sliding_cabinet", "bottom centre", tuple(links), tuple(joints), notes),)
