"""A chest of three drawers on four legs."""

from __future__ import annotations

from itertools import pairwise

from assets_lib.cabinets import bevelled, bevelled_box, cabinet
from assets_lib.mesh import Mesh, box, cylinder, merge, rod
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape, metal, patterned, plastic

DEPTH, WIDTH, HEIGHT, LEG = 0.26, 0.34, 0.36, 0.045
SIDE, PANEL, BACK = 0.018, 0.012, 0.008
FRONT = (0.015, 0.30, 0.09)
PITCH = (HEIGHT - LEG - 2 * PANEL) / 3.0
TRAVEL, SHORT_TRAVEL = 0.22, 0.15
"""How far drawers come out, and how far where a stop holds them [m]."""
BAR_RADIUS, BAR_LENGTH = 0.006, 0.10
HANDLE = (-0.045, 0.0, 0.015)
"""Centre of the handle bar in the drawer frame [m]."""
OAK, DARK_OAK, PALE = (patterned(color, "wood") for color in ((0.62, 0.42, 0.24), (0.46, 0.29, 0.15), (0.84, 0.69, 0.48)))
STEEL = metal((0.30, 0.30, 0.32))
TOP = patterned(plastic((0.66, 0.46, 0.27)), "wood")
DRAWERS = ("drawer_bottom", "drawer_middle", "drawer_top")
HALF_PI = 1.5707963267948966

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _carcass() -> tuple[Box, ...]:
    """Return the boxes (size, centre) of the fixed part, without legs."""
    middle, inner = (LEG + HEIGHT) / 2.0, WIDTH - 2 * SIDE
    shift = (WIDTH - SIDE) / 2.0
    boxes: list[Box] = [((DEPTH, SIDE, HEIGHT - LEG), (0.0, y, middle)) for y in (-shift, shift)]
    boxes += [((DEPTH, inner, PANEL), (0.0, 0.0, z)) for z in (LEG + PANEL / 2.0, HEIGHT - PANEL / 2.0)]
    boxes.append(((BACK, inner, HEIGHT - LEG - 2 * PANEL), ((DEPTH - BACK) / 2.0, 0.0, middle)))
    for i in (1, 2):
        boxes.append(((0.03, inner, 0.003), (-DEPTH / 2.0 + 0.03, 0.0, LEG + PANEL + i * PITCH)))
    return tuple(boxes)


def _shell() -> Mesh:
    """Return what is seen of the fixed part: a case that is open to the front, one opening for each drawer."""
    inner = WIDTH / 2.0 - SIDE
    edges = [LEG + PANEL + i * PITCH for i in range(4)]
    hollows = tuple((low + 0.0015, high - 0.0015) for low, high in pairwise(edges))
    spans = ((-DEPTH / 2.0, DEPTH / 2.0), (-WIDTH / 2.0, WIDTH / 2.0), (LEG, HEIGHT - 0.006))
    return cabinet(*spans, (-inner, inner), hollows, DEPTH - BACK)


def _legs() -> tuple[Box, ...]:
    return tuple(((0.03, 0.03, LEG), (x, y, LEG / 2.0)) for x in (-0.105, 0.105) for y in (-0.145, 0.145))


def _back_board() -> tuple[Box, ...]:
    """Return the seen lining of the back."""
    return (((0.002, WIDTH - 0.05, HEIGHT - LEG - 0.05), (DEPTH / 2.0 + 0.001, 0.0, (LEG + HEIGHT) / 2.0)),)


def _tray() -> tuple[Box, ...]:
    """Return the boxes of one drawer behind its front; the origin is the centre of the front face."""
    back = FRONT[0] + 0.22
    middle = (FRONT[0] + back) / 2.0
    length, width, low, wall, depth = back - FRONT[0], 0.29, -0.04, 0.006, 0.065
    z = low + depth / 2.0
    return (
        ((length, width, wall), (middle, 0.0, low + wall / 2.0)),
        ((length, wall, depth), (middle, (width - wall) / 2.0, z)),
        ((length, wall, depth), (middle, -(width - wall) / 2.0, z)),
        ((wall, width - 2 * wall, depth), (back - wall / 2.0, 0.0, z)),
    )


