"""The front of a tall fridge whose left door has an ice dispenser: a niche with an outlet and a tongue that a cup pushes."""

from __future__ import annotations

from assets_lib.cabinets import bevelled_box, cabinet
from assets_lib.mesh import Mesh, box, lathe, merge, rod
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
    Shape,
    Visual,
    box_shape,
    cylinder_shape,
    glass,
    mesh_shape,
    metal,
    plastic,
    shining,
)

FRONT, BACK, HALF, FOOT, HEIGHT = -0.12, 0.12, 0.20, 0.012, 0.60
"""x of the front and the back, half of the width, height of the feet and of the top [m]."""
NICHE, DEEP = ((0.02, 0.16), (0.25, 0.45)), 0.10
"""Range of the niche along y and z, and its depth [m]."""
MIDDLE = sum(NICHE[0]) / 2.0
SEAM = -0.03
"""y of the gap between both doors [m]."""
HANDLE, STAND_OFF = (0.08, 0.28), 0.02
"""Lowest and highest z of the bars, and how far they stand out [m]."""
TONGUE, AXLE, TURN = (0.01, 0.03, 0.06), (-0.07, 0.435), 0.35
"""Size of the tongue, x and z of its axle, how far it turns [m, rad]."""
STEEL, DARK, CHROME, GRILLE = plastic((0.74, 0.77, 0.80)), (0.13, 0.14, 0.15), metal((0.84, 0.85, 0.88)), (0.42, 0.44, 0.46)
HANDLES = plastic((0.20, 0.21, 0.23))
ICE = (0.80, 0.93, 1.0)


def _solid() -> tuple[Shape, ...]:
    """Return the boxes around the niche."""
    (low_y, high_y), (low_z, high_z) = NICHE
    depth, x = BACK - FRONT, (FRONT + BACK) / 2.0
    below = box_shape((depth, 2.0 * HALF, low_z), (x, 0.0, low_z / 2.0))
    above = box_shape((depth, 2.0 * HALF, HEIGHT - high_z), (x, 0.0, (HEIGHT + high_z) / 2.0))
    tall, z = high_z - low_z, (low_z + high_z) / 2.0
    sides = [box_shape((depth, b - a, tall), (x, (a + b) / 2.0, z)) for a, b in ((-HALF, low_y), (high_y, HALF))]
    behind = box_shape((depth - DEEP, high_y - low_y, tall), ((FRONT + DEEP + BACK) / 2.0, MIDDLE, z))
    return (below, above, *sides, behind)


def _lining() -> Mesh:
    """Return thin dark sheets on the walls of the niche, and its frame."""
    (low_y, high_y), (low_z, high_z) = NICHE
    t, x, wide, tall = 0.002, FRONT + DEEP / 2.0, high_y - low_y, high_z - low_z
    z, frame = (low_z + high_z) / 2.0, 0.005
    sheets = [box((t, wide, tall), (FRONT + DEEP - t, MIDDLE, z))]
    sheets += [box((DEEP, t, tall), (x, y, z)) for y in (low_y + t, high_y - t)]
    sheets += [box((DEEP, wide, t), (x, MIDDLE, edge)) for edge in (low_z + t, high_z - t)]
    sheets += [
        box((0.003, frame, tall + 2.0 * frame), (FRONT - 0.001, y, z)) for y in (low_y - frame / 2.0, high_y + frame / 2.0)
    ]
    sheets += [box((0.003, wide, frame), (FRONT - 0.001, MIDDLE, edge)) for edge in (low_z - frame / 2.0, high_z + frame / 2.0)]
    return merge(sheets)


def _bars() -> tuple[Mesh, tuple[Shape, ...]]:
    """Return the handles of both doors, on either side of the seam."""
    seen, solid = [], []
    low, high = HANDLE
    for y in (SEAM - 0.022, SEAM + 0.022):
        x = FRONT - STAND_OFF
        seen.append(rod((x, y, low), (x, y, high), 0.006, 8))
        seen += [rod((x, y, z), (FRONT + 0.002, y, z), 0.005, 8) for z in (low + 0.015, high - 0.015)]
        solid.append(
            box_shape((STAND_OFF + 0.006, 0.012, high - low), (FRONT - (STAND_OFF + 0.006) / 2.0, y, (low + high) / 2.0))
        )
    return merge(seen), tuple(solid)


def _cubes() -> Mesh:
    """Return the sign of the dispenser over the niche: three ice cubes."""
    places = ((-0.0265, 0.4785), (0.0, 0.4785), (0.0265, 0.4785), (-0.01325, 0.5035), (0.01325, 0.5035))
    return merge(bevelled_box((0.003, 0.023, 0.021), (FRONT - 0.0035, MIDDLE + y, z), 0.0014) for y, z in places)


