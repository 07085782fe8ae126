"""A steel safe with three levels and a thick door, and a bundle of banknotes."""

from __future__ import annotations

import numpy as np

from assets_lib.cabinets import bevelled, bevelled_box, cabinet
from assets_lib.mesh import Mesh, box, cylinder, merge, rod
from assets_lib.urdf import Joint, Link, Model, Shape, Vec3, Visual, box_shape, mesh_shape, metal, plastic

DEPTH, WIDTH, HEIGHT, WALL = 0.28, 0.32, 0.40, 0.02
LEVELS = (0.02, 0.14, 0.26)
"""Upper sides of the bottom and of the two shelves [m]."""
SHELF, RECESS = 0.008, 0.03
"""Thickness of the shelves, and how far behind the front they begin [m]."""
DOOR, GAP = 0.04, 0.002
BUNDLE = (0.12, 0.055, 0.02)
"""Length, width and height of the bundle [m]."""
STEEL, LINING, CHROME = plastic((0.25, 0.31, 0.36)), (0.62, 0.64, 0.63), metal((0.82, 0.83, 0.85))
EDGE, DIAL, TICK = metal((0.55, 0.57, 0.60)), plastic((0.10, 0.10, 0.11)), (0.93, 0.93, 0.90)
NOTE, PRINT, BAND = (0.60, 0.70, 0.55), (0.33, 0.47, 0.35), (0.93, 0.90, 0.83)
HALF_PI = 1.57079633


def _walls() -> tuple[tuple[Vec3, Vec3], ...]:
    """Return size and centre of back, sides, bottom, top and both shelves."""
    half, inner = HEIGHT / 2.0, WIDTH - 2.0 * WALL
    depth = DEPTH - WALL - RECESS
    shelves = tuple(((depth, inner, SHELF), ((RECESS - WALL) / 2.0, 0.0, z - SHELF / 2.0)) for z in LEVELS[1:])
    return (
        ((WALL, inner, HEIGHT - 2.0 * WALL), ((DEPTH - WALL) / 2.0, 0.0, half)),
        *(((DEPTH, WALL, HEIGHT), (0.0, s * (WIDTH - WALL) / 2.0, half)) for s in (-1.0, 1.0)),
        *(((DEPTH, inner, WALL), (0.0, 0.0, z)) for z in (WALL / 2.0, HEIGHT - WALL / 2.0)),
        *shelves,
    )


def _body() -> Link:
    front, inner = -DEPTH / 2.0, WIDTH / 2.0 - WALL
    shell = cabinet(
        (front, DEPTH / 2.0), (-WIDTH / 2.0, WIDTH / 2.0), (0.0, HEIGHT), (-inner, inner), ((WALL, HEIGHT - WALL),), DEPTH - WALL
    )
    sheet, low, high = 0.001, WALL, HEIGHT - WALL
    lining = merge(
        [
            *(box((DEPTH - WALL - 0.004, sheet, high - low), (-WALL / 2.0 + 0.002, s * inner, HEIGHT / 2.0)) for s in (-1, 1)),
            *(box((DEPTH - WALL - 0.004, 2.0 * inner, sheet), (-WALL / 2.0 + 0.002, 0.0, z)) for z in (low, high)),
            box((sheet, 2.0 * inner, high - low), (DEPTH / 2.0 - WALL, 0.0, HEIGHT / 2.0)),
        ]
    )
    hinges = merge(cylinder(0.009, 0.06, 10).moved((front, WIDTH / 2.0 + 0.004, z)) for z in (0.08, 0.32))
    walls = _walls()
    visuals = (
        Visual(mesh_shape("shell", shell), STEEL),
        Visual(mesh_shape("lining", lining), LINING),
        Visual(mesh_shape("shelves", bevelled(walls[-2:], 0.002)), EDGE),
        Visual(mesh_shape("hinges", hinges), CHROME),
    )
    return Link("safe", 40.0, visuals, tuple(box_shape(size, center) for size, center in walls))


def _wheel(x: float, y: float, z: float) -> Mesh:
    """Return a wheel of three spokes with knobs on its shaft, turned towards -x."""
    hub = [rod((0.0, y, z), (x, y, z), 0.010, 10), cylinder(0.016, 0.012, 12).moved((x, y, z), (0.0, HALF_PI, 0.0))]
    for angle in HALF_PI + np.arange(3) * 2.0 * np.pi / 3.0:
        tip = (x, y + 0.05 * float(np.cos(angle)), z + 0.05 * float(np.sin(angle)))
        hub += [rod((x, y, z), tip, 0.005, 8), cylinder(0.009, 0.018, 10).moved(tip, (0.0, HALF_PI, 0.0))]
    return merge(hub)


