"""A television on a foot and its remote control with three buttons."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from assets_lib.cabinets import bevelled, bevelled_box, rectangle_at
from assets_lib.mesh import FloatArray, Mesh, box, cylinder, hull_of, lathe, merge
from assets_lib.prisms import mark, regular_polygon
from assets_lib.urdf import Joint, Link, Model, Visual, box_shape, cylinder_shape, glossy, mesh_shape, plastic, shining

PANEL, BOTTOM = (0.03, 0.40, 0.25), 0.045
"""Size of the panel, and height of its lower edge [m]."""
BEZEL = 0.012
FOOT, NECK = (0.12, 0.20, 0.012), (0.022, 0.06, 0.07)
MIDDLE = BOTTOM + PANEL[2] / 2.0
SCREEN = (PANEL[1] - 2.0 * BEZEL, PANEL[2] - 2.0 * BEZEL - 0.008)
"""Width and height of the screen [m]."""
SHEET = 0.0006
"""Thickness of a layer of the image [m]."""
TOP_SHADE, GLOSS, HILLS = 0.82, 0.06, (0.20, 0.55, 0.18)
"""Shade of the upper part of the screen, share of the light that the screen mirrors, and colour of the hills."""
CASE, TRIM, DARK = plastic((0.10, 0.10, 0.11)), (0.45, 0.46, 0.48), (0.03, 0.03, 0.04)

REMOTE, CAP_RADIUS, PROUD, TRAVEL = (0.16, 0.045, 0.016), 0.007, 0.0055, 0.005
"""Size of the body of the remote, radius of a cap, its height over the body, how far it goes down [m]."""
CAPS = {"power": 0.045, "plus": 0.01, "minus": -0.025}
"""Link -> x of the cap [m]."""
RED, KEY, GLYPH = plastic((0.85, 0.10, 0.08)), plastic((0.78, 0.80, 0.82)), (0.05, 0.05, 0.06)

SEGMENTS = {"one": "bc", "two": "abged", "three": "abgcd"}
"""Digit -> strokes that are lit, called as those of a display of seven segments."""
STROKES = {
    "a": (0.0, 1.0, 0),
    "b": (0.5, 0.5, 1),
    "c": (0.5, -0.5, 1),
    "d": (0.0, -1.0, 0),
    "e": (-0.5, -0.5, 1),
    "g": (0.0, 0.0, 0),
}
"""Stroke -> its middle across and up in widths of a digit, and whether it is upright."""
DIGIT, STROKE = 0.026, 0.008
"""Width of a digit and of its strokes [m]."""


def _flat(points: FloatArray, layer: int) -> Mesh:
    """Return a convex part of the image without edges, so that one in the colour of the screen is not seen; see `_sheet`."""
    height = PANEL[0] / 2.0 + 0.0004 + SHEET + 0.0003 * layer
    return mark(points + np.array([0.0, MIDDLE]), height, "x").moved(rpy=(0.0, 0.0, np.pi))


def _sheet(points: FloatArray, layer: int) -> Mesh:
    """Return a flat convex part of the image; points (n, 2) are right and up for a viewer, from the middle of the screen."""
    x = -PANEL[0] / 2.0 - 0.0004 - SHEET * layer
    return hull_of(np.array([(depth, -right, MIDDLE + up) for depth in (x, x - SHEET) for right, up in points]))


def _rectangle(right: float, up: float, width: float, height: float) -> FloatArray:
    return np.array([(right + a * width / 2.0, up + b * height / 2.0) for a in (-1.0, 1.0) for b in (-1.0, 1.0)])


def _hills() -> list[FloatArray]:
    """Return the lower part of the image: a plain and two hills."""
    half, low = SCREEN[0] / 2.0, -SCREEN[1] / 2.0
    plain = _rectangle(0.0, low + 0.025, SCREEN[0], 0.05)
    left = np.array([(-half, low), (-half, 0.01), (-0.12, 0.035), (-0.05, low + 0.05), (-0.03, low)])
    right = np.array([(-0.07, low), (-0.02, low + 0.05), (0.06, -0.01), (half, low + 0.055), (half, low)])
    return [plain, left, right]


def _range(tops: FloatArray, layer: int) -> Mesh:
    """Return a range of hills under a line of points (n, 2), right and up, that goes down to the lower edge of the image."""
    low, x = -SCREEN[1] / 2.0 + 0.004, -PANEL[0] / 2.0 - 0.0004 - SHEET - 0.0003 * layer
    spans = zip(tops[:-1], tops[1:], strict=True)
    return merge(
        Mesh(
            np.array([(x, -a[0], MIDDLE + low), (x, -b[0], MIDDLE + low), (x, -b[0], MIDDLE + b[1]), (x, -a[0], MIDDLE + a[1])]),
            np.array([(0, 1, 2), (0, 2, 3)]),
        )
        for a, b in spans
    )


def _line(base: float, waves: tuple[tuple[float, float, float], ...]) -> FloatArray:
    """Return points (n, 2) across the image, right and up: a height and waves (height, number, phase) [m]."""
    share = np.linspace(0.0, 1.0, 29)
    up = base + sum(height * np.sin(2.0 * np.pi * number * share + phase) for height, number, phase in waves)
    return np.column_stack([(share - 0.5) * SCREEN[0], up])


def _landscape() -> tuple[Visual, ...]:
    """Return what is seen of the lower part of the image: bright hills far away, darker ones before them, and a meadow."""
    ranges = {
        "far_hills": (_line(-0.006, ((0.022, 1.0, 0.4), (0.009, 2.6, 1.0))), 1, (1.0, 0.86)),
        "hills": (_line(-0.040, ((0.020, 1.3, 3.4), (0.006, 3.1, 0.0))), 2, (0.80, 0.62)),
        "meadow": (_line(-0.074, ((0.010, 0.7, 0.9),)), 3, (0.98, 0.72)),
    }
    return tuple(
        Visual(mesh_shape(name, _range(tops, layer)), glossy(HILLS, GLOSS), crease=0.1, grade=_fade(*shades))
        for name, (tops, layer, shades) in ranges.items()
    )


def _fade(high: float, low: float) -> Callable[[FloatArray], FloatArray]:
    """Return shades that fall from the middle of the image to its lower edge."""
    return lambda places: np.interp(places[:, 2] - MIDDLE, (-SCREEN[1] / 2.0, 0.0), (low, high))


def _sky() -> Visual:
    """Return the screen, whose shade grows towards the horizon; behind the digits it is even, so that these are not seen."""
    edges = (-SCREEN[1] / 2.0 + 0.004, -0.02, 0.03, SCREEN[1] / 2.0 - 0.07, SCREEN[1] / 2.0 + 0.004)
    shades = (0.90, 1.0, 0.90, TOP_SHADE, TOP_SHADE)
    x, half = -PANEL[0] / 2.0 - 0.0004 - SHEET, SCREEN[0] / 2.0
    bands = [rectangle_at(x, (-half, half), (MIDDLE + a, MIDDLE + b)) for a, b in zip(edges[:-1], edges[1:], strict=True)]
    sides = _sheet(_rectangle(0.0, 0.004, *SCREEN), 0).moved((0.0001, 0.0, 0.0))
    return Visual(
        mesh_shape("screen", merge([*bands, sides])),
        glossy((0.55, 0.80, 1.0), GLOSS),
        crease=0.1,
        grade=lambda places: np.interp(places[:, 2] - MIDDLE, edges, shades),
    )


def _digit(place: int, strokes: str) -> list[FloatArray]:
    """Return the strokes of a digit in a row that begins in the upper left corner of the screen."""
    x, y, found = -SCREEN[0] / 2.0 + 0.032 + 2.0 * DIGIT * place, SCREEN[1] / 2.0 - 0.042, []
    for across, up, upright in (STROKES[stroke] for stroke in strokes):
        size = (STROKE, DIGIT + STROKE) if upright else (DIGIT + STROKE, STROKE)
        found.append(_rectangle(x + across * DIGIT, y + up * DIGIT, *size))
    return found


def _television() -> Model:
    x, y, z = PANEL
    neck = (NECK, (0.006, 0.0, NECK[2] / 2.0))
    foot = (FOOT, (0.0, 0.0, FOOT[2] / 2.0))
    panel = (PANEL, (0.0, 0.0, MIDDLE))
    vents = merge(box((0.001, 0.18, 0.004), (x / 2.0 + 0.0004, 0.0, MIDDLE + 0.05 + 0.012 * i)) for i in range(5))
    socket = box((0.004, 0.09, 0.05), (x / 2.0 + 0.002, 0.0, MIDDLE - 0.03))
    light = box((0.001, 0.012, 0.003), (-x / 2.0 - 0.0003, 0.0, BOTTOM + 0.009))
    visuals = (
        Visual(mesh_shape("case", merge([bevelled((panel, foot), 0.003), box(*neck)])), CASE, crease=0.1),
        Visual(mesh_shape("vents", merge([vents, socket])), TRIM, crease=0.1),
        Visual(mesh_shape("light", light), (0.80, 0.10, 0.08)),
    )
    links = [Link("television", 4.0, visuals, tuple(box_shape(*part) for part in (panel, neck, foot)))]
    sun = regular_polygon(0.024, 20) + (0.095, 0.052)
    image = {
        "screen": ([_rectangle(0.0, 0.004, *SCREEN)], 0, (0.55, 0.80, 1.0)),
        "hills": (_hills(), 1, (0.20, 0.55, 0.18)),
        "sun": ([sun], 1, (1.0, 0.85, 0.20)),
        **{name: (_digit(i, strokes), 2, (1.0, 1.0, 1.0)) for i, (name, strokes) in enumerate(SEGMENTS.items())},
    }
    for name, (parts, layer, paint) in image.items():
        solid = merge(_sheet(points, layer) for points in parts)
        seen: tuple[Visual, ...] = (_sky(),) if name == "screen" else _landscape()
        if name not in ("screen", "hills"):
            flat, shade = merge(_flat(points, layer + 2) for points in parts), 1.0 if name == "sun" else TOP_SHADE
            bright = glossy(shining(paint), GLOSS) if name in SEGMENTS else glossy(paint, GLOSS)
            seen = (Visual(mesh_shape(name, flat), bright, crease=0.1, grade=_fade(shade, shade)),)
        links.append(Link(name, 0.001, seen, weighs=(mesh_shape("", solid),)))
    joints = tuple(Joint(f"{name}_mount", "fixed", "television", name, (0.0, 0.0, 0.0)) for name in image)
    notes = (
        f"screen faces -x; panel {x} x {y} x {z}, its lower edge at z = {BOTTOM}; foot {FOOT}",
        "the image is made of the links `screen`, `hills`, `sun`, `one`, `two`, `three` (digits): recolour them; "
        "a digit in the colour of the screen is not seen, and in the same dark colour all of them are a screen that is off",
    )
    return Model("television", "objects/television", "bottom centre of the foot", tuple(links), joints, notes)


def _glyph(name: str) -> Mesh:
    """Return the sign on a cap, its origin the centre of the cap's top."""
    if name == "power":
        return box((0.0075, 0.002, 0.0006), (0.0, 0.0, 0.0001))
    bars = [box((0.002, 0.009, 0.0006), (0.0, 0.0, 0.0001))]
    return merge([*bars, box((0.009, 0.002, 0.0006), (0.0, 0.0, 0.0001))] if name == "plus" else bars)


