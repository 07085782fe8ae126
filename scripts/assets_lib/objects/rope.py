"""A rope of eighteen links, and a mark for its ends."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import cylinder, lathe
from assets_lib.urdf import Joint, Link, Model, Visual, cylinder_shape, mesh_shape

LINKS, RADIUS, PITCH = 18, 0.007, 0.022
GAP = 0.001
LEVEL = (0.0, float(np.pi / 2.0), 0.0)
BENT = (2, 8, 14)
"""Joints that bend up and down instead of sideways."""
WHITE, BLUE, RED = (0.90, 0.87, 0.78), (0.16, 0.30, 0.62), (0.82, 0.14, 0.12)


def _link(number: int) -> Link:
    """Return one link, its origin at the joint to the link before it, along +x."""
    middle = (PITCH / 2.0, 0.0, 0.0)
    core = cylinder(RADIUS, PITCH, 12).moved(rpy=LEVEL).moved(middle)
    end = number in (0, LINKS - 1)
    color = RED if end else (BLUE if number % 2 else WHITE)
    shape = cylinder_shape(RADIUS, PITCH - GAP, middle, LEVEL)
    return Link(f"link{number}", 0.02, (Visual(mesh_shape("strand", core), color),), (shape,), friction=0.6)


def _rope() -> Model:
    joints = []
    for i in range(1, LINKS):
        level = i - 1 in BENT
        limit, axis = (0.15, (0.0, 1.0, 0.0)) if level else (0.9, (0.0, 0.0, 1.0))
        joints.append(
            Joint(f"joint{i}", "revolute", f"link{i - 1}", f"link{i}", (PITCH, 0.0, 0.0), axis, -limit, limit, damping=0.0)
        )
    notes = (
        f"{LINKS} links of {PITCH} m in a row along +x, {LINKS * PITCH:.3f} m in all, {2 * RADIUS} thick; rests at z = {RADIUS}",
        f"joint1..joint{LINKS - 1} bend sideways; joint3, joint9 and joint15 bend a little up and down instead",
        "hold it by friction: an attachment would fix link0 alone",
    )
    links = tuple(_link(i) for i in range(LINKS))
    return Model("rope", "objects/rope", "outer end of the first link", links, tuple(joints), notes)


def _mark() -> Model:
    ring = lathe([(0.028, 0.0), (0.028, 0.0012), (0.015, 0.0012), (0.015, 0.0), (0.028, 0.0)], 28)
    dot = cylinder(0.006, 0.0012, 14).moved((0.0, 0.0, 0.0006))
    visuals = (Visual(mesh_shape("ring", ring), (0.05, 0.62, 0.22)), Visual(mesh_shape("dot", dot), (0.05, 0.62, 0.22)))
    return Model("ring_mark", "objects/ring_mark", "bottom centre", (Link("ring_mark", 0.01, visuals),), notes=("visual only",))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_rope(), _mark())
