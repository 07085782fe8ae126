"""A washbasin with its tap: a spout between two cross handles that turn about upright stems."""

from __future__ import annotations

import numpy as np

from assets_lib.mesh import Mesh, box, cylinder, lathe, merge
from assets_lib.urdf import (
    Joint,
    Link,
    Model,
    Shape,
    Vec3,
    Visual,
    box_shape,
    cylinder_shape,
    glass,
    mesh_shape,
    metal,
    pane,
    patterned,
)

FRONT, LEDGE, BACK = -0.20, -0.03, 0.05
"""x of the front of the basin, of the front and of the back of its ledge [m]."""
HALF_WIDTH, RIM, WALL, FLOOR = 0.16, 0.06, 0.014, 0.014
SPOUT, SPOUT_RADIUS, MOUTH = 0.15, 0.011, (-0.115, 0.095)
"""Height of the top of the spout, its radius, x and height of its mouth [m]."""
STEM_Y, STEM_RADIUS = 0.10, 0.012
HANDLE_Z, SPAN, ARM, THICK = 0.125, 0.06, 0.014, 0.02
"""Height of the middle of a handle; length, width and thickness of an arm of its cross [m]."""
CERAMIC, GLAZE, CHROME, GRATE = (
    glass((0.93, 0.94, 0.94)),
    glass((0.78, 0.84, 0.87)),
    metal((0.80, 0.82, 0.86)),
    (0.30, 0.31, 0.33),
)
WATER = (0.60, 0.82, 0.96)
RED, BLUE, WHITE = (0.86, 0.10, 0.08), (0.08, 0.22, 0.80), (0.97, 0.97, 0.97)


def _basin() -> tuple[tuple[Vec3, Vec3], ...]:
    """Return the boxes (size, centre) of the basin: floor, three walls, and the ledge that bears the tap."""
    middle, length, width = (FRONT + LEDGE) / 2.0, LEDGE - FRONT, 2.0 * HALF_WIDTH
    side = HALF_WIDTH - WALL / 2.0
    return (
        ((length, width, FLOOR), (middle, 0.0, FLOOR / 2.0)),
        ((WALL, width, RIM - FLOOR), (FRONT + WALL / 2.0, 0.0, (RIM + FLOOR) / 2.0)),
        *(((length - WALL, WALL, RIM - FLOOR), (middle + WALL / 2.0, s * side, (RIM + FLOOR) / 2.0)) for s in (-1, 1)),
        ((BACK - LEDGE, width, RIM), ((BACK + LEDGE) / 2.0, 0.0, RIM / 2.0)),
    )


def _glaze() -> Mesh:
    """Return thin sheets that make the inside of the basin darker."""
    t, length, half = 0.001, LEDGE - FRONT - WALL, HALF_WIDTH - WALL
    middle, tall = (FRONT + WALL + LEDGE) / 2.0, RIM - FLOOR - 0.004
    z = FLOOR + tall / 2.0
    sheets = [box((length, 2.0 * half, t), (middle, 0.0, FLOOR + t / 2.0))]
    sheets += [box((length, t, tall), (middle, s * (half - t / 2.0), z)) for s in (-1, 1)]
    return merge([*sheets, *(box((t, 2.0 * half, tall), (x, 0.0, z)) for x in (FRONT + WALL + t / 2.0, LEDGE - t / 2.0))])


def _spout_line() -> list[tuple[float, float]]:
    """Return x and height along the middle of the spout: up, over in a bow, down to the mouth."""
    top, x = SPOUT - SPOUT_RADIUS, MOUTH[0]
    radius = -x / 2.0
    turns = np.linspace(0.0, np.pi, 8)
    bow = [(x / 2.0 + radius * float(np.cos(a)), top - 0.035 + 0.035 * float(np.sin(a))) for a in turns]
    return [(0.0, RIM), *bow, MOUTH]


def _spout_pieces() -> list[tuple[Vec3, Vec3]]:
    """Return the two ends of each straight piece of the spout."""
    line = [(x, 0.0, z) for x, z in _spout_line()]
    return list(zip(line[:-1], line[1:], strict=True))


def _fittings() -> Mesh:
    """Return the spout with its foot, and the stems with theirs."""
    foot = [(0.022, RIM), (0.022, RIM + 0.009), (0.019, RIM + 0.012), (0.0, RIM + 0.012)]
    feet = [lathe(foot, 16).moved((0.0, y, 0.0)) for y in (-STEM_Y, 0.0, STEM_Y)]
    low, high = RIM + 0.012, HANDLE_Z - THICK / 2.0 - 0.002
    stems = [lathe([(0.0155, low), (STEM_RADIUS, high), (0.0, high)], 14).moved((0.0, y, 0.0)) for y in (-STEM_Y, STEM_Y)]
    x, z = MOUTH
    collar = lathe([(0.0, z - 0.007), (0.0125, z - 0.007), (0.014, z - 0.005), (0.014, z + 0.005), (SPOUT_RADIUS, z + 0.007)], 16)
    return merge([*feet, *stems, _tube(), collar.moved((x, 0.0, 0.0))])


