"""A dishwasher with a door that folds down and a rack that slides out, and a plate for it."""

from __future__ import annotations

from math import cos, sin, tan

from assets_lib.cabinets import bevelled_box, cabinet, rectangle_at
from assets_lib.mesh import Mesh, box, lathe, merge, rod
from assets_lib.prisms import mark, rectangle, regular_polygon
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape, metal, patterned

DEPTH, WIDTH, HEIGHT, WALL = 0.36, 0.40, 0.42, 0.015
FLOOR, CEILING = 0.10, 0.345
"""Height of the floor and of the ceiling inside [m]."""
DOOR = (0.02, 0.36, 0.26)
HINGE = (-DEPTH / 2.0 - 0.0015, 0.0, 0.09)
HANDLE = (-DOOR[0] - 0.068, 0.0, 0.235)
"""Centre of the handle bar in the door frame [m]."""
BAR_RADIUS, BAR_LENGTH = 0.006, 0.24
RACK = (0.32, 0.32)
RACK_X, RACK_FLOOR, RIM, TRAVEL = -0.012, 0.115, 0.155, 0.24
"""Middle of the rack, heights of its base and of its rim when it is in, and how far it slides out [m]."""
RIM_RADIUS = 0.005
PLATE_PLACE, CRADLE = (-0.053, 0.06), 0.031
"""Where the plate stands in the rack, beside the place where a hand pulls; half the distance of the rods that carry it [m]."""
PLATE_RADIUS, PLATE_HEIGHT = 0.08, 0.015
STEEL, DARK, WIRE, SILVER = (
    patterned(metal((0.86, 0.87, 0.88)), "brushed"),
    (0.16, 0.17, 0.19),
    (0.30, 0.45, 0.70),
    metal((0.70, 0.71, 0.74)),
)
HALF_PI = 1.57079633

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _body() -> tuple[Box, ...]:
    """Return the boxes (size, centre) of the shell around the hollow."""
    side, inner, middle = (WIDTH - WALL) / 2.0, CEILING - FLOOR, (CEILING + FLOOR) / 2.0
    return (
        ((DEPTH, WIDTH, FLOOR), (0.0, 0.0, FLOOR / 2.0)),
        ((DEPTH, WIDTH, HEIGHT - CEILING), (0.0, 0.0, (HEIGHT + CEILING) / 2.0)),
        ((DEPTH, WALL, inner), (0.0, side, middle)),
        ((DEPTH, WALL, inner), (0.0, -side, middle)),
        ((WALL, WIDTH - 2 * WALL, inner), ((DEPTH - WALL) / 2.0, 0.0, middle)),
    )


def _shell() -> Mesh:
    """Return what is seen of the body: a case that is open to the front, its outer edges bevelled."""
    spans = ((-DEPTH / 2.0, DEPTH / 2.0), (-WIDTH / 2.0, WIDTH / 2.0), (0.0, HEIGHT))
    inner = WIDTH / 2.0 - WALL
    return cabinet(*spans, (-inner, inner), ((FLOOR, CEILING),), DEPTH - WALL)


def _seal() -> Mesh:
    """Return the dark seal around the opening, which the door touches."""
    x, half, wide = -DEPTH / 2.0 - 0.0006, WIDTH / 2.0 - WALL, 0.004
    sides = [rectangle_at(x, (side * half - wide, side * half + wide), (FLOOR, CEILING)) for side in (-1, 1)]
    return merge([*sides, rectangle_at(x, (-half, half), (CEILING - wide, CEILING + wide))])


def _lining() -> Mesh:
    """Return thin sheets that make the inside grey."""
    t, half, mid, tall = 0.001, WIDTH / 2.0 - WALL, (FLOOR + CEILING) / 2.0, CEILING - FLOOR
    sheets = [box((DEPTH - WALL, t, tall), (-WALL / 2.0, side * (half - t / 2.0), mid)) for side in (-1, 1)]
    sheets += [box((DEPTH - WALL, 2 * half, t), (-WALL / 2.0, 0.0, z)) for z in (FLOOR + t / 2.0, CEILING - t / 2.0)]
    return merge([*sheets, box((t, 2 * half, tall), (DEPTH / 2.0 - WALL - t / 2.0, 0.0, mid))])


def _sign() -> tuple[Visual, ...]:
    """Return a sticker on the top: a plate between fork and knife."""
    x, z = 0.04, HEIGHT
    label = mark(rectangle(0.16, 0.26) + (x, 0.0), z + 0.0006, "z")
    discs = [mark(regular_polygon(r, 16) + (x, 0.0), z + up, "z") for r, up in ((0.062, 0.0012), (0.040, 0.0024))]
    rim = mark(regular_polygon(0.046, 16) + (x, 0.0), z + 0.0018, "z")
    places = ((-0.095, 0.0, 0.012, 0.13), (0.095, 0.0, 0.012, 0.13), (0.095, 0.04, 0.026, 0.05))
    cutlery = [mark(rectangle(long, wide) + (x + ahead, y), z + 0.0012, "z") for y, ahead, wide, long in places]
    return (
        Visual(mesh_shape("label", label), (0.20, 0.35, 0.60)),
        Visual(mesh_shape("drawn_plate", merge([*discs, *cutlery])), (0.96, 0.96, 0.94)),
        Visual(mesh_shape("drawn_rim", rim), (0.80, 0.15, 0.15)),
    )


