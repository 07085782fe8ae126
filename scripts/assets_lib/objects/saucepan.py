"""A saucepan with a long handle, and its lid."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, cylinder, lathe, merge, rod
from assets_lib.urdf import Joint, Link, Model, Shape, Visual, box_shape, cylinder_shape, mesh_shape, metal, plastic

RADIUS, HEIGHT, WALL, FLOOR = 0.09, 0.09, 0.005, 0.006
SEGMENTS = 16
STEEL, DARK = metal((0.66, 0.68, 0.71)), plastic((0.12, 0.12, 0.13))
RED = (0.72, 0.12, 0.10)
KNOB_RADIUS, KNOB_LENGTH, NECK, LID = 0.015, 0.025, 0.008, 0.01
KNOB_HEIGHT = HEIGHT + LID + NECK + KNOB_LENGTH / 2.0
"""Height of the knob centre when the lid lies on the pan [m]."""


def wall_boxes(radius: float, height: float, wall: float, bottom: float, segments: int) -> tuple[Shape, ...]:
    """Return upright boxes around a circle of outer `radius`, from `bottom` to `height`."""
    middle = radius - wall / 2.0
    length = 2.0 * radius * float(np.tan(np.pi / segments)) * 0.99
    shapes = []
    for i in range(segments):
        angle = 2.0 * float(np.pi) * i / segments
        place = (middle * float(np.cos(angle)), middle * float(np.sin(angle)), (bottom + height) / 2.0)
        shapes.append(box_shape((wall, length, height - bottom), place, (0.0, 0.0, angle)))
    return tuple(shapes)


def _pot() -> Mesh:
    """Return the hollow vessel with a rounded foot and a rolled rim."""
    inner = RADIUS - WALL
    outer = [(0.0, 0.0), (RADIUS - 0.008, 0.0), (RADIUS - 0.001, 0.008), (RADIUS - 0.001, HEIGHT - 0.005)]
    outer.append((RADIUS + 0.002, HEIGHT))
    return lathe([*outer, (inner, HEIGHT), (inner, FLOOR), (0.0, FLOOR)], 28)


def _handle() -> tuple[Mesh, Mesh]:
    """Return the steel socket and the dark grip of the handle, along +x."""
    socket = box((0.045, 0.016, 0.008), (RADIUS + 0.018, 0.0, 0.072))
    end = rod((0.237, 0.0, 0.067), (0.237, 0.0, 0.081), 0.012, 12)
    grip = merge([box((0.11, 0.024, 0.014), (RADIUS + 0.092, 0.0, 0.074)), end])
    return socket, grip


def _pan() -> Model:
    socket, grip = _handle()
    visuals = (
        Visual(mesh_shape("pot", _pot()), STEEL),
        Visual(mesh_shape("socket", socket), STEEL),
        Visual(mesh_shape("grip", grip), DARK),
    )
    collisions = (
        cylinder_shape(RADIUS - 0.001, FLOOR, (0.0, 0.0, FLOOR / 2.0)),
        *wall_boxes(RADIUS, HEIGHT, WALL, FLOOR, SEGMENTS),
        box_shape((0.165, 0.024, 0.014), (RADIUS + 0.0765, 0.0, 0.074)),
    )
    notes = (
        f"hollow; rim at z = {HEIGHT}, inner radius {RADIUS - WALL:.3f}",
        "handle along +x, its grip from x = 0.127 to 0.249 at z = 0.074",
        f"closed lid: place `saucepan_lid` at (0, 0, {KNOB_HEIGHT:.4f}) in the pan's frame",
    )
    return Model("saucepan", "objects/saucepan", "bottom centre", (Link("saucepan", 0.9, visuals, collisions),), notes=notes)


def _lid() -> Model:
    top = -KNOB_LENGTH / 2.0 - NECK
    z = [(RADIUS - 0.012, top - LID - 0.004), (RADIUS - 0.012, top - LID), (RADIUS, top - LID), (RADIUS, top - LID + 0.003)]
    plate = lathe([(0.0, top - LID - 0.004), *z, (RADIUS - 0.02, top - 0.003), (0.03, top), (0.0, top)], 28)
    knob = cylinder(KNOB_RADIUS, KNOB_LENGTH, 18, bevel=0.004)
    neck = cylinder(0.008, NECK, 12).moved((0.0, 0.0, top + NECK / 2.0))
    grip = (cylinder_shape(KNOB_RADIUS, KNOB_LENGTH), cylinder_shape(0.008, NECK + 0.002, (0.0, 0.0, top + NECK / 2.0)))
    cover = (
        cylinder_shape(RADIUS, LID, (0.0, 0.0, top - LID / 2.0)),
        cylinder_shape(RADIUS - 0.012, 0.004, (0.0, 0.0, top - LID - 0.002)),
    )
    notes = (
        f"knob diameter {2 * KNOB_RADIUS}, height {KNOB_LENGTH}; its centre is {-top:.4f} above the plate's upper side",
        "a 4 mm step below the plate keeps the lid on the pan",
    )
    links = (
        Link("knob", 0.02, (Visual(mesh_shape("knob", merge([knob, neck])), DARK),), grip, friction=1.0),
        Link("cover", 0.23, (Visual(mesh_shape("lid", plate), metal((0.74, 0.76, 0.79))),), cover, friction=1.0),
    )
    joint = Joint("weld", "fixed", "knob", "cover", (0.0, 0.0, 0.0))
    return Model("saucepan_lid", "objects/saucepan_lid", "centre of the knob", links, (joint,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_pan(), _lid())
