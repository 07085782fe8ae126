"""A waste bin, a crumpled paper ball and a tomato."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, hull_of, icosphere, lathe, merge, rod
from assets_lib.urdf import Link, Model, Visual, cylinder_shape, mesh_shape, sphere_shape

TOP, BOTTOM, HEIGHT, WALL, FLOOR = 0.08, 0.066, 0.18, 0.004, 0.005
"""Radii of the bin above and below, height, thickness [m]."""
SEGMENTS = 12


def _shell() -> Mesh:
    """Return the hollow bin with a thick rim."""
    outer = [(0.0, 0.0), (BOTTOM, 0.0), (TOP - 0.002, HEIGHT - 0.012), (TOP, HEIGHT - 0.012), (TOP, HEIGHT)]
    return lathe([*outer, (TOP - WALL, HEIGHT), (BOTTOM - WALL, FLOOR), (0.0, FLOOR)], 40)


def _bands() -> Mesh:
    """Return two rings around the bin."""
    rings = []
    for z in (0.045, 0.12):
        r = BOTTOM + (TOP - 0.002 - BOTTOM) * z / (HEIGHT - 0.012)
        inner, outer = r - 0.001, r + 0.0012
        rings.append(lathe([(inner, z - 0.004), (outer, z - 0.004), (outer, z + 0.004), (inner, z + 0.004)], 40))
    return merge(rings)


def _segment() -> Mesh:
    """Return one wall segment around the x axis as a convex piece of eight corners."""
    half = np.pi / SEGMENTS
    corners = []
    for z, radius in ((0.0, BOTTOM), (HEIGHT, TOP)):
        for r in (radius, radius - WALL):
            corners += [[r, side * r * float(np.tan(half)), z] for side in (-1.0, 1.0)]
    return hull_of(np.round(np.array(corners), 5))


def _bin() -> Model:
    visuals = (
        Visual(mesh_shape("shell", _shell()), (0.28, 0.42, 0.50)),
        Visual(mesh_shape("bands", _bands()), (0.16, 0.25, 0.30)),
    )
    segment = _segment()
    walls = tuple(mesh_shape("segment", segment, rpy=(0.0, 0.0, 2.0 * float(np.pi) * i / SEGMENTS)) for i in range(SEGMENTS))
    link = Link("bin", 0.8, visuals, (cylinder_shape(BOTTOM, FLOOR, (0.0, 0.0, FLOOR / 2.0)), *walls))
    notes = (
        f"hollow, open above; inner radius {BOTTOM - WALL} at its floor (z = {FLOOR}) and {TOP - WALL} at its rim (z = {HEIGHT})",
    )
    return Model("bin", "objects/bin", "bottom centre", (link,), notes=notes)


def _paper() -> Mesh:
    """Return a crumpled ball about 0.05 across, flat below: sharp random ridges around hollows, flat shaded."""
    rng = np.random.default_rng(11)
    ball = icosphere(1.0, 2)
    hollows = icosphere(1.0, 1).vertices[::2] + 0.25 * rng.standard_normal((21, 3))
    hollows /= np.linalg.norm(hollows, axis=1, keepdims=True)
    near = np.sort(np.arccos(np.clip(ball.vertices @ hollows.T, -1.0, 1.0)), axis=1)
    ridge = np.exp(-(near[:, 1] - near[:, 0]) / 0.16)
    radii = 0.70 + 0.30 * ridge * rng.uniform(0.75, 1.0, len(ridge)) + 0.03 * rng.standard_normal(len(ridge))
    vertices = ball.vertices * radii[:, None]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    vertices = (vertices - (low + high) / 2.0) / (high - low).max() * 0.052
    vertices[:, 2] = np.maximum(vertices[:, 2], -0.0195)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    vertices = (vertices - (low + high) / 2.0) / (high - low) * np.array([0.05, 0.05, 0.044])
    return Mesh(np.round(vertices, 5), ball.faces)


def _rubbish() -> Model:
    paper = _paper()
    hull = hull_of(paper.vertices)
    visual = Visual(mesh_shape("paper", paper), (0.93, 0.92, 0.88), crease=0.15)
    shape, center = mesh_shape("paper_hull", hull), (0.0, 0.0, -0.002)
    link = Link("rubbish", 0.03, (visual,), (shape,), friction=1.0, rolling=0.001, center=center)
    notes = ("flat below: rests with its origin at 0.022 m; about 0.05 wide every way",)
    return Model("rubbish", "objects/rubbish", "centre", (link,), notes=notes)


def _tomato() -> Model:
    radius = 0.0275
    angles = np.linspace(-np.pi / 2, np.pi / 2, 9)
    profile = [(abs(float(np.cos(a))) * radius, float(np.sin(a)) * radius * 0.97) for a in angles]
    profile[0], profile[-1] = (0.0, -radius), (0.0, radius * 0.86)
    fruit = lathe(profile, 16)
    leaves = []
    for i in range(5):
        a = 2.0 * np.pi * i / 5
        tip = (0.016 * np.cos(a), 0.016 * np.sin(a), radius * 0.84)
        leaves.append(rod((0.0, 0.0, radius * 0.93), tip, 0.0022, 5))
    stem = rod((0.0, 0.0, radius * 0.85), (0.002, 0.0, radius * 1.2), 0.0018, 6)
    visuals = (
        Visual(mesh_shape("fruit", fruit), (0.86, 0.12, 0.08), crease=1.2),
        Visual(mesh_shape("leaves", merge([*leaves, stem])), (0.18, 0.48, 0.14)),
    )
    link = Link("tomato", 0.08, visuals, (sphere_shape(radius),), friction=0.8, rolling=0.002)
    return Model("tomato", "objects/tomato", "centre", (link,), notes=(f"rests with its origin at {radius} m",))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_bin(), _rubbish(), _tomato())
