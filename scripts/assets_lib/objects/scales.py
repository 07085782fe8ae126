"""Kitchen scales with a sprung tray and a needle, and bell peppers of three colours."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, cylinder, hull_of, lathe, merge, rod
from assets_lib.prisms import mark, rectangle
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
    Visual,
    box_shape,
    cylinder_shape,
    mesh_shape,
    metal,
    patterned,
    plastic,
    sphere_shape,
)

BODY = (0.18, 0.20, 0.14)
TRAY = (0.20, 0.24, 0.015)
SLAB, RIM = 0.006, 0.006
NECK = 0.12
"""Width of the neck that bears the tray, which sinks into the housing [m]."""
TRAVEL = 0.03
TRAY_HEIGHT = BODY[2] + TRAVEL + 0.004
"""Height of the tray's underside at joint value 0 [m]."""
DIAL = (-BODY[0] / 2.0, 0.0, 0.07)
DIAL_RADIUS, NEEDLE = 0.056, 0.05
SHELL, CREAM, STEEL, DARK, RED = (
    plastic((0.25, 0.55, 0.60)),
    (0.97, 0.96, 0.90),
    metal((0.78, 0.79, 0.81)),
    (0.12, 0.12, 0.13),
    (0.85, 0.10, 0.08),
)
PEPPER_RADIUS, PEPPER_LOW, PEPPER_HIGH = 0.028, -0.035, 0.030
PEPPERS = {"green": (0.10, 0.48, 0.10), "red": (0.80, 0.07, 0.06), "yellow": (0.96, 0.78, 0.08)}


def _shell() -> Mesh:
    """Return the housing, narrower above."""
    x, y, z = BODY
    lower = [(sx * x / 2.0, sy * y / 2.0, h) for h in (0.0, z - 0.03) for sx in (-1, 1) for sy in (-1, 1)]
    upper = [(px, sy * y * 0.38, z) for px in (-x * 0.5, x * 0.4) for sy in (-1, 1)]
    return hull_of(np.array([*lower, *upper]))


def _facing(mesh: Mesh, depth: float) -> Mesh:
    """Turn a flat mesh around z towards -x and put it on the front."""
    return mesh.moved((DIAL[0] - depth, DIAL[1], DIAL[2]), (0.0, -np.pi / 2.0, 0.0))


def _marks(way: float) -> Mesh:
    """Return the strokes of a dial towards +x: at the top, then every 0.49 rad, long ones at every other."""
    strokes = []
    for i in range(12):
        length, angle = (0.016, 0.010)[i % 2], -0.49 * i
        stroke = mark(rectangle(0.004, length) + (0.0, DIAL_RADIUS - 0.004 - length / 2.0), 0.001, "x")
        strokes.append(stroke.moved(rpy=(way * angle, 0.0, 0.0)))
    return merge(strokes)


def _tray_link() -> Link:
    x, y, z = TRAY
    slab = box_shape((x, y, SLAB), (0.0, 0.0, SLAB / 2.0))
    rims = [box_shape((RIM, y, z - SLAB), (s * (x - RIM) / 2.0, 0.0, (z + SLAB) / 2.0)) for s in (-1.0, 1.0)]
    rims += [box_shape((x - 2.0 * RIM, RIM, z - SLAB), (0.0, s * (y - RIM) / 2.0, (z + SLAB) / 2.0)) for s in (-1.0, 1.0)]
    side = NECK * 2.0**0.5 / 2.0
    post = lathe([(side, -TRAVEL - 0.02), (side, -0.004), (side + 0.01, -0.0005), (0.0, -0.0005)], 4, phase=np.pi / 4.0)
    visuals = (
        Visual(mesh_shape("tray", merge(box(shape.size, shape.xyz) for shape in (slab, *rims))), patterned(STEEL, "brushed")),
        Visual(mesh_shape("post", post), STEEL),
    )
    return Link("tray_link", 0.2, visuals, (slab, *rims), friction=0.9)


def _needle_link() -> Link:
    hand = hull_of(
        np.array([(x, y, z) for x in (-0.004, -0.0032) for y, z in ((-0.005, -0.012), (0.005, -0.012), (0.0, NEEDLE))])
    )
    behind = hand.moved((2.0 * BODY[0] / 2.0 + 0.0072, 0.0, 0.0))
    hub = cylinder(0.006, 0.003, 14).moved((-0.004, 0.0, 0.0), (0.0, np.pi / 2.0, 0.0))
    return Link("needle_link", 0.02, (Visual(mesh_shape("needle", merge([hand, hub, behind])), RED),), center=(0.0, 0.0, 0.0))


