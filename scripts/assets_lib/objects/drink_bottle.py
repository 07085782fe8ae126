"""A bottle of lemonade with a label and a cap."""

from __future__ import annotations

from assets_lib.mesh import Mesh, cylinder, lathe, merge, rod
from assets_lib.urdf import Link, Model, Visual, cylinder_shape, mesh_shape, pane, plastic

RADIUS, SHOULDER, NECK_RADIUS, NECK, HEIGHT = 0.03, 0.115, 0.0115, 0.16, 0.18
"""Of the belly, height where it ends, radius of the neck, height of its rim, height with the cap [m]."""
CAP_RADIUS = 0.0145
LABEL = (0.035, 0.095)
"""Lowest and highest z of the label [m]."""
LEMONADE, PAPER, GREEN, WHITE = pane((0.80, 0.80, 0.42), 0.8), (0.94, 0.93, 0.88), (0.24, 0.44, 0.30), plastic((0.88, 0.89, 0.90))


def _glass() -> Mesh:
    """Return the bottle below its cap."""
    belly = [(0.0, 0.0), (RADIUS - 0.004, 0.0), (RADIUS - 0.001, 0.0015), (RADIUS, 0.005), (RADIUS, SHOULDER)]
    neck = [(0.0285, 0.122), (0.0225, 0.133), (0.0155, 0.143), (NECK_RADIUS, 0.152), (NECK_RADIUS, NECK), (0.0, NECK)]
    return lathe([*belly, *neck], 22)


def _band(radius: float, low: float, high: float) -> Mesh:
    """Return a closed ring around the bottle."""
    return lathe([(0.0, low), (radius, low), (radius, high), (0.0, high)], 22)


def _cap() -> Mesh:
    """Return the cap with its ribs."""
    body = cylinder(CAP_RADIUS - 0.0008, HEIGHT - NECK + 0.003, 16, bevel=0.002).moved((0.0, 0.0, (HEIGHT + NECK - 0.003) / 2.0))
    rib = rod((CAP_RADIUS - 0.001, 0.0, NECK), (CAP_RADIUS - 0.001, 0.0, HEIGHT - 0.004), 0.0009, 4)
    return merge([body, *(rib.moved(rpy=(0.0, 0.0, 0.7854 * k)) for k in range(8))])


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    low, high = LABEL
    visuals = (
        Visual(mesh_shape("glass", _glass()), LEMONADE),
        Visual(mesh_shape("label", _band(RADIUS + 0.0004, low, high)), PAPER),
        Visual(mesh_shape("stripes", merge([_band(RADIUS + 0.0006, z, z + 0.009) for z in (low + 0.003, high - 0.012)])), GREEN),
        Visual(mesh_shape("cap", _cap()), WHITE),
    )
    shapes = (
        cylinder_shape(RADIUS, SHOULDER, (0.0, 0.0, SHOULDER / 2.0)),
        cylinder_shape(0.022, 0.024, (0.0, 0.0, SHOULDER + 0.012)),
        cylinder_shape(CAP_RADIUS, HEIGHT - 0.139, (0.0, 0.0, (HEIGHT + 0.139) / 2.0)),
    )
    notes = (f"diameter {2 * RADIUS} up to z = {SHOULDER}; with its cap {HEIGHT} high",)
    link = Link("bottle", 0.25, visuals, shapes, friction=1.0)
    return (Model("drink_bottle", "objects/drink_bottle", "bottom centre", (link,), notes=notes),)
