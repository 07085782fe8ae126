"""A framed picture with a hanging bar, a wall with a hook for it, and a rest on which it leans."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, cylinder, hull_of, icosphere, merge, rod
from assets_lib.urdf import Link, Model, Visual, box_shape, cylinder_shape, mesh_shape, metal, patterned, plastic

WIDTH, HEIGHT, DEPTH, BORDER = 0.20, 0.15, 0.015, 0.016
BAR = (DEPTH / 2.0 + 0.018, 0.0, 0.045)
"""Middle of the hanging bar behind the frame [m]."""
BAR_RADIUS, BAR_LENGTH = 0.0025, 0.08
WALL = (0.02, 0.50, 0.402)
PEG_ROOT, PEG_LENGTH, PEG_RADIUS, PEG_TILT = 0.38, 0.03, 0.005, np.pi / 6.0
"""Height at which the peg leaves the wall [m], its size [m] and its rise [rad]."""
LEAN = 0.17
"""Of the rest's back [rad]."""
CREAM, WHITE, STEEL, BRASS = (0.90, 0.86, 0.74), (0.97, 0.96, 0.93), metal((0.80, 0.82, 0.86)), metal((0.95, 0.70, 0.20))
BRONZE, WALNUT, GILT, BOARD, PLASTER = (
    metal((0.42, 0.29, 0.13)),
    patterned(plastic((0.34, 0.19, 0.10)), "wood"),
    plastic((0.86, 0.66, 0.25)),
    patterned((0.58, 0.42, 0.26), "cardboard"),
    (0.98, 0.93, 0.82),
)
SKY, HILLS = (0.52, 0.76, 0.92), (0.42, 0.40, 0.55)
HALF_PI = 1.57079633

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


def _moulding(profile: tuple[tuple[float, float], ...]) -> Mesh:
    """Return a profile (distance inwards from the outer edge, x) that runs around the frame, mitred at the corners."""
    rings = []
    for inwards, x in profile:
        y, z = WIDTH / 2.0 - inwards, HEIGHT / 2.0 - inwards
        rings.append([(x, -y, -z), (x, y, -z), (x, y, z), (x, -y, z)])
    faces, count = [], 4 * len(profile)
    for low in range(0, count, 4):
        high = (low + 4) % count
        for i in range(4):
            j = (i + 1) % 4
            faces += [(low + i, high + j, low + j), (low + i, high + i, high + j)]
    return Mesh(np.concatenate([np.array(ring) for ring in rings]), np.array(faces))


def _rails() -> tuple[Visual, ...]:
    """Return the dark outer moulding of the frame, whose front faces -x, and the gilt slip within it."""
    h = DEPTH / 2.0
    wood = ((0.0, h), (0.0, 0.003 - h), (0.003, -h), (0.007, -h), (0.0105, 0.0025 - h), (0.0105, h))
    gilt = ((0.0105, h), (0.0105, 0.0015 - h), (0.012, 0.001 - h), (BORDER, -0.0025), (BORDER, h))
    return (
        Visual(mesh_shape("rails", _moulding(wood)), WALNUT, crease=0.1),
        Visual(mesh_shape("slip", _moulding(gilt)), GILT, crease=0.1),
    )


def _merged(boxes: tuple[Box, ...]) -> Mesh:
    return merge(box(size, center) for size, center in boxes)


def _peak(y: float, width: float, height: float, x: float) -> Mesh:
    """Return a mountain of the picture."""
    low = -HEIGHT / 2.0 + BORDER + 0.018
    corners = [(y - width / 2.0, low), (y + width / 2.0, low), (y, low + height)]
    return hull_of(np.array([(x + t, cy, cz) for t in (-0.0004, 0.0004) for cy, cz in corners]))


def _picture() -> tuple[Visual, ...]:
    """Return a landscape; the front of the frame faces -x."""
    front, inner, tall = -0.0035, WIDTH - 2 * BORDER, HEIGHT - 2 * BORDER
    meadow = box((0.0008, inner, 0.03), (front - 0.0012, 0.0, -tall / 2.0 + 0.015))
    sun = cylinder(0.011, 0.0008, 16).moved((front - 0.0005, -0.05, 0.036), (0.0, HALF_PI, 0.0))
    return (
        Visual(mesh_shape("sky", box((0.008, inner + 0.006, tall + 0.006), (0.0005, 0.0, 0.0))), SKY),
        Visual(mesh_shape("sun", sun), (1.0, 0.85, 0.2)),
        Visual(
            mesh_shape("mountains", merge([_peak(0.03, 0.10, 0.07, front - 0.0006), _peak(-0.03, 0.08, 0.05, front - 0.0008)])),
            HILLS,
        ),
        Visual(mesh_shape("meadow", meadow), (0.30, 0.58, 0.25)),
    )