def _scales() -> Model:
    dial = _facing(lathe([(DIAL_RADIUS, 0.0), (DIAL_RADIUS, 0.002), (0.0, 0.002)], 24), 0.0)
    behind = _marks(-1.0).moved((-DIAL[0] + 0.0022, 0.0, DIAL[2]))
    marks = _marks(1.0).moved((-DIAL[0] + 0.0022, 0.0, DIAL[2])).moved(rpy=(0.0, 0.0, np.pi))
    rim = _facing(
        lathe([(DIAL_RADIUS + 0.003, 0.0), (DIAL_RADIUS + 0.003, 0.005), (DIAL_RADIUS, 0.005), (DIAL_RADIUS, 0.0)], 24), 0.0
    )
    far_rim = rim.moved(rpy=(0.0, 0.0, np.pi))
    edge = NECK * 2.0**0.5 / 2.0
    collar = lathe([(edge + 0.008, BODY[2]), (edge + 0.007, BODY[2] + 0.0025), (edge, BODY[2] + 0.0025)], 4, phase=np.pi / 4.0)
    visuals = (
        Visual(mesh_shape("shell", _shell()), SHELL, crease=0.3),
        Visual(mesh_shape("dial", merge([dial, dial.moved(rpy=(0.0, 0.0, np.pi))])), CREAM),
        Visual(mesh_shape("marks", merge([marks, behind])), DARK),
        Visual(mesh_shape("rims", merge([rim, far_rim])), STEEL),
        Visual(mesh_shape("collar", collar), DARK),
    )
    base = Link("scales", 3.0, visuals, (box_shape(BODY, (0.0, 0.0, BODY[2] / 2.0)),))
    tray = Joint("tray", "prismatic", "scales", "tray_link", (0.0, 0.0, TRAY_HEIGHT), (0.0, 0.0, -1.0), 0.0, TRAVEL)
    needle = Joint("needle", "revolute", "scales", "needle_link", DIAL, (-1.0, 0.0, 0.0), -6.3, 6.3)
    notes = (
        "dials towards -x and, the other way round, towards x; joint `tray` increases as the tray sinks: give it a spring",
        "joint `needle` points up at 0, less is clockwise for a viewer in front; lock it and let the task set it",
        f"tray {TRAY}: link `tray_link` has its origin at the centre of its underside, objects rest at z = {SLAB}; mass 0.2",
        f"needle {NEEDLE} long, only seen; dial centre {DIAL}",
    )
    return Model("scales", "objects/scales", "bottom centre", (base, _tray_link(), _needle_link()), (tray, needle), notes)


def _flesh() -> Mesh:
    """Return a fruit with four lobes."""
    outline = [(0.0, PEPPER_LOW + 0.004), (0.012, PEPPER_LOW), (0.022, PEPPER_LOW + 0.004), (0.0275, -0.014), (0.030, 0.008)]
    outline += [(0.028, 0.021), (0.020, PEPPER_HIGH), (0.008, PEPPER_HIGH - 0.004), (0.0, PEPPER_HIGH - 0.006)]
    mesh = lathe(outline, 24)
    angles = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])
    bulge = 1.0 - 0.09 * np.cos(2.0 * angles) ** 8
    return Mesh(mesh.vertices * np.column_stack([bulge, bulge, np.ones(len(bulge))]), mesh.faces)


def _pepper(color: str) -> Model:
    stem = merge(
        [
            rod((0.0, 0.0, PEPPER_HIGH - 0.008), (0.003, 0.0, 0.040), 0.004, 8),
            cylinder(0.011, 0.003, 10).moved((0.0, 0.0, 0.0265)),
        ]
    )
    name = f"pepper_{color}"
    visuals = (
        Visual(mesh_shape("flesh", _flesh()), PEPPERS[color], crease=1.0),
        Visual(mesh_shape("stem", stem), (0.25, 0.42, 0.12)),
    )
    middle = (PEPPER_LOW + PEPPER_HIGH) / 2.0
    collisions = (
        cylinder_shape(0.022, PEPPER_HIGH - PEPPER_LOW, (0.0, 0.0, middle)),
        cylinder_shape(PEPPER_RADIUS, 0.040, (0.0, 0.0, 0.002)),
        sphere_shape(0.005, (0.002, 0.0, 0.035)),
    )
    link = Link(name, 0.15, visuals, collisions, friction=1.0, center=(0.0, 0.0, -0.005))
    notes = (
        f"rests with its origin at {-PEPPER_LOW} m; {2 * PEPPER_RADIUS} wide, top of the stem at z = 0.040; grasp at z = 0.012",
    )
    return Model(name, f"objects/{name}", "centre of the fruit", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_scales(), *(_pepper(color) for color in PEPPERS))
