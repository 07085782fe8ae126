"""A table lamp with a cable to its button: a foot, a bulb that looks out of a cone of cloth, both recoloured as light."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from assets_lib.mesh import Mesh, hull_of, lathe, merge, rod
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
    Shape,
    Vec3,
    Visual,
    cylinder_shape,
    mesh_shape,
    metal,
    patterned,
    plastic,
    shining,
    sphere_shape,
)

FOOT_RADIUS, FOOT_HEIGHT, STEM_RADIUS = 0.055, 0.018, 0.008
SOCKET_RADIUS, SOCKET_LOW, SOCKET_TOP = 0.015, 0.118, 0.150
BULB_RADIUS, BULB_HEIGHT = 0.025, 0.185
"""Of the glass, and height of its middle [m]."""
SHADE_LOW, SHADE_TOP, SHADE_WALL = (0.078, 0.115), (0.046, 0.195), 0.002
"""Outer radius and height of the lower and the upper edge of the shade, and its thickness [m]."""
SEGMENTS = 10
CABLE: tuple[Vec3, ...] = (
    (-0.050, 0.0, 0.004),
    (-0.090, -0.022, 0.004),
    (-0.130, -0.026, 0.004),
    (-0.160, -0.012, 0.004),
    (-0.182, 0.0, 0.006),
)
"""Along x, to a button whose pedestal ends there."""
ENAMEL, BRASS, BLACK = plastic((0.05, 0.22, 0.26)), metal((0.83, 0.62, 0.20)), (0.12, 0.12, 0.13)
FROSTED, CLOTH = (0.80, 0.79, 0.76), (0.93, 0.85, 0.73)
GLOW, LIT_CLOTH = (1.0, 0.97, 0.88), (0.88, 0.71, 0.44)
"""Colours of the bulb and the shade while they shine."""


def _foot() -> Mesh:
    low, rim = 0.010, FOOT_RADIUS - 0.010
    return lathe([(0.0, 0.0), (FOOT_RADIUS, 0.0), (FOOT_RADIUS, low), (rim, FOOT_HEIGHT - 0.002), (0.0, FOOT_HEIGHT)], 24)


def _stem() -> Mesh:
    """Return the post, a ring at its foot and the socket of the bulb."""
    low = FOOT_HEIGHT - 0.002
    ring = [(0.0, low), (0.018, low), (0.018, low + 0.004), (STEM_RADIUS, low + 0.012), (STEM_RADIUS, SOCKET_LOW)]
    outline = [*ring, (SOCKET_RADIUS, SOCKET_LOW + 0.008), (SOCKET_RADIUS, SOCKET_TOP), (0.0, SOCKET_TOP)]
    spokes = []
    (low_radius, low_height), (top_radius, top_height) = SHADE_LOW, SHADE_TOP
    height = SOCKET_LOW + 0.014
    reach = low_radius + (top_radius - low_radius) * (height - low_height) / (top_height - low_height) - SHADE_WALL
    for k in range(3):
        angle = 2.0 * np.pi * k / 3.0
        spokes.append(rod((0.0, 0.0, height), (reach * np.cos(angle), reach * np.sin(angle), height), 0.0015, 5))
    return merge([lathe(outline, 16), *spokes])


def _bulb() -> Mesh:
    """Return the glass: a ball on a neck."""
    angles = np.linspace(-0.75, np.pi / 2.0, 8)
    ball = [(BULB_RADIUS * float(np.cos(a)), BULB_HEIGHT + BULB_RADIUS * float(np.sin(a))) for a in angles[:-1]]
    return lathe([(0.0, SOCKET_TOP - 0.002), (0.0125, SOCKET_TOP - 0.002), *ball, (0.0, BULB_HEIGHT + BULB_RADIUS)], 16)


def _shade() -> Mesh:
    """Return the cone, open above and below."""
    (low, z), (top, rim) = SHADE_LOW, SHADE_TOP
    corners = [(low, z), (top, rim), (top - SHADE_WALL, rim), (low - SHADE_WALL, z), (low, z)]
    return lathe(corners, 32)


def _shade_shapes() -> tuple[Shape, ...]:
    """Return the cone as convex panels."""
    half = np.pi / SEGMENTS
    corners = [
        (radius - inwards, side * radius * float(np.tan(half)), z)
        for radius, z in (SHADE_LOW, SHADE_TOP)
        for side in (-1.0, 1.0)
        for inwards in (0.0, SHADE_WALL)
    ]
    panel = hull_of(np.array(corners))
    return tuple(mesh_shape("shade_panel", panel, rpy=(0.0, 0.0, 2.0 * float(half) * k)) for k in range(SEGMENTS))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    cable = merge(rod(a, b, 0.003, 6) for a, b in pairwise(CABLE))
    visuals = (
        Visual(mesh_shape("foot", _foot()), ENAMEL),
        Visual(mesh_shape("stem", _stem()), BRASS),
        Visual(mesh_shape("cable", cable), BLACK),
    )
    solid = (
        cylinder_shape(FOOT_RADIUS, FOOT_HEIGHT, (0.0, 0.0, FOOT_HEIGHT / 2.0)),
        cylinder_shape(STEM_RADIUS, SOCKET_LOW - FOOT_HEIGHT, (0.0, 0.0, (SOCKET_LOW + FOOT_HEIGHT) / 2.0)),
        cylinder_shape(SOCKET_RADIUS, SOCKET_TOP - SOCKET_LOW, (0.0, 0.0, (SOCKET_TOP + SOCKET_LOW) / 2.0)),
    )
    shade = Visual(mesh_shape("shade", _shade()), patterned(shining(CLOTH, emission=LIT_CLOTH), "cloth"))
    bulb = Visual(mesh_shape("bulb", _bulb()), shining(FROSTED, emission=GLOW, reach=0.28), crease=1.2)
    links = (
        Link("stand", 1.2, visuals, solid, friction=0.5),
        Link(
            "shade",
            0.08,
            (shade,),
            _shade_shapes(),
            friction=0.5,
        ),
        Link(
            "bulb",
            0.03,
            (bulb,),
            (_ball_shape(),),
            friction=0.5,
        ),
    )
    joints = tuple(Joint(f"{child}_holder", "fixed", "stand", child, (0.0, 0.0, 0.0)) for child in ("shade", "bulb"))
    notes = (
        f"shade of radius {SHADE_LOW[0]} at z = {SHADE_LOW[1]} to {SHADE_TOP[0]} at z = {SHADE_TOP[1]}, hollow; the bulb, "
        f"of diameter {2 * BULB_RADIUS}, ends at z = {BULB_HEIGHT + BULB_RADIUS:.3f}",
        f"the cable runs along -x to x = {CABLE[-1][0]}, where the pedestal of a `button` may begin",
        "recolour the links `bulb` and `shade` together: that is the light",
    )
    return (Model("desk_lamp", "objects/desk_lamp", "bottom centre", links, joints, notes),)


def _ball_shape() -> Shape:
    return sphere_shape(BULB_RADIUS, (0.0, 0.0, BULB_HEIGHT))