def _door() -> Link:
    """Return the door; its origin is on the hinge, and it reaches to -y when shut."""
    slab: tuple[Vec3, Vec3] = ((DOOR, WIDTH, HEIGHT), (-DOOR / 2.0 - GAP, -WIDTH / 2.0, 0.0))
    plug: tuple[Vec3, Vec3] = ((0.016, WIDTH - 2.0 * WALL - 0.02, HEIGHT - 2.0 * WALL - 0.02), (0.006, -WIDTH / 2.0, 0.0))
    face = -DOOR - GAP
    panel = bevelled_box((0.004, WIDTH - 0.05, HEIGHT - 0.05), (face, -WIDTH / 2.0, 0.0), 0.0015)
    dial = cylinder(0.030, 0.018, 20, bevel=0.004).moved((face - 0.008, -0.16, 0.09), (0.0, HALF_PI, 0.0))
    ticks = []
    for angle in np.arange(8) * np.pi / 4.0:
        y, z = -0.16 + 0.0225 * float(np.sin(angle)), 0.09 + 0.0225 * float(np.cos(angle))
        ticks.append(box((0.001, 0.0014, 0.005)).moved((face - 0.0172, y, z), (float(angle), 0.0, 0.0)))
    ticks.append(box((0.001, 0.004, 0.008), (face - 0.0025, -0.16, 0.128)))
    bolts = merge(rod((0.006, -WIDTH + 0.06, z), (0.006, -WIDTH + WALL + 0.002, z), 0.008, 8) for z in (-0.10, 0.0, 0.10))
    wheel = _wheel(face - 0.04, -0.16, -0.03)
    visuals = (
        Visual(mesh_shape("slab", bevelled((slab,))), STEEL),
        Visual(mesh_shape("plug", bevelled((plug,))), EDGE),
        Visual(mesh_shape("panel", panel), plastic((0.29, 0.36, 0.41))),
        Visual(mesh_shape("dial", dial), DIAL),
        Visual(mesh_shape("ticks", merge(ticks)), TICK),
        Visual(mesh_shape("wheel", merge([wheel, bolts])), CHROME),
    )
    knobs: tuple[Shape, ...] = (
        box_shape((0.05, 0.11, 0.11), (face - 0.025, -0.16, -0.03)),
        box_shape((0.018, 0.06, 0.06), (face - 0.009, -0.16, 0.09)),
    )
    return Link("door_link", 6.0, visuals, (box_shape(*slab), box_shape(*plug), *knobs))


def _safe() -> Model:
    hinge = (-DEPTH / 2.0, WIDTH / 2.0, HEIGHT / 2.0)
    door = Joint("door", "revolute", "safe", "door_link", hinge, (0.0, 0.0, -1.0), 0.0, 2.5, damping=0.2)
    notes = (
        f"front faces -x at x = {-DEPTH / 2.0}; the door hangs on the left edge for a viewer in front (at +y)",
        f"inside: y -+{WIDTH / 2.0 - WALL:.2f}, back at x = {DEPTH / 2.0 - WALL:.2f}; floors of the levels at z = {LEVELS}; "
        f"ceiling {HEIGHT - WALL}; the shelves are {SHELF} thick and begin at x = {RECESS - DEPTH / 2.0:.2f}",
    )
    return Model("safe", "objects/safe", "bottom centre", (_body(), _door()), (door,), notes)


def _bundle() -> Model:
    x, y, z = BUNDLE
    sheets = [bevelled_box((x - 0.002, y - 0.002, 0.0024), (0.0, 0.0, (i - 2.5) * 0.0033), 0.0004) for i in range(6)]
    print_ = merge(
        box((w, d, 0.0004), (s, 0.0, side * (z / 2.0)))
        for side in (-1, 1)
        for w, d, s in ((0.040, y - 0.012, -0.035), (0.040, y - 0.012, 0.035))
    )
    seals = merge(
        cylinder(0.013, 0.0006, 16).moved((s, 0.0, side * (z / 2.0 + 0.0001))) for side in (-1, 1) for s in (-0.035, 0.035)
    )
    visuals = (
        Visual(mesh_shape("notes", bevelled_box(BUNDLE, (0.0, 0.0, 0.0), 0.002)), NOTE),
        Visual(mesh_shape("sheets", merge(sheets).scaled((1.0172, 1.038, 1.0))), PRINT),
        Visual(mesh_shape("print", print_), PRINT),
        Visual(mesh_shape("seals", seals), NOTE),
        Visual(mesh_shape("band", bevelled_box((0.026, y + 0.001, z + 0.0012), (0.0, 0.0, 0.0), 0.002)), BAND),
    )
    link = Link("banknotes", 0.12, visuals, (box_shape(BUNDLE),), friction=0.9)
    notes = (f"{x} long along x, {y} wide along y, {z} high; rests with its origin at {z / 2.0} m; grasp it across y",)
    return Model("banknotes", "objects/banknotes", "centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return _safe(), _bundle()
