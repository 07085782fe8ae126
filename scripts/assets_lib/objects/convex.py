"""Twenty-five random convex solids; with forty sizes each they make a thousand shapes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, hull_of, mass_properties
from assets_lib.urdf import Link, Model, Vec3, Visual, mesh_shape

COUNT = 25
LENGTH, ACROSS = (0.042, 0.058), (0.03, 0.045)
"""Ranges of the longest side and of the two others at scale 1 [m]."""
COLORS: tuple[Vec3, ...] = (
    (0.95, 0.80, 0.74),
    (0.72, 0.84, 0.94),
    (0.96, 0.90, 0.68),
    (0.76, 0.89, 0.74),
    (0.86, 0.78, 0.92),
    (0.95, 0.86, 0.76),
    (0.74, 0.90, 0.90),
    (0.80, 0.76, 0.72),
)
"""Pale colours, which are seen well before the saturated ones of trays."""


def _block(rng: np.random.Generator) -> FloatArray:
    """Return the corners of a box."""
    return np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


def _wedge(rng: np.random.Generator) -> FloatArray:
    """Return the corners of a box whose upper side is narrower than the lower."""
    corners = _block(rng)
    corners[corners[:, 2] > 0.0, 1] *= rng.uniform(0.15, 0.7)
    return corners


def _prism(rng: np.random.Generator) -> FloatArray:
    """Return a prism along x with five to eight sides."""
    sides = int(rng.integers(5, 9))
    angles = 2.0 * np.pi * (np.arange(sides) + 0.5) / sides
    return np.array([[x, np.cos(a), np.sin(a)] for x in (-1.0, 1.0) for a in angles])


def _pebble(rng: np.random.Generator) -> FloatArray:
    """Return random points of a sphere, flattened to facets."""
    points = rng.standard_normal((14, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


KINDS: tuple[Callable[[np.random.Generator], FloatArray], ...] = (_block, _wedge, _prism, _pebble, _pebble)


def _solid(number: int) -> Mesh:
    """Return solid `number`, long along x, its centre of mass at the origin."""
    rng = np.random.default_rng([23, number])
    points = KINDS[number % len(KINDS)](rng)
    low, high = points.min(axis=0), points.max(axis=0)
    size = np.array([rng.uniform(*LENGTH), rng.uniform(*ACROSS), rng.uniform(*ACROSS)])
    hull = hull_of(np.round((points - (low + high) / 2.0) / (high - low) * size, 5))
    center = mass_properties(hull)[1]
    return Mesh(np.round(hull.vertices - center, 5), hull.faces)


def _model(number: int) -> Model:
    name = f"convex_{number:02d}"
    solid = _solid(number)
    visual = Visual(mesh_shape(name, solid), COLORS[number % len(COLORS)], crease=0.05)
    link = Link(
        "solid", 0.1, (visual,), (mesh_shape(f"{name}_hull", solid),), friction=0.9, rolling=0.001, center=(0.0, 0.0, 0.0)
    )
    x, y, z = np.ptp(solid.vertices, axis=0)
    notes = (f"long side along x; {x:.3f} x {y:.3f} x {z:.3f} at scale 1; meant for scales 0.85..1.2",)
    return Model(name, "objects/convex", "centre of mass", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return tuple(_model(number) for number in range(COUNT))
