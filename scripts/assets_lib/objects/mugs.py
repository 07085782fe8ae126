"""A mug with a handle and a tree to hang mugs on."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, cylinder, icosphere, lathe, merge, rod
from assets_lib.objects.cups import leaning_walls
from assets_lib.urdf import Link, Model, Shape, Visual, box_shape, cylinder_shape, glass, mesh_shape, patterned

RADIUS, HEIGHT, WALL, FLOOR = 0.0325, 0.08, 0.004, 0.006
HOLE = (0.03, 0.04)
"""Free width beside the mug and height inside the handle [m]."""
BAR = 0.008
HOLE_HEIGHT = 0.042
"""Height of the middle of the hole [m]."""
FOOT, STEM, STEM_RADIUS = (0.07, 0.016), 0.28, 0.008
SPOKES, SPOKE, SPOKE_RADIUS = 4, 0.08, 0.006
"""Number, length and radius of the spokes [m]."""
STEEP, SHALLOW = (0.5, 0.215, 0.4), (0.2, 0.23, 0.8)
"""Slope of the spokes [rad], height at which their axes leave the stem [m], and friction: mugs slide to the stem, or stay."""


def _handle_shapes() -> tuple[Shape, ...]:
    """Return three bars around the hole, and where the upper and lower one meet the wall."""
    start = RADIUS - 0.003
    length = RADIUS + HOLE[0] + BAR - start
    levels = [HOLE_HEIGHT + s * (HOLE[1] + BAR) / 2.0 for s in (-1.0, 1.0)]
    bars = tuple(box_shape((length, BAR, BAR), (start + length / 2.0, 0.0, z)) for z in levels)
    return (*bars, box_shape((BAR, BAR, HOLE[1]), (RADIUS + HOLE[0] + BAR / 2.0, 0.0, HOLE_HEIGHT)))


def _handle() -> Mesh:
    """Return an ear with round corners."""
    out, half, cut = RADIUS + HOLE[0] + BAR / 2.0, (HOLE[1] + BAR) / 2.0, 0.010
    points = [(RADIUS - 0.003, -half), (out - cut, -half), (out, -half + cut), (out, half - cut), (out - cut, half)]
    points.append((RADIUS - 0.003, half))
    places = [(x, 0.0, HOLE_HEIGHT + z) for x, z in points]
    rods = [rod(a, b, BAR / 2.0, 10) for a, b in zip(places[:-1], places[1:], strict=True)]
    return merge([*rods, *(icosphere(BAR / 2.0, 1).moved(p) for p in places[1:-1])])


def _mug() -> Model:
    lip = WALL / 2.0
    outer = [(0.0, 0.0), (RADIUS - 0.003, 0.0), (RADIUS, 0.003), (RADIUS, HEIGHT - lip), (RADIUS - lip, HEIGHT)]
    inner = [(RADIUS - WALL, HEIGHT - lip), (RADIUS - WALL, FLOOR), (0.0, FLOOR)]
    band = lathe([(RADIUS, 0.014), (RADIUS + 0.0006, 0.014), (RADIUS + 0.0006, 0.024), (RADIUS, 0.024)], 28)
    visuals = (
        Visual(mesh_shape("mug", lathe([*outer, *inner], 28)), glass((0.25, 0.48, 0.72))),
        Visual(mesh_shape("handle", _handle()), glass((0.25, 0.48, 0.72))),
        Visual(mesh_shape("band", band), (0.95, 0.93, 0.86)),
    )
    foot = cylinder_shape(RADIUS * float(np.cos(np.pi / 12)), FLOOR, (0.0, 0.0, FLOOR / 2.0))
    shapes = (foot, *leaning_walls(RADIUS, RADIUS, HEIGHT, WALL, FLOOR), *_handle_shapes())
    link = Link("mug", 0.15, visuals, shapes, friction=0.5, center=(0.0, 0.0, 0.02))
    notes = (
        f"hollow, open above; outer radius {RADIUS}, rim at z = {HEIGHT}, heavy below",
        f"handle towards +x; its hole, {HOLE[0]} wide and {HOLE[1]} high, leads along y; middle at "
        f"({RADIUS + HOLE[0] / 2.0:.4f}, 0, {HOLE_HEIGHT})",
    )
    return Model("mug", "objects/mug", "bottom centre", (link,), notes=notes)


def spoke_tip(number: int, slant: float, height: float) -> tuple[float, float, float]:
    """Return the outer end of a spoke that leaves the stem at a height [m] with a slope [rad]."""
    a = 2.0 * float(np.pi) * number / SPOKES
    out = STEM_RADIUS + SPOKE * float(np.cos(slant))
    return (out * float(np.cos(a)), out * float(np.sin(a)), height + out * float(np.tan(slant)))


def _tree(name: str, slant: float, height: float, friction: float) -> Model:
    radius, tall = FOOT
    tips = [spoke_tip(i, slant, height) for i in range(SPOKES)]
    spokes = [rod((0.0, 0.0, height), tip, SPOKE_RADIUS, 10) for tip in tips]
    knobs = [icosphere(SPOKE_RADIUS, 1).moved(tip) for tip in tips]
    stem = cylinder(STEM_RADIUS, STEM - tall, 14).moved((0.0, 0.0, (STEM + tall) / 2.0))
    top = icosphere(0.012, 2).moved((0.0, 0.0, STEM + 0.006))
    visuals = (
        Visual(
            mesh_shape("foot", cylinder(radius, tall, 28, bevel=0.005).moved((0.0, 0.0, tall / 2.0))),
            patterned((0.27, 0.14, 0.08), "wood"),
        ),
        Visual(mesh_shape("stem", merge([stem, top])), patterned((0.36, 0.19, 0.10), "wood")),
        Visual(mesh_shape("spokes", merge([*spokes, *knobs])), (0.36, 0.19, 0.10)),
    )
    length = SPOKE + STEM_RADIUS / float(np.cos(slant))
    arms = []
    for i, (x, y, z) in enumerate(tips):
        place = (x / 2.0, y / 2.0, (height + z) / 2.0)
        arms.append(
            cylinder_shape(SPOKE_RADIUS, length, place, (0.0, float(np.pi / 2.0) - slant, 2.0 * float(np.pi) * i / SPOKES))
        )
    shapes = (
        cylinder_shape(radius, tall, (0.0, 0.0, tall / 2.0)),
        cylinder_shape(STEM_RADIUS, STEM - tall, (0.0, 0.0, (STEM + tall) / 2.0)),
        *arms,
    )
    notes = (
        f"{SPOKES} spokes towards +x, +y, -x, -y, {2 * SPOKE_RADIUS} thick, rising by {slant} rad",
        f"their axes leave the middle of the stem at z = {height}",
        f"outer end of the first spoke at ({tips[0][0]:.4f}, 0, {tips[0][2]:.4f})",
    )
    link = Link(name, 1.5, visuals, shapes, friction=friction)
    return Model(name, f"objects/{name}", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_mug(), _tree("mug_tree", *STEEP), _tree("mug_tree_shallow", *SHALLOW))