def _ice() -> Mesh:
    """Return ice cubes that lie at the back of the niche."""
    floor, side, back = NICHE[1][0] + 0.003, 0.019, FRONT + DEEP - 0.015
    places = ((-0.044, 0.0, 0.2), (-0.021, 0.005, -0.5), (0.003, -0.001, 0.6), (0.028, 0.003, -0.2))
    cubes = [(back - inwards, y, 0.0, turn) for y, inwards, turn in places]
    cubes += [(back, -0.031, side, 0.9), (back + 0.001, 0.015, side, 0.3)]
    return merge(
        bevelled_box((side, side, side), bevel=0.003).moved((x, MIDDLE + y, floor + side / 2.0 + z), (0.0, 0.0, turn))
        for x, y, z, turn in cubes
    )


def _fridge() -> Link:
    bars, bar_shapes = _bars()
    nozzle = cylinder_shape(0.016, 0.02, (-0.095, MIDDLE, NICHE[1][1] - 0.01))
    tube = lathe([(0.0, -0.004), (0.011, -0.004), (0.012, -0.01), (0.016, -0.01), (0.02, 0.01), (0.0, 0.01)], 12)
    grille = [box((0.08, 0.004, 0.003), (FRONT + 0.05, MIDDLE + 0.012 * i, NICHE[1][0] + 0.002)) for i in range(-5, 6)]
    plinth = box((BACK - FRONT - 0.012, 2.0 * HALF - 0.012, FOOT), ((FRONT + BACK) / 2.0, 0.0, FOOT / 2.0))
    seams = [box((0.002, 0.004, HEIGHT - FOOT - 0.006), (FRONT - 0.0002, SEAM, (HEIGHT + FOOT) / 2.0))]
    vents = [box((0.002, 0.30, 0.004), (BACK + 0.0005, 0.0, 0.10 + 0.014 * i)) for i in range(8)]
    shell = cabinet((FRONT, BACK), (-HALF, HALF), (FOOT, HEIGHT), NICHE[0], (NICHE[1],), DEEP)
    panel = bevelled_box((0.004, 0.15, 0.075), (FRONT - 0.001, MIDDLE, 0.495), 0.0015)
    visuals = (
        Visual(mesh_shape("shell", shell), STEEL, crease=0.1),
        Visual(mesh_shape("lining", _lining()), DARK, crease=0.1),
        Visual(mesh_shape("dark", merge([plinth, panel, *seams, *vents])), DARK, crease=0.1),
        Visual(mesh_shape("bars", bars), HANDLES),
        Visual(mesh_shape("tube", tube.moved(nozzle.xyz)), CHROME),
        Visual(mesh_shape("grille", merge(grille)), GRILLE, crease=0.1),
        Visual(mesh_shape("cubes", _cubes()), ICE, crease=0.1),
        Visual(mesh_shape("ice", _ice()), glass(ICE), crease=0.1),
    )
    return Link("ice_fridge", 25.0, visuals, (*_solid(), *bar_shapes, nozzle))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    x, y, z = TONGUE
    blade = bevelled_box(TONGUE, (0.0, 0.0, -z / 2.0), 0.002)
    axle = rod((0.0, -y / 2.0 - 0.006, 0.0), (0.0, y / 2.0 + 0.006, 0.0), 0.004, 8)
    tongue = Link(
        "tongue",
        0.03,
        (Visual(mesh_shape("blade", merge([blade, axle])), (0.90, 0.55, 0.12), crease=0.3),),
        (box_shape(TONGUE, (0.0, 0.0, -z / 2.0)),),
    )
    light = box((0.002, 0.09, 0.008), (FRONT - 0.0035, MIDDLE, 0.5205))
    lamp = Link("light", 0.001, (Visual(mesh_shape("light", light), shining((0.35, 0.85, 1.0)), crease=0.1),))
    joints = (
        Joint(
            "tongue_joint",
            "revolute",
            "ice_fridge",
            "tongue",
            (AXLE[0], MIDDLE, AXLE[1]),
            (0.0, -1.0, 0.0),
            0.0,
            TURN,
            damping=0.002,
        ),
        Joint("light_mount", "fixed", "ice_fridge", "light", (0.0, 0.0, 0.0)),
    )
    notes = (
        f"front faces -x at x = {FRONT}; solid but for the niche: y {NICHE[0]}, z {NICHE[1]}, {DEEP} deep",
        f"link `tongue` hangs from an axle at x = {AXLE[0]}, y = {MIDDLE}, z = {AXLE[1]}, {z} long, {y} wide; "
        "pushed inwards its joint position increases",
        "recolour the link `light` over the niche",
    )
    return (Model("ice_fridge", "objects/ice_fridge", "bottom centre", (_fridge(), tongue, lamp), joints, notes),)
