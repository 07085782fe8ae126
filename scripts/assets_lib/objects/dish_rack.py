"""A dish rack with three lanes between coloured pegs, a plate for it, a stand for the plate, and a mat to lay it on."""

from __future__ import annotations

from math import tan

from assets_lib.cabinets import Vec3, bevelled
from assets_lib.mesh import box, cylinder, lathe, merge
from assets_lib.objects.dishwasher import plate_solids
from assets_lib.urdf import Joint, Link, Model, Visual, box_shape, cylinder_shape, glass, mesh_shape, patterned, plastic

LENGTH, WIDTH, BASE = 0.24, 0.14, 0.02
LANES = (-0.05, 0.0, 0.05)
"""Middle of each lane along x [m]."""
PEG_RADIUS, PEG_HEIGHT, GAP = 0.006, 0.09, 0.022
PEG_FOOT = 0.004
"""Height at which the pegs begin, inside the bar that carries them [m]."""
PLATE_RADIUS, PLATE_HEIGHT = 0.08, 0.012
RAIL, BAR = 0.012, 0.016
CRADLE = 0.034
"""Distance of the two rails that carry a plate from the middle [m]."""
STAND_LENGTH, STAND_WIDTH, CHEEK, CHEEK_GAP = 0.07, 0.16, 0.05, 0.0145
MAT = 0.10
TWELFTH = 0.2617993878
"""Slope of the lowest sides of the plate [rad]."""
PLATE_REST = BASE + PLATE_RADIUS - (CRADLE - RAIL / 2.0) * tan(TWELFTH)
"""Height of the middle of a plate on edge: its lowest two sides lie on the inner edges of the rails [m]."""
BAMBOO, GREY = patterned(plastic((0.80, 0.64, 0.42)), "wood"), (0.45, 0.46, 0.48)

Box = tuple[Vec3, Vec3]


def _rack_boxes() -> list[Box]:
    """Return size and centre of both ends, both sides, the rails, and the low bar on which the pegs stand."""
    inner = LENGTH - 2.0 * BAR
    ends = [((BAR, WIDTH, BASE), (s * (LENGTH - BAR) / 2.0, 0.0, BASE / 2.0)) for s in (-1, 1)]
    sides = [((inner, BAR, BASE), (0.0, s * (WIDTH - BAR) / 2.0, BASE / 2.0)) for s in (-1, 1)]
    rails = [((inner, RAIL, BASE), (0.0, s * CRADLE, BASE / 2.0)) for s in (-1, 1)]
    return [*ends, *sides, *rails, ((inner, 0.018, 0.008), (0.0, 0.0, 0.004))]


def _lane(number: int) -> Link:
    """Return the two pegs of a lane and its marks on both sides, as a link of its own that a task colours."""
    height = BASE + PEG_HEIGHT - PEG_FOOT
    places = [(LANES[number] + s * (GAP / 2.0 + PEG_RADIUS), 0.0, PEG_FOOT + height / 2.0) for s in (-1, 1)]
    pegs = merge(cylinder(PEG_RADIUS, height, 12, bevel=0.002).moved(place) for place in places)
    marks = [box((GAP + 0.004, BAR - 0.004, 0.001), (LANES[number], s * (WIDTH - BAR) / 2.0, BASE)) for s in (-1, 1)]
    solid = tuple(cylinder_shape(PEG_RADIUS, height, place) for place in places)
    seen = Visual(mesh_shape(f"pegs{number}", merge([pegs, *marks])), plastic((0.6, 0.6, 0.6)))
    return Link(f"lane{number}", 0.05, (seen,), solid)


def _rack() -> Model:
    boxes = _rack_boxes()
    link = Link("dish_rack", 1.0, (Visual(mesh_shape("base", bevelled(boxes)), BAMBOO),), tuple(box_shape(*b) for b in boxes))
    lanes = tuple(_lane(i) for i in range(len(LANES)))
    joints = tuple(Joint(f"{lane.name}_holder", "fixed", "dish_rack", lane.name, (0.0, 0.0, 0.0)) for lane in lanes)
    notes = (
        f"links `lane0` to `lane2`: two pegs each, {GAP} apart along x, around x = {LANES}; they end at z = {BASE + PEG_HEIGHT}",
        f"a plate on edge across x, a corner down, rests in a lane with its middle at y = 0, z = {PLATE_REST:.4f}",
    )
    return Model("dish_rack", "objects/dish_rack", "bottom centre", (link, *lanes), joints, notes)


