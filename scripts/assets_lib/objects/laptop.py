"""Notebook computers on a stand, their screens on hinges: a grey one, and a wide dark one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assets_lib.cabinets import bevelled_box
from assets_lib.mesh import Mesh, box, hull_of, lathe, merge, rod
from assets_lib.prisms import mark
from assets_lib.urdf import Joint, Link, Model, Paint, Visual, box_shape, mesh_shape, patterned, plastic

CASE, STAND_COLOR, KEYS, BEZEL, PICTURE, LOGO = (
    (0.62, 0.64, 0.67),
    (0.17, 0.18, 0.20),
    (0.08, 0.08, 0.09),
    (0.05, 0.05, 0.06),
    (0.16, 0.55, 0.86),
    (0.90, 0.92, 0.94),
)
GAP = 0.002
"""Between the base and the shut screen [m]."""

Span = tuple[float, float]
Vec3 = tuple[float, float, float]


@dataclass(frozen=True)
class Design:
    """How one notebook computer differs from another; the defaults are those of `laptop`. Lengths [m]."""

    name: str = "laptop"
    base: Vec3 = (0.18, 0.26, 0.015)
    stand: Vec3 = (0.15, 0.20, 0.03)
    """What collides; it looks larger."""
    screen: Vec3 = (0.17, 0.26, 0.008)
    """Size when it is shut."""
    columns: int = 10
    case: Vec3 = CASE
    stand_color: Vec3 | Paint = STAND_COLOR
    keys: Vec3 = KEYS
    pad: Vec3 = (0.48, 0.52, 0.57)
    picture: Vec3 = PICTURE
    logo: Vec3 = LOGO

    @property
    def top(self) -> float:
        """Height of the keyboard."""
        return self.stand[2] + self.base[2]

    @property
    def hinge(self) -> Vec3:
        """Where the screen turns."""
        return (self.base[0] / 2.0 - 0.006, 0.0, self.top + GAP + self.screen[2] / 2.0)


def _keys(design: Design) -> Mesh:
    """Return four rows of keys, and the bar below them."""
    top, first = design.top, design.base[0] / 2.0 - 0.042
    rows = [((0.014, 0.017, 0.0015), (round(first - 0.02 * i, 6), y, top + 0.00075)) for i in range(4) for y in _columns(design)]
    return merge(
        box(size, center) for size, center in (*rows, ((0.012, 0.10, 0.0015), (round(first - 0.079, 6), 0.0, top + 0.00075)))
    )


def _columns(design: Design) -> tuple[float, ...]:
    return tuple(round(0.0222 * (i - 0.5 * (design.columns - 1)) - 0.0001, 4) for i in range(design.columns))


def _rectangle(design: Design, size: Span, middle: Span, height: float) -> Mesh:
    """Return a flat mark on the inner side of the screen, so far before it, that is seen from this side alone."""
    x, y = (0.5 * length for length in size)
    corners = [(middle[0] + sx * x, -middle[1] + sy * y) for sx in (-1, 1) for sy in (-1, 1)]
    return mark(corners, design.screen[2] / 2.0 + height, "z").moved(rpy=(np.pi, 0.0, 0.0))


def _windows(design: Design) -> Mesh:
    """Return what the picture on the screen shows: two windows and a bar."""
    places = (((0.07, 0.10), (-0.10, 0.045)), ((0.045, 0.07), (-0.08, -0.065)), ((0.008, 0.22), (-0.021, 0.0)))
    return merge(_rectangle(design, size, middle, 0.0014) for size, middle in places)


def _lines(design: Design) -> Mesh:
    """Return the titles of the windows and what is written in them, as bars."""
    bars: list[tuple[Span, Span]] = [((0.009, 0.10), (-0.1305, 0.045)), ((0.009, 0.07), (-0.098, -0.065))]
    bars += [((0.004, 0.08 - 0.012 * (i % 3)), (-0.115 + 0.010 * i, 0.049 + 0.006 * (i % 3))) for i in range(5)]
    bars += [((0.004, 0.05 - 0.014 * (i % 2)), (-0.086 + 0.010 * i, -0.065 + 0.007 * (i % 2))) for i in range(3)]
    return merge(_rectangle(design, size, middle, 0.0020) for size, middle in bars)


def _emblem(design: Design) -> tuple[Mesh, Mesh]:
    """Return the raised emblem of the lid: a ring, and a bevelled disc in it."""
    x, z = -design.screen[0] / 2.0, design.screen[2] / 2.0
    ring = lathe([(0.021, 0.0), (0.021, 0.0010), (0.020, 0.0016), (0.017, 0.0016), (0.016, 0.0)], 20)
    disc = lathe([(0.010, 0.0), (0.010, 0.0008), (0.0085, 0.0016), (0.0, 0.0016)], 16)
    return ring.moved((x, 0.0, z)), disc.moved((x, 0.0, z))


def _stand(design: Design) -> Mesh:
    """Return the stand: a plinth that narrows upwards to a plate a little larger than the base."""
    plinth, plate = (tuple(round(length + more, 6) for length in design.base[:2]) for more in (0.016, 0.004))
    tall = design.stand[2]
    levels = ((plinth, 0.0), (plinth, 0.2 * tall), (plate, tall - 0.003), ((plate[0] - 0.006, plate[1] - 0.006), tall))
    corners = [(sx * x / 2.0, sy * y / 2.0, z) for (x, y), z in levels for sx in (-1, 1) for sy in (-1, 1)]
    return hull_of(np.round(np.array(corners), 6))


def _screen(design: Design) -> Link:
    size = design.screen
    x = -size[0] / 2.0
    ring, disc = _emblem(design)
    side = size[1] / 2.0 - 0.045
    pins = merge(rod((0.0, y - 0.02, 0.0), (0.0, y + 0.02, 0.0), 0.0052, 10) for y in (-side, side))
    inner, shown = (tuple(round(size[i] - border[i], 6) for i in (0, 1)) for border in ((0.010, 0.010), (0.028, 0.024)))
    visuals = (
        Visual(mesh_shape("lid", bevelled_box(size, (x, 0.0, 0.0), 0.0015)), design.case),
        Visual(mesh_shape("bezel", _rectangle(design, inner, (x, 0.0), 0.0003)), BEZEL),
        Visual(mesh_shape("picture", _rectangle(design, shown, (x, 0.0), 0.0008)), design.picture),
        Visual(mesh_shape("windows", _windows(design)), LOGO),
        Visual(mesh_shape("lines", _lines(design)), (0.36, 0.46, 0.56)),
        Visual(mesh_shape("ring", ring), design.logo),
        Visual(mesh_shape("disc", disc), design.picture),
        Visual(mesh_shape("pins", pins), BEZEL),
    )
    return Link("screen", 0.3, visuals, (box_shape(size, (x, 0.0, 0.0)),))


def _base(design: Design) -> Link:
    top, (hx, _, hz), half = design.top, design.hinge, design.base[1] / 2.0
    pad = box((0.04, 0.075, 0.0008), (round(0.026 - design.base[0] / 2.0, 6), 0.0, top + 0.0004))
    knuckles = (0.015 - half, 0.075 - half, half - 0.075, half - 0.015)
    feet = merge(rod((hx, y - 0.012, hz), (hx, y + 0.012, hz), 0.0045, 8) for y in knuckles)
    base = (design.base, (0.0, 0.0, design.stand[2] + design.base[2] / 2.0))
    stand = (design.stand, (0.0, 0.0, design.stand[2] / 2.0))
    visuals = (
        Visual(mesh_shape("base", bevelled_box(*base, 0.002)), design.case),
        Visual(mesh_shape("stand", _stand(design)), design.stand_color),
        Visual(mesh_shape("keys", _keys(design)), design.keys),
        Visual(mesh_shape("pad", pad), design.pad),
        Visual(mesh_shape("knuckles", feet), design.case),
    )
    return Link("base", 2.0, visuals, (box_shape(*base), box_shape(*stand)))


LAPTOP = Design()
WIDE = Design(
    "laptop_wide",
    base=(0.19, 0.31, 0.018),
    stand=(0.16, 0.26, 0.02),
    screen=(0.18, 0.31, 0.010),
    columns=13,
    case=(0.13, 0.14, 0.17),
    stand_color=patterned(plastic((0.66, 0.47, 0.28)), "wood"),
    keys=(0.80, 0.82, 0.84),
    pad=(0.22, 0.23, 0.27),
    picture=(0.44, 0.25, 0.62),
    logo=(0.92, 0.42, 0.24),
)


def _model(design: Design) -> Model:
    hinge, screen = design.hinge, design.screen
    joint = Joint("screen_hinge", "revolute", "base", "screen", hinge, (0.0, 1.0, 0.0), 0.0, 2.0, damping=0.01)
    notes = (
        f"the keyboard's near side faces -x; it lies on a stand {design.stand[2]} high, its upper side at z = {design.top:.3f}",
        f"link `screen` has its origin on the hinge {tuple(round(v, 4) for v in hinge)}; at 0 it is closed and spans "
        f"x -{screen[0]}..0, y -+{screen[1] / 2.0}, z -+{screen[2] / 2.0} there; it opens upwards and backwards",
    )
    links = (_base(design), _screen(design))
    return Model(design.name, f"objects/{design.name}", "bottom centre of the stand", links, (joint,), notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_model(LAPTOP), _model(WIDE))
