"""A wine bottle and its screw cap, which turns on the neck and comes free when its five other joints are unlocked."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, lathe, merge
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, box_shape, cylinder_shape, glass, mesh_shape, metal

RADIUS, RIM = 0.0375, 0.24
"""Of the belly, and height of the rim [m]."""
SHOULDER, NECK_START, NECK = 0.15, 0.185, 0.0125
CAP_RADIUS, CAP_HEIGHT, CAP_WALL = 0.0175, 0.035, 0.003
GAP = 0.0005
"""Between the rim and the inside of the cap [m]."""
SIDES = 12
GREEN, PAPER, RED, GOLD = glass((0.08, 0.24, 0.12)), (0.93, 0.90, 0.80), (0.60, 0.07, 0.12), metal((0.85, 0.68, 0.28))


def _bottle() -> Mesh:
    outline = [(0.0, 0.0), (RADIUS - 0.003, 0.0), (RADIUS, 0.003), (RADIUS, SHOULDER), (0.034, 0.162), (0.024, 0.175)]
    return lathe([*outline, (0.0145, NECK_START), (NECK, 0.195), (NECK, RIM - 0.001), (NECK - 0.001, RIM), (0.0, RIM)], 32)


def _band(radius: float, low: float, high: float) -> Mesh:
    """Return a closed ring around the bottle."""
    return lathe([(0.0, low), (radius, low), (radius, high), (0.0, high)], 24)


def _mouth() -> tuple[Mesh, Mesh]:
    """Return the lip around the mouth, which the cap covers, and the dark opening."""
    lip = lathe([(NECK, RIM - 0.010), (NECK + 0.0014, RIM - 0.009), (NECK + 0.0014, RIM - 0.003), (NECK, RIM - 0.002)], 12)
    return lip, lathe([(NECK - 0.0035, RIM + 0.0003), (0.0, RIM + 0.0003)], 20)


def _emblem() -> Mesh:
    """Return a bunch of grapes, as small plates on the label."""
    places = [(0.0, 0.0), (-0.007, 0.009), (0.007, 0.009), (-0.014, 0.018), (0.0, 0.018), (0.014, 0.018)]
    boxes = []
    for turn in (0.0, np.pi):
        boxes += [
            box((0.0012, 0.009, 0.007), (RADIUS + 0.0007, y, 0.07 + z)).moved((0.0, 0.0, 0.0), (0.0, 0.0, turn))
            for y, z in places
        ]
    return merge(boxes)


def _bottle_link() -> Link:
    lip, mouth = _mouth()
    visuals = (
        Visual(mesh_shape("glass", _bottle()), GREEN),
        Visual(mesh_shape("lip", lip), (0.08, 0.24, 0.12)),
        Visual(mesh_shape("mouth", mouth), (0.01, 0.02, 0.01)),
        Visual(mesh_shape("label", _band(RADIUS + 0.0005, 0.045, 0.115)), PAPER),
        Visual(mesh_shape("stripe", merge([_band(RADIUS + 0.0008, 0.047, 0.052), _band(RADIUS + 0.0008, 0.108, 0.113)])), GOLD),
        Visual(mesh_shape("emblem", _emblem()), RED),
    )
    shapes = (
        cylinder_shape(RADIUS, SHOULDER, (0.0, 0.0, SHOULDER / 2.0)),
        cylinder_shape(0.030, 0.018, (0.0, 0.0, SHOULDER + 0.009)),
        cylinder_shape(0.020, 0.014, (0.0, 0.0, SHOULDER + 0.025)),
        cylinder_shape(NECK, RIM - 0.175, (0.0, 0.0, (RIM + 0.175) / 2.0)),
    )
    return Link("bottle", 0.8, visuals, shapes)


def _cap_shapes() -> tuple[Shape, ...]:
    """Return the lid and the wall of the hollow cap; the origin is its middle."""
    top = CAP_HEIGHT - _depth()
    middle = CAP_RADIUS - CAP_WALL / 2.0
    width = 2.0 * CAP_RADIUS * float(np.tan(np.pi / SIDES)) * 0.98
    walls = []
    for k in range(SIDES):
        angle = 2.0 * np.pi * k / SIDES
        place = (middle * float(np.cos(angle)), middle * float(np.sin(angle)), -top / 2.0)
        walls.append(box_shape((CAP_WALL, width, _depth()), place, (0.0, 0.0, angle)))
    return (cylinder_shape(CAP_RADIUS, top, (0.0, 0.0, (CAP_HEIGHT - top) / 2.0)), *walls)


def _depth() -> float:
    """Return how far the neck reaches into the cap [m]."""
    return CAP_HEIGHT - 0.006


def _cap_mesh() -> Mesh:
    top, inner = CAP_HEIGHT / 2.0, CAP_RADIUS - CAP_WALL
    roof = top - (CAP_HEIGHT - _depth())
    outline = [(0.0, roof), (inner, roof), (inner, -top), (CAP_RADIUS - 0.001, -top), (CAP_RADIUS, -top + 0.001)]
    return lathe([*outline, (CAP_RADIUS, top - 0.002), (CAP_RADIUS - 0.002, top), (0.0, top)], 24)


def _marks() -> Mesh:
    """Return a cross on the lid and ribs around, so that turning is seen."""
    lines = [box((0.026, 0.004, 0.001), (0.0, 0.0, CAP_HEIGHT / 2.0 + 0.0004))]
    for k in range(6):
        rib = box((0.0008, 0.002, 0.028), (CAP_RADIUS, 0.0, 0.0))
        lines.append(rib.moved((0.0, 0.0, 0.0), (0.0, 0.0, np.pi * k / 3.0)))
    return merge(lines)


def _chain() -> tuple[tuple[Link, ...], tuple[Joint, ...]]:
    """Return links and joints from the anchor on the neck to the cap: the turn, then the five that set it free."""
    steps = (
        ("turn", "revolute", (0.0, 0.0, 1.0), 3.3),
        ("lift", "prismatic", (0.0, 0.0, 1.0), 1.0),
        ("shift_x", "prismatic", (1.0, 0.0, 0.0), 1.0),
        ("shift_y", "prismatic", (0.0, 1.0, 0.0), 1.0),
        ("roll", "revolute", (1.0, 0.0, 0.0), 1.4),
        ("pitch", "revolute", (0.0, 1.0, 0.0), 1.4),
    )
    links, joints, parent = [], [], "anchor"
    for name, kind, axis, reach in steps:
        child = "cap" if name == "pitch" else f"{name}_link"
        joints.append(Joint(name, kind, parent, child, (0.0, 0.0, 0.0), axis, -reach, reach, damping=0.0005))
        if child != "cap":
            links.append(Link(child, 0.004, (), ()))
        parent = child
    return tuple(links), tuple(joints)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    between, joints = _chain()
    visuals = (Visual(mesh_shape("cap", _cap_mesh()), RED), Visual(mesh_shape("marks", _marks()), GOLD))
    cap = Link("cap", 0.03, visuals, _cap_shapes(), friction=1.0)
    height = RIM + GAP - _depth() + CAP_HEIGHT / 2.0
    bottle_notes = (
        f"belly of diameter {2 * RADIUS} up to z = {SHOULDER}, neck of diameter {2 * NECK} up to the rim at z = {RIM}",
        "the glass is solid",
    )
    cap_notes = (
        f"hollow from below, diameter {2 * CAP_RADIUS}, height {CAP_HEIGHT}; on the bottle its origin is at z = {height:.4f}",
        "link `anchor` stays, link `cap` moves on it: `turn` (the thread), then lift, shift_x, shift_y, roll, pitch; "
        "these five are locked while the cap is on, and unlocked the cap is as good as free",
    )
    bottle = Model("wine_bottle", "objects/wine_bottle", "bottom centre", (_bottle_link(),), notes=bottle_notes)
    origin = "middle of the cap"
    return bottle, Model("wine_cap", "objects/wine_cap", origin, (Link("anchor", 0.1, ()), *between, cap), joints, cap_notes)