def _band(inner: tuple[float, float], outer: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the outline of a thin ring between two points (radius, z) of a surface."""
    (a, low), (b, high) = inner, outer
    return [(a, low - 0.0004), (b, high - 0.0004), (b, high + 0.0004), (a, low + 0.0004), (a, low - 0.0004)]


def _plate() -> Model:
    """Return a plate that lies in the plane z = 0; its upper side faces z."""
    h, r, foot = PLATE_HEIGHT / 2.0, PLATE_RADIUS, 0.05
    china = [(0.0, -h), (foot, -h), (r, h - 0.004), (r, h), (r - 0.003, h), (foot, -h + 0.005), (0.0, -h + 0.005)]
    above, below = (2.0 * h - 0.005) / (r - 0.003 - foot), (2.0 * h - 0.004) / (r - foot)
    upper = [(a, -h + 0.005 + above * (a - foot)) for a in (0.062, 0.069)]
    lower = [(a, -h + below * (a - foot) - 0.0004) for a in (0.062, 0.067)]
    rings = merge(lathe(_band(*ends), 40) for ends in (upper, lower))
    visuals = (
        Visual(mesh_shape("china", lathe(china, 40)), glass((0.93, 0.93, 0.90)), crease=0.2),
        Visual(mesh_shape("rings", rings), (0.20, 0.36, 0.58)),
    )
    link = Link("rack_plate", 0.15, visuals, plate_solids(r, PLATE_HEIGHT), friction=0.8)
    notes = (f"diameter {2 * r}, {PLATE_HEIGHT} high; a solid with twelve sides for contact, a corner towards -y",)
    return Model("rack_plate", "objects/rack_plate", "centre", (link,), notes=notes)


def _stand() -> Model:
    """Return two rails and four cheeks on a thin board."""
    rails = [((STAND_LENGTH - 0.01, RAIL, BASE), (0.0, s * CRADLE, BASE / 2.0)) for s in (-1, 1)]
    at = (CHEEK_GAP + 0.01) / 2.0
    cheeks = [((0.01, RAIL, CHEEK), (sx * at, sy * CRADLE, CHEEK / 2.0)) for sx in (-1, 1) for sy in (-1, 1)]
    board = ((STAND_LENGTH, STAND_WIDTH, 0.006), (0.0, 0.0, 0.003))
    boxes = [board, *rails, *cheeks]
    link = Link(
        "plate_stand",
        0.5,
        (Visual(mesh_shape("stand", bevelled(boxes, 0.002)), plastic(GREY)),),
        tuple(box_shape(*b) for b in boxes),
    )
    notes = (f"a plate on edge across x, a corner down, stands in it with its middle at z = {PLATE_REST:.4f}",)
    return Model("plate_stand", "objects/plate_stand", "bottom centre", (link,), notes=notes)


def _mat() -> Model:
    cloth = cylinder(MAT, 0.002, 40, bevel=0.0008).moved((0.0, 0.0, 0.001))
    hem = lathe([(MAT - 0.012, 0.002), (MAT - 0.008, 0.002), (MAT - 0.008, 0.0024), (MAT - 0.012, 0.0024)], 40)
    visuals = (
        Visual(mesh_shape("mat", cloth), patterned((0.52, 0.60, 0.50), "cloth")),
        Visual(mesh_shape("hem", hem), (0.90, 0.88, 0.80)),
    )
    link = Link("round_mat", 0.05, visuals)
    return Model("round_mat", "objects/round_mat", "bottom centre", (link,), notes=(f"only seen; diameter {2 * MAT}",))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_rack(), _plate(), _stand(), _mat())