def _remote() -> Model:
    x, y, z = REMOTE
    keys = [box((0.007, 0.009, 0.002), (-0.045 - 0.0115 * i, 0.013 * j, z + 0.0005)) for i in range(3) for j in (-1, 0, 1)]
    well = lathe([(CAP_RADIUS + 0.0025, 0.0), (CAP_RADIUS + 0.0025, 0.0004), (CAP_RADIUS + 0.0002, 0.0004)], 24)
    wells = [well.moved((place, 0.0, z)) for place in CAPS.values()]
    visuals = (
        Visual(mesh_shape("shell", bevelled_box(REMOTE, (0.0, 0.0, z / 2.0), 0.003)), plastic((0.17, 0.18, 0.21)), crease=0.1),
        Visual(
            mesh_shape("window", bevelled_box((0.006, 0.026, 0.010), (x / 2.0 - 0.0025, 0.0, z / 2.0), 0.001)), (0.30, 0.02, 0.05)
        ),
        Visual(mesh_shape("keys", merge(keys)), (0.55, 0.57, 0.60), crease=0.1),
        Visual(mesh_shape("wells", merge(wells)), (0.06, 0.06, 0.07), crease=0.5),
    )
    links = [Link("remote", 0.1, visuals, (box_shape(REMOTE, (0.0, 0.0, z / 2.0)),), friction=0.8, anchored=True)]
    joints = []
    for name, place in CAPS.items():
        cap = cylinder(CAP_RADIUS, PROUD, 16, bevel=0.001).moved((0.0, 0.0, -PROUD / 2.0))
        sign = GLYPH if name != "power" else (1.0, 1.0, 1.0)
        looks = (
            Visual(mesh_shape(f"{name}_cap", cap), RED if name == "power" else KEY),
            Visual(mesh_shape(f"{name}_sign", _glyph(name)), sign),
        )
        links.append(Link(name, 0.01, looks, (cylinder_shape(CAP_RADIUS, PROUD, (0.0, 0.0, -PROUD / 2.0)),)))
        joints.append(
            Joint(
                f"{name}_joint", "prismatic", "remote", name, (place, 0.0, z + PROUD), (0.0, 0.0, -1.0), 0.0, TRAVEL, damping=0.5
            )
        )
    notes = (
        f"aims along +x; body {REMOTE}, {y} across; its ends at x = -+{x / 2.0}",
        f"caps of diameter {2 * CAP_RADIUS} on the links `power`, `plus`, `minus` at x = {tuple(CAPS.values())}; each has its "
        f"origin at the centre of its top, {PROUD} above the body, and its joint increases when it is pressed, at most {TRAVEL}",
    )
    return Model("remote", "objects/remote", "bottom centre", tuple(links), tuple(joints), notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_television(), _remote())