def _frame() -> Model:
    x, _, z = BAR
    bar = rod((x, -BAR_LENGTH / 2.0, z), (x, BAR_LENGTH / 2.0, z), BAR_RADIUS, 10)
    length = x - DEPTH / 2.0
    arms = tuple(
        ((length + BAR_RADIUS, 0.005, 0.005), (DEPTH / 2.0 + (length + BAR_RADIUS) / 2.0, s * BAR_LENGTH / 2.0, z))
        for s in (-1, 1)
    )
    visuals = (
        *_rails(),
        *_picture(),
        Visual(mesh_shape("board", box((0.002, WIDTH - 0.012, HEIGHT - 0.012), (DEPTH / 2.0 - 0.0005, 0.0, 0.0))), BOARD),
        Visual(mesh_shape("bar", merge([bar, _merged(arms)])), STEEL),
    )
    shapes = (
        box_shape((DEPTH, WIDTH, HEIGHT)),
        cylinder_shape(BAR_RADIUS, BAR_LENGTH, BAR, (HALF_PI, 0.0, 0.0)),
        *(box_shape(size, center) for size, center in arms),
    )
    notes = (
        f"front faces -x; {WIDTH} wide along y, {HEIGHT} high along z, {DEPTH} deep",
        f"hanging bar along y behind it, diameter {2 * BAR_RADIUS}, length {BAR_LENGTH}, middle {BAR}",
    )
    return Model(
        "picture_frame",
        "objects/picture_frame",
        "centre",
        (Link("frame", 0.15, visuals, shapes, center=(0.0, 0.0, 0.0)),),
        notes=notes,
    )


def _wall() -> Model:
    t, w, h = WALL
    end = (-PEG_LENGTH * np.cos(PEG_TILT), 0.0, PEG_ROOT + PEG_LENGTH * np.sin(PEG_TILT))
    panel: Box = (WALL, (t / 2.0, 0.0, h / 2.0))
    feet = tuple(((0.14, 0.04, 0.02), (t + 0.07, s * (w / 2.0 - 0.05), 0.01)) for s in (-1, 1))
    plate = cylinder(0.022, 0.004, 28, bevel=0.0015).moved((-0.001, 0.0, PEG_ROOT), (0.0, HALF_PI, 0.0))
    screws = [icosphere(0.003, 1).moved((-0.003, s * 0.014, PEG_ROOT)) for s in (-1, 1)]
    tip = icosphere(1.25 * PEG_RADIUS, 2).moved(end)
    visuals = (
        Visual(mesh_shape("panel", box(*panel)), PLASTER),
        Visual(mesh_shape("base", merge([box((0.004, w, 0.04), (-0.002, 0.0, 0.02)), _merged(feet)])), WHITE),
        Visual(mesh_shape("plate", merge([plate, *screws])), BRONZE),
        Visual(mesh_shape("peg", merge([rod((0.0, 0.0, PEG_ROOT), end, PEG_RADIUS, 18), tip])), BRASS),
    )
    middle = (end[0] / 2.0, 0.0, (PEG_ROOT + end[2]) / 2.0)
    peg = cylinder_shape(PEG_RADIUS, PEG_LENGTH, middle, (0.0, PEG_TILT - HALF_PI, 0.0))
    shapes = (box_shape(*panel), *(box_shape(size, center) for size, center in feet), peg)
    notes = (
        f"front faces -x and lies at x = 0; {w} wide along y, {h} high",
        f"the peg leaves it at z = {PEG_ROOT} and rises by {np.rad2deg(PEG_TILT):.0f} deg "
        f"to {tuple(round(float(v), 4) for v in end)}; diameter {2 * PEG_RADIUS}",
    )
    return Model(
        "hook_wall", "objects/hook_wall", "bottom centre of the front", (Link("wall", 5.0, visuals, shapes),), notes=notes
    )


def _rest() -> Model:
    back = box_shape((0.006, 0.12, 0.08), (0.020, 0.0, 0.046), (0.0, LEAN, 0.0))
    parts: tuple[Box, ...] = (
        ((0.07, 0.12, 0.008), (0.015, 0.0, 0.004)),
        ((0.006, 0.12, 0.012), (-0.017, 0.0, 0.014)),
    )
    visuals = (Visual(mesh_shape("stand", merge([_merged(parts), back.mesh()])), CREAM),)
    notes = (f"for a picture frame that stands on z = 0.008 and leans against its back, tilted by {LEAN} rad, towards +x",)
    shapes = (*(box_shape(size, center) for size, center in parts), back)
    return Model(
        "picture_rest", "objects/picture_rest", "bottom", (Link("rest", 0.5, visuals, shapes, friction=1.0),), notes=notes
    )


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return _frame(), _wall(), _rest()