def _body_link() -> Link:
    front = -DEPTH / 2.0
    lamps = merge(box((0.002, 0.012, 0.006), (front - 0.003, 0.13 - 0.025 * k, 0.388)) for k in range(3))
    visuals = (
        Visual(mesh_shape("shell", _shell()), STEEL),
        Visual(mesh_shape("lining", _lining()), (0.55, 0.57, 0.60)),
        Visual(mesh_shape("seal", _seal()), (0.10, 0.10, 0.11)),
        Visual(mesh_shape("panel", box((0.002, WIDTH, HEIGHT - 0.36), (front - 0.001, 0.0, (HEIGHT + 0.352) / 2.0))), DARK),
        Visual(mesh_shape("lamps", lamps), (0.3, 0.9, 0.4)),
        Visual(mesh_shape("display", box((0.002, 0.08, 0.03), (front - 0.002, -0.10, 0.388))), (0.25, 0.65, 0.95)),
        Visual(mesh_shape("kick", box((0.002, WIDTH, 0.06), (front - 0.001, 0.0, 0.03))), DARK),
        *_sign(),
    )
    return Link("dishwasher", 15.0, visuals, tuple(box_shape(size, center) for size, center in _body()))


def _door_link() -> Link:
    t, w, h = DOOR
    x, _, z = HANDLE
    posts = tuple(rod((x, side * 0.10, z), (-t, side * 0.10, z), 0.005, 8) for side in (-1, 1))
    bar = rod((x, -BAR_LENGTH / 2.0, z), (x, BAR_LENGTH / 2.0, z), BAR_RADIUS, 12)
    visuals = (
        Visual(mesh_shape("door", bevelled_box(DOOR, (-t / 2.0, 0.0, h / 2.0))), STEEL),
        Visual(mesh_shape("door_inside", box((0.001, w - 0.03, h - 0.03), (0.0003, 0.0, h / 2.0))), (0.55, 0.57, 0.60)),
        Visual(mesh_shape("badge", box((0.001, 0.06, 0.014), (-t - 0.0005, 0.0, 0.06))), (0.20, 0.35, 0.60)),
        Visual(mesh_shape("handle", merge([bar, *posts])), SILVER),
    )
    length = -x - t - BAR_RADIUS + 0.002
    stays = tuple(box_shape((length, 0.009, 0.009), (-t - length / 2.0, side * 0.10, z)) for side in (-1, 1))
    grip = cylinder_shape(BAR_RADIUS, BAR_LENGTH, HANDLE, (HALF_PI, 0.0, 0.0))
    return Link("door_link", 1.0, visuals, (box_shape(DOOR, (-t / 2.0, 0.0, h / 2.0)), grip, *stays))


def _rack_solids() -> tuple[Box, ...]:
    """Return base, rim but for its front, corner posts, cradle and pins of the rack; its origin is the middle of its base."""
    lx, ly = RACK
    rise = RIM - RACK_FLOOR
    rims = [((0.008, ly, 0.008), ((lx - 0.008) / 2.0, 0.0, rise))]
    rims += [((lx, 0.006, 0.006), (0.0, s * (ly - 0.006) / 2.0, rise)) for s in (-1, 1)]
    posts = [
        ((0.006, 0.006, rise), (sx * (lx - 0.006) / 2.0, sy * (ly - 0.006) / 2.0, rise / 2.0)) for sx in (-1, 1) for sy in (-1, 1)
    ]
    x, y = PLATE_PLACE
    cradle = [((0.006, 0.05, 0.012), (x + s * CRADLE, y, 0.009)) for s in (-1, 1)]
    pins = [((0.004, 0.004, 0.055), (x + sx * 0.05, y + sy * 0.010, 0.0305)) for sx in (-1, 1) for sy in (-1, 1)]
    return (((lx, ly, 0.006), (0.0, 0.0, 0.0)), *rims, *posts, *cradle, *pins)


def _rim_place() -> tuple[float, float]:
    """Return x and z of the front rim in the rack's frame; it is round, for the hand to pull."""
    return -RACK[0] / 2.0 + RIM_RADIUS, RIM - RACK_FLOOR


