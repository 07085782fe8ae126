"""A notebook computer on a stand, its screen on a hinge."""

from __future__ import annotations

import numpy as np

from assets_lib.cabinets import bevelled_box
from assets_lib.mesh import Mesh, box, hull_of, lathe, merge, rod
from assets_lib.prisms import mark
from assets_lib.urdf import Joint, Link, Model, Visual, box_shape, mesh_shape

BASE, STAND = (0.18, 0.26, 0.015), (0.15, 0.20, 0.03)
SCREEN = (0.17, 0.26, 0.008)
"""Size when it is shut [m]."""
TOP = STAND[2] + BASE[2]
GAP = 0.002
"""Between the base and the shut screen [m]."""
HINGE = (BASE[0] / 2.0 - 0.006, 0.0, TOP + GAP + SCREEN[2] / 2.0)
CASE, STAND_COLOR, KEYS, BEZEL, PICTURE, LOGO = (
    (0.62, 0.64, 0.67),
    (0.17, 0.18, 0.20),
    (0.08, 0.08, 0.09),
    (0.05, 0.05, 0.06),
    (0.16, 0.55, 0.86),
    (0.90, 0.92, 0.94),
)

Span = tuple[float, float]
PLINTH, PLATE = (0.196, 0.276), (0.184, 0.264)
"""Size of the foot and of the upper side of the stand as it is seen, along x and y [m]; what collides is `STAND`."""


def _keys() -> Mesh:
    """Return four rows of keys, and the bar below them."""
    rows = [((0.014, 0.017, 0.0015), (0.048 - 0.02 * i, y, TOP + 0.00075)) for i in range(4) for y in _columns()]
    return merge(box(size, center) for size, center in (*rows, ((0.012, 0.10, 0.0015), (-0.031, 0.0, TOP + 0.00075))))


def _columns() -> tuple[float, ...]:
    return tuple(round(-0.1 + 0.0222 * i, 4) for i in range(10))


def _rectangle(size: Span, middle: Span, height: float) -> Mesh:
    """Return a flat mark on the inner side of the screen, so far before it, that is seen from this side alone."""
    x, y = (0.5 * length for length in size)
    corners = [(middle[0] + sx * x, -middle[1] + sy * y) for sx in (-1, 1) for sy in (-1, 1)]
    return mark(corners, SCREEN[2] / 2.0 + height, "z").moved(rpy=(np.pi, 0.0, 0.0))


def _windows() -> Mesh:
    """Return what the picture on the screen shows: two windows and a bar."""
    places = (((0.07, 0.10), (-0.10, 0.045)), ((0.045, 0.07), (-0.08, -0.065)), ((0.008, 0.22), (-0.021, 0.0)))
    return merge(_rectangle(size, middle, 0.0014) for size, middle in places)


def _lines() -> Mesh:
    """Return the titles of the windows and what is written in them, as bars."""
    bars: list[tuple[Span, Span]] = [((0.009, 0.10), (-0.1305, 0.045)), ((0.009, 0.07), (-0.098, -0.065))]
    bars += [((0.004, 0.08 - 0.012 * (i % 3)), (-0.115 + 0.010 * i, 0.049 + 0.006 * (i % 3))) for i in range(5)]
    bars += [((0.004, 0.05 - 0.014 * (i % 2)), (-0.086 + 0.010 * i, -0.065 + 0.007 * (i % 2))) for i in range(3)]
    return merge(_rectangle(size, middle, 0.0020) for size, middle in bars)


def _emblem() -> tuple[Mesh, Mesh]:
    """Return the raised emblem of the lid: a ring, and a bevelled disc in it."""
    x, z = -SCREEN[0] / 2.0, SCREEN[2] / 2.0
    ring = lathe([(0.021, 0.0), (0.021, 0.0010), (0.020, 0.0016), (0.017, 0.0016), (0.016, 0.0)], 20)
    disc = lathe([(0.010, 0.0), (0.010, 0.0008), (0.0085, 0.0016), (0.0, 0.0016)], 16)
    return ring.moved((x, 0.0, z)), disc.moved((x, 0.0, z))


def _stand() -> Mesh:
    """Return the stand: a plinth that narrows upwards to a plate a little larger than the base."""
    levels = ((PLINTH, 0.0), (PLINTH, 0.006), (PLATE, STAND[2] - 0.003), ((PLATE[0] - 0.006, PLATE[1] - 0.006), STAND[2]))
    corners = [(sx * x / 2.0, sy * y / 2.0, z) for (x, y), z in levels for sx in (-1, 1) for sy in (-1, 1)]
    return hull_of(np.round(np.array(corners), 6))


def _screen() -> Link:
    x = -SCREEN[0] / 2.0
    ring, disc = _emblem()
    pins = merge(rod((0.0, y - 0.02, 0.0), (0.0, y + 0.02, 0.0), 0.0052, 10) for y in (-0.085, 0.085))
    visuals = (
        Visual(mesh_shape("lid", bevelled_box(SCREEN, (x, 0.0, 0.0), 0.0015)), CASE),
        Visual(mesh_shape("bezel", _rectangle((0.160, 0.250), (x, 0.0), 0.0003)), BEZEL),
        Visual(mesh_shape("picture", _rectangle((0.142, 0.236), (x, 0.0), 0.0008)), PICTURE),
        Visual(mesh_shape("windows", _windows()), LOGO),
        Visual(mesh_shape("lines", _lines()), (0.36, 0.46, 0.56)),
        Visual(mesh_shape("ring", ring), LOGO),
        Visual(mesh_shape("disc", disc), PICTURE),
        Visual(mesh_shape("pins", pins), BEZEL),
    )
    return Link("screen", 0.3, visuals, (box_shape(SCREEN, (x, 0.0, 0.0)),))


def _base() -> Link:
    pad = box((0.04, 0.075, 0.0008), (-0.064, 0.0, TOP + 0.0004))
    feet = merge(
        rod((HINGE[0], y - 0.012, HINGE[2]), (HINGE[0], y + 0.012, HINGE[2]), 0.0045, 8) for y in (-0.115, -0.055, 0.055, 0.115)
    )
    base = (BASE, (0.0, 0.0, STAND[2] + BASE[2] / 2.0))
    stand = (STAND, (0.0, 0.0, STAND[2] / 2.0))
    visuals = (
        Visual(mesh_shape("base", bevelled_box(*base, 0.002)), CASE),
        Visual(mesh_shape("stand", _stand()), STAND_COLOR),
        Visual(mesh_shape("keys", _keys()), KEYS),
        Visual(mesh_shape("pad", pad), (0.48, 0.52, 0.57)),
        Visual(mesh_shape("knuckles", feet), CASE),
    )
    return Link("base", 2.0, visuals, (box_shape(*base), box_shape(*stand)))


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    hinge = Joint("screen_hinge", "revolute", "base", "screen", HINGE, (0.0, 1.0, 0.0), 0.0, 2.0, damping=0.01)
    notes = (
        f"the keyboard's near side faces -x; it lies on a stand {STAND[2]} high, its upper side at z = {TOP:.3f}",
        f"link `screen` has its origin on the hinge {tuple(round(v, 4) for v in HINGE)}; at 0 it is shut and spans "
        f"x -{SCREEN[0]}..0, y -+{SCREEN[1] / 2.0}, z -+{SCREEN[2] / 2.0} there; it opens upwards and backwards",
    )
    return (Model("laptop", "objects/laptop", "bottom centre of the stand", (_base(), _screen()), (hinge,), notes),)
