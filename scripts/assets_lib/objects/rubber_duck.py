"""A rubber duck."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, hull_of, icosphere, merge
from assets_lib.urdf import Link, Model, Vec3, Visual, glossy, mesh_shape

LENGTH, WIDTH = 0.08, 0.052
"""Length and width of the body [m]."""
HEAD = 0.02
"""Radius of the head [m]."""
NECK = (0.015, 0.0, 0.051)
"""Middle of the head [m]."""
SKIN = 0.001
"""Skin that PyBullet puts around collision meshes [m]."""
YELLOW, ORANGE, BLACK = glossy((0.98, 0.80, 0.08)), glossy((0.95, 0.45, 0.06)), glossy((0.04, 0.04, 0.04))


def _even(count: int) -> FloatArray:
    """Return points spread evenly over the unit sphere, on a spiral of the golden angle."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    angle, ring = np.arange(count) * np.pi * (3.0 - 5.0**0.5), np.sqrt(1.0 - z * z)
    return np.column_stack([ring * np.cos(angle), ring * np.sin(angle), z])


def _body(points: FloatArray, shrink: float = 0.0) -> FloatArray:
    """Move points of the unit sphere onto the body: an egg with a flat bottom, its tail lifted."""
    x, y, z = points.T
    half, wide = LENGTH / 2.0, WIDTH / 2.0
    tail = np.clip(-x, 0.0, 1.0)
    width = wide * (1.0 - 0.45 * tail**3)
    low = np.where(z < 0.0, 0.018 * (1.0 - 0.35 * tail**2), 0.021)
    lift = 0.020 + 0.021 * tail**2.5
    moved = np.column_stack([(half - shrink) * x, (width - shrink) * y, lift + (low - shrink) * z])
    moved[:, 2] = np.maximum(moved[:, 2], 0.004 + shrink)
    return moved - (0.0, 0.0, 0.004)


def _ellipsoid(center: Vec3, radii: Vec3, fine: int) -> Mesh:
    return icosphere(1.0, fine).scaled(radii).moved(center)


def _wing(side: int) -> Mesh:
    """Return a folded wing, its tip towards the tail."""
    x, y, z = icosphere(1.0, 1).vertices.T
    tip = np.clip(-x, 0.0, 1.0)
    shape = np.column_stack([0.021 * x, 0.005 * y, 0.011 * z * (1.0 - 0.5 * tip) + 0.009 * tip**2])
    return hull_of(np.round(shape, 6)).moved((-0.006, side * (WIDTH / 2.0 - 0.003), 0.020), (0.0, 0.0, side * 0.1))


def _bill() -> Mesh:
    """Return the two halves of the bill, broad and flat."""
    x, _, z = NECK
    upper = _ellipsoid((x + HEAD, 0.0, z - 0.003), (0.013, 0.010, 0.0038), 1)
    lower = _ellipsoid((x + HEAD - 0.002, 0.0, z - 0.0085), (0.0095, 0.0085, 0.003), 1)
    return merge([upper, lower])


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    x, _, z = NECK
    ball = icosphere(1.0, 2)
    body = Mesh(_body(ball.vertices), ball.faces)
    eyes = merge(_ellipsoid((x + 0.0125, s * 0.0115, z + 0.007), (0.0035, 0.0035, 0.0045), 0) for s in (-1, 1))
    visuals = (
        Visual(mesh_shape("body", body), YELLOW, crease=1.0),
        Visual(mesh_shape("head", ball.scaled((HEAD, HEAD, HEAD)).moved(NECK)), YELLOW, crease=3.0),
        Visual(mesh_shape("wings", merge([_wing(s) for s in (-1, 1)])), YELLOW, crease=3.0),
        Visual(mesh_shape("bill", _bill()), ORANGE, crease=3.0),
        Visual(mesh_shape("eyes", eyes), BLACK, crease=3.0),
    )
    coarse = icosphere(1.0, 1).vertices
    hull = hull_of(np.round(_body(_even(110), SKIN), 6))
    head = hull_of(np.round(coarse * (HEAD - SKIN) + NECK, 6))
    bill = hull_of(np.round(_bill().vertices, 6))
    shapes = (mesh_shape("body_hull", hull), mesh_shape("head_hull", head), mesh_shape("bill_hull", bill))
    link = Link("rubber_duck", 0.05, visuals, shapes, friction=0.9)
    notes = (
        f"looks towards +x; {LENGTH} long, {WIDTH} wide, flat below",
        f"head {2.0 * HEAD} across, its middle at {NECK}: grasp it across y",
    )
    return (Model("rubber_duck", "objects/rubber_duck", "bottom centre", (link,), notes=notes),)