def _rack_mesh() -> Mesh:
    """Return the rack as wires."""
    lx, ly = RACK
    wires = [box((lx, 0.004, 0.005), (0.0, -ly / 2.0 + ly * k / 10.0, 0.0)) for k in range(11)]
    wires += [box((0.004, ly, 0.005), (-lx / 2.0 + lx * k / 6.0, 0.0, 0.0)) for k in range(7)]
    rows = [box((0.004, 0.004, 0.04), (x, y, 0.02)) for x in (-0.11, -0.02, 0.08) for y in (-0.12, -0.07, -0.02, 0.12)]
    x, z = _rim_place()
    rim = rod((x, -ly / 2.0, z), (x, ly / 2.0, z), RIM_RADIUS, 10)
    return merge([*wires, *rows, rim, _merged(_rack_solids()[1:])])


def _rack_link() -> Link:
    wheels = merge(rod((x, y - 0.004, -0.006), (x, y + 0.004, -0.006), 0.006, 6) for x in (-0.1, 0.1) for y in (-0.15, 0.15))
    visuals = (Visual(mesh_shape("rack", _rack_mesh()), WIRE), Visual(mesh_shape("wheels", wheels), SILVER))
    x, z = _rim_place()
    rim = cylinder_shape(RIM_RADIUS, RACK[1], (x, 0.0, z), (HALF_PI, 0.0, 0.0))
    shapes = (rim, *(box_shape(size, center) for size, center in _rack_solids()))
    return Link("rack_link", 0.5, visuals, shapes, friction=0.8)


def plate_solids(radius: float, height: float) -> tuple[Shape, ...]:
    """Return six crossed boxes, together a prism with twelve sides: on edge, a cylinder rocks forever in the physics."""
    half = HALF_PI / 6.0
    size = (2.0 * radius * cos(half), 2.0 * radius * sin(half), height)
    return tuple(box_shape(size, (0.0, 0.0, 0.0), (0.0, 0.0, (2 * k + 1) * half)) for k in range(6))


def _plate() -> Model:
    """Return a plate that lies in the plane z = 0; its upper side faces z."""
    h, r = PLATE_HEIGHT / 2.0, PLATE_RADIUS
    outline = [(0.0, -h), (0.045, -h), (r, h - 0.004), (r, h), (r - 0.003, h), (0.045, -h + 0.006), (0.0, -h + 0.006)]
    slope = (r - 0.003 - 0.045, 2.0 * h - 0.006)
    outer, inner = ((b, -h + 0.0066 + (b - 0.045) * slope[1] / slope[0]) for b in (0.068, 0.058))
    below = [(b, z - 0.001) for b, z in (outer, inner)]
    ring = lathe([below[0], outer, inner, below[1], below[0]], 32)
    visuals = (
        Visual(mesh_shape("china", lathe(outline, 32)), (0.96, 0.96, 0.94)),
        Visual(mesh_shape("ring", ring), (0.80, 0.15, 0.15)),
    )
    link = Link("plate", 0.15, visuals, plate_solids(PLATE_RADIUS, PLATE_HEIGHT), friction=0.8)
    notes = (f"diameter {2 * r}, {PLATE_HEIGHT} high; a solid with twelve sides for contact, a corner towards -y",)
    return Model("dinner_plate", "objects/dinner_plate", "centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    door = Joint("door", "revolute", "dishwasher", "door_link", HINGE, (0.0, -1.0, 0.0), 0.0, 1.57, damping=0.05)
    place = (RACK_X, 0.0, RACK_FLOOR)
    rack = Joint("rack", "prismatic", "dishwasher", "rack_link", place, (-1.0, 0.0, 0.0), 0.0, TRAVEL, damping=2.0)
    rest = PLATE_REST - RACK_FLOOR
    notes = (
        "front faces -x; the door folds down towards -x about its lower edge, as that of the oven",
        f"link `door_link` has its origin on the hinge {HINGE}; handle bar along y, diameter {2 * BAR_RADIUS}, "
        f"length {BAR_LENGTH}, centre {HANDLE} in `door_link`",
        f"link `rack_link` has its origin in the middle of its base, x = {RACK_X}, z = {RACK_FLOOR}; front rim along y "
        f"at x = {_rim_place()[0]}, z = {_rim_place()[1]:.3f} there, {2 * RIM_RADIUS} thick",
        f"a plate on edge, facing y, stands at ({PLATE_PLACE[0]}, {PLATE_PLACE[1]}, {rest:.4f}) in `rack_link`",
    )
    links = (_body_link(), _door_link(), _rack_link())
    return Model("dishwasher", "objects/dishwasher", "bottom centre", links, (door, rack), notes), _plate()


PLATE_REST = RACK_FLOOR + 0.015 + PLATE_RADIUS - (CRADLE - 0.003) * tan(HALF_PI / 6.0)
"""Height of the middle of the plate on edge: its lowest two sides lie on the inner edges of the two rods [m]."""