def _tube(sides: int = 16) -> Mesh:
    """Return the spout as one bent tube."""
    line = np.array(_spout_line())
    along = np.gradient(line, axis=0)
    along[0], along[-1] = (0.0, 1.0), (0.0, -1.0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    angles = 2.0 * np.pi * np.arange(sides) / sides
    out, aside = SPOUT_RADIUS * np.cos(angles), SPOUT_RADIUS * np.sin(angles)
    rings = [np.column_stack([x - out * dz, aside, z + out * dx]) for (x, z), (dx, dz) in zip(line, along, strict=True)]
    faces = []
    for ring in range(0, (len(rings) - 1) * sides, sides):
        for a, b in zip(range(sides), [*range(1, sides), 0], strict=True):
            faces += [(ring + a, ring + sides + b, ring + b), (ring + a, ring + sides + a, ring + sides + b)]
    return Mesh(np.concatenate(rings), np.array(faces))


def _spout_shapes() -> tuple[Shape, ...]:
    """Return a box for each piece of the spout."""
    shapes = []
    for start, end in _spout_pieces():
        along = np.subtract(end, start)
        middle = (float(start[0] + end[0]) / 2.0, 0.0, float(start[2] + end[2]) / 2.0)
        pitch = float(np.arctan2(along[0], along[2]))
        shapes.append(box_shape((0.019, 0.019, float(np.linalg.norm(along)) + 0.004), middle, (0.0, pitch, 0.0)))
    return tuple(shapes)


def _basin_link() -> Link:
    drain = cylinder(0.018, 0.003, 12).moved((MOUTH[0], 0.0, FLOOR + 0.002))
    visuals = (
        Visual(mesh_shape("basin", merge(box(size, center) for size, center in _basin())), CERAMIC),
        Visual(mesh_shape("glaze", _glaze()), GLAZE),
        Visual(mesh_shape("fittings", _fittings()), patterned(CHROME, "brushed")),
        Visual(mesh_shape("drain", drain), GRATE),
    )
    height = HANDLE_Z - THICK / 2.0 - 0.002 - RIM
    stems = (cylinder_shape(0.014, height, (0.0, y, RIM + height / 2.0)) for y in (-STEM_Y, STEM_Y))
    foot = cylinder_shape(0.022, 0.012, (0.0, 0.0, RIM + 0.006))
    return Link("basin", 6.0, visuals, (*(box_shape(size, center) for size, center in _basin()), foot, *_spout_shapes(), *stems))


def _stream_link() -> Link:
    """Return the water from the mouth to the floor, and what spreads there; a task shows it."""
    x, low = MOUTH[0], FLOOR + 0.0035
    outline = [
        (0.0, low),
        (0.060, low),
        (0.058, low + 0.004),
        (0.009, low + 0.006),
        (0.008, MOUTH[1] - 0.006),
        (0.0, MOUTH[1] - 0.006),
    ]
    solid = lathe(outline, 14).moved((x, 0.0, 0.0))
    top = MOUTH[1] - 0.006
    pool = [
        (0.052, low - 0.0024),
        (0.050, low - 0.0010),
        (0.036, low),
        (0.031, low + 0.0012),
        (0.026, low),
        (0.016, low + 0.0012),
    ]
    water = lathe([*pool, (0.0105, low + 0.004), (0.0080, low + 0.02), (0.0085, top)], 16)
    angles = np.arctan2(water.vertices[:, 1], water.vertices[:, 0])
    outside = np.hypot(water.vertices[:, 0], water.vertices[:, 1]) > 0.045
    spread = 1.0 + outside * (0.10 * np.sin(2.0 * angles + 0.4) + 0.06 * np.sin(3.0 * angles))
    water = Mesh(water.vertices * np.column_stack([spread, spread, np.ones(len(spread))]), water.faces).moved((x, 0.0, 0.0))
    seen = Visual(mesh_shape("stream", water), pane(WATER, 0.0))
    return Link("stream", 0.001, (seen,), center=(x, 0.0, FLOOR), weighs=(mesh_shape("", solid),))


def _cross() -> Mesh:
    """Return the cross of a handle with a round button in the middle; the origin is its middle."""
    arms = [box((SPAN, ARM, THICK)), box((ARM, SPAN, THICK))]
    return merge([*arms, cylinder(STEM_RADIUS + 0.001, THICK + 0.004, 12)])


def _handle_link(side: str, color: Vec3) -> Link:
    stripe = box((SPAN / 2.0 - 0.011, 0.006, 0.001), (SPAN / 4.0 + 0.0035, 0.0, THICK / 2.0 + 0.0004))
    button = merge([cylinder(0.009, 0.004, 10).moved((0.0, 0.0, THICK / 2.0 + 0.003)), stripe])
    visuals = (Visual(mesh_shape(f"cross_{side}", _cross()), color), Visual(mesh_shape(f"button_{side}", button), WHITE))
    hub = cylinder_shape(STEM_RADIUS, THICK)
    return Link(
        f"{side}_handle", 0.08, visuals, (box_shape((SPAN, ARM, THICK)), box_shape((ARM, SPAN, THICK)), hub), friction=1.0
    )


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    sides = (("left", 1.0, RED), ("right", -1.0, BLUE))
    joints = tuple(
        Joint(side, "revolute", "basin", f"{side}_handle", (0.0, sign * STEM_Y, HANDLE_Z), (0.0, 0.0, 1.0), -3.0, 3.0, 0.002)
        for side, sign, _ in sides
    )
    notes = (
        f"the spout points to -x, over a hollow basin with its rim at z = {RIM}; left and right are those of a viewer in front",
        f"links `left_handle` (red) and `right_handle` (blue) turn about upright axes at y = {STEM_Y} and {-STEM_Y}; "
        f"each is a cross of two arms {SPAN} x {ARM} x {THICK}, along x and y at 0, its middle at z = {HANDLE_Z}",
        f"link `stream` is water that is not seen: colour it ({WATER[0]}, {WATER[1]}, {WATER[2]}, 0.6) when it runs",
        "fingers that close along a diagonal of a cross come to rest between its arms",
    )
    stream = Joint("stream_holder", "fixed", "basin", "stream", (0.0, 0.0, 0.0))
    handles = (_handle_link(side, color) for side, _, color in sides)
    return (
        Model(
            "tap", "objects/tap", "bottom, below the stems", (_basin_link(), *handles, _stream_link()), (*joints, stream), notes
        ),
    )