def _front() -> Box:
    return (FRONT, (FRONT[0] / 2.0, 0.0, 0.0))


def _handle_mesh() -> Mesh:
    x, _, z = HANDLE
    bar = rod((x, -BAR_LENGTH / 2.0, z), (x, BAR_LENGTH / 2.0, z), BAR_RADIUS, 10)
    posts = [rod((x, y, z), (0.0, y, z), 0.005, 8) for y in (-0.042, 0.042)]
    return merge([bar, *posts])


def _rosettes() -> Mesh:
    """Return the round plates under the posts of the handle."""
    turn = (0.0, HALF_PI, 0.0)
    return merge(cylinder(0.011, 0.003, 8).moved((-0.0005, y, HANDLE[2]), turn) for y in (-0.042, 0.042))


def _handle_shapes() -> tuple[Shape, ...]:
    x, _, z = HANDLE
    bar = cylinder_shape(BAR_RADIUS, BAR_LENGTH, HANDLE, (HALF_PI, 0.0, 0.0))
    return (bar, *(box_shape((-x, 0.009, 0.009), (x / 2.0, y, z)) for y in (-0.042, 0.042)))


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _drawer(name: str) -> Link:
    visuals = (
        Visual(mesh_shape("front", bevelled((_front(),), 0.003)), PALE),
        Visual(mesh_shape("rosettes", _rosettes()), STEEL),
        Visual(mesh_shape("tray", _merged(_tray())), patterned((0.90, 0.82, 0.68), "wood")),
        Visual(mesh_shape("handle", _handle_mesh()), STEEL),
    )
    shapes = tuple(box_shape(size, center) for size, center in (_front(), *_tray()))
    return Link(name, 0.6, visuals, (*shapes, *_handle_shapes()), friction=0.8)


def _joints(heights: tuple[float, ...], travel: float) -> tuple[Joint, ...]:
    """Return the slides of the drawers, whose fronts have these heights [m]."""
    return tuple(
        Joint(name, "prismatic", "chest", f"{name}_link", (-DEPTH / 2.0, 0.0, z), (-1.0, 0.0, 0.0), 0.0, travel, damping=2.0)
        for name, z in zip(DRAWERS, heights, strict=True)
    )


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    fixed = (*_carcass(), *_legs())
    visuals = (
        Visual(mesh_shape("carcass", _shell()), OAK),
        Visual(mesh_shape("top", bevelled_box((DEPTH, WIDTH, 0.014), (0.0, 0.0, HEIGHT - 0.007), 0.004)), TOP),
        Visual(mesh_shape("legs", bevelled(_legs())), DARK_OAK),
        Visual(mesh_shape("back_board", _merged(_back_board())), PALE),
    )
    chest = Link("chest", 6.0, visuals, tuple(box_shape(size, center) for size, center in fixed))
    heights = tuple(LEG + PANEL + (i + 0.5) * PITCH for i in range(3))
    notes = (
        "front faces -x; joints pull the drawers along -x; drawers are hollow with a bottom",
        f"drawer links have their origin at the centre of the front face: x = {-DEPTH / 2}, z = "
        + ", ".join(f"{z:.4f}" for z in heights)
        + " (bottom, middle, top)",
        f"handle bar along y, diameter {2 * BAR_RADIUS}, length {BAR_LENGTH}, centre {HANDLE} in the drawer link; "
        f"{-HANDLE[0] - BAR_RADIUS:.3f} m free behind it; heights of the bars "
        + ", ".join(f"{z + HANDLE[2]:.4f}" for z in heights),
        "inside of a drawer: x 0.015..0.229, y -0.139..0.139, floor at z = -0.034 in the drawer link",
    )
    links = (chest, *(_drawer(f"{name}_link") for name in DRAWERS))
    stops = (f"as chest, but stops hold the drawers after {SHORT_TRAVEL} m",)
    return (
        Model("chest", "objects/chest", "bottom centre", links, _joints(heights, TRAVEL), notes),
        Model("chest_with_stops", "objects/chest", "bottom centre", links, _joints(heights, SHORT_TRAVEL), stops),
    )
