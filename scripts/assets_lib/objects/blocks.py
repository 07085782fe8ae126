"""Coloured cubes, floating balls and flat squares."""

from __future__ import annotations

from assets_lib.mesh import icosphere
from assets_lib.urdf import Link, Model, Visual, box_shape, mesh_shape

RED = (0.9, 0.1, 0.1)
CUBES = (("cube", 0.05, 0.1), ("cube_small", 0.04, 0.05), ("cube_45", 0.045, 0.06), ("block_60", 0.06, 0.12))
"""Name, side [m], mass [kg]."""
BALLS = (("ball_marker", 0.05), ("ball_marker_60", 0.06))
"""Name, diameter [m]."""


def cube(name: str, side: float, mass: float) -> Model:
    """Return a plain cube."""
    shape = box_shape((side, side, side))
    link = Link(name, mass, (Visual(shape, RED),), (shape,), friction=0.8)
    return Model(name, f"objects/{name}", "centre", (link,), notes=(f"rests with its origin at {side / 2} m",))


def ball_marker(name: str, diameter: float) -> Model:
    """Return a ball that is only seen."""
    shape = mesh_shape("ball", icosphere(diameter / 2.0, 2))
    link = Link(name, 0.01, (Visual(shape, RED, crease=3.0),))
    return Model(name, f"objects/{name}", "centre", (link,), notes=("visual only: use it with fixed = true",))


def target_square() -> Model:
    """Return a flat green square that is only seen."""
    shape = box_shape((0.10, 0.10, 0.002), (0.0, 0.0, 0.001))
    link = Link("target_square", 0.01, (Visual(shape, (0.1, 0.75, 0.2)),))
    notes = ("visual only: use it with fixed = true", "its upper side is 2 mm above the table")
    return Model("target_square", "objects/target_square", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (*(cube(*c) for c in CUBES), *(ball_marker(*b) for b in BALLS), target_square())
