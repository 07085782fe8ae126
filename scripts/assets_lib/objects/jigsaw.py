"""A jigsaw puzzle of a landscape in a tray, all pieces but one glued in, and the loose piece with a knob."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np

from assets_lib.mesh import FloatArray, Mesh, box, hull_of, merge
from assets_lib.prisms import bevelled_box, grown, prism, rectangle, regular_polygon
from assets_lib.urdf import Link, Model, Shape, Vec3, Visual, box_shape, mesh_shape, patterned

COLUMNS, ROWS, CELL = 6, 4, 0.04
"""Pieces along y and along x, and their pitch [m]."""
TRAY = (0.20, 0.26, 0.018)
FLOOR, THICKNESS = 0.003, 0.015
GAP = 0.001
"""Free all round the loose piece in its place [m]."""
CHAMFER = 0.003
"""Width of the slanted edge below the loose piece [m]."""
KNOB = (0.014, 0.014, 0.024)
EMPTY = (2, 3)
"""Row and column of the empty place; rows count from -x, columns from -y."""
TAB = (0.0052, 0.0012)
"""Radius of the tabs, and how far the middle of their arc lies inside the edge [m]."""
SKIN = 0.001
"""Skin that PyBullet puts around collision meshes [m]."""
SEAM = 0.0006
"""Width of the edge of a piece without an image [m]."""
SKY, WOOD, SEAMS = (0.56, 0.75, 0.90), (0.62, 0.44, 0.27), (0.36, 0.38, 0.40)
X, Y = ROWS * CELL / 2.0, COLUMNS * CELL / 2.0
IMAGE: tuple[tuple[str, Vec3, tuple[FloatArray, ...]], ...] = (
    ("sun", (0.97, 0.80, 0.30), (0.018 * regular_polygon(1.0, 20) + (0.045, 0.075),)),
    (
        "mountains",
        (0.46, 0.50, 0.60),
        (np.array([(-0.01, 0.03), (0.062, -0.05), (-0.01, -0.13)]), np.array([(-0.01, 0.11), (0.035, 0.045), (-0.01, -0.02)])),
    ),
    ("snow", (0.95, 0.96, 0.97), (np.array([(0.040, -0.0256), (0.062, -0.05), (0.040, -0.0744)]),)),
    ("meadow", (0.42, 0.62, 0.32), (np.array([(-X, Y), (-0.012, Y), (0.002, 0.03), (-0.008, -Y), (-X, -Y)]),)),
    ("path", (0.87, 0.78, 0.58), (np.array([(-X, 0.045), (-0.006, 0.028), (-0.006, 0.020), (-X, 0.005)]),)),
    ("house", (0.80, 0.36, 0.26), (np.array([(-0.014, 0.036), (0.010, 0.036), (0.010, 0.006), (-0.014, 0.006)]),)),
    ("roof", (0.40, 0.22, 0.18), (np.array([(0.010, 0.040), (0.026, 0.021), (0.010, 0.002)]),)),
    ("door", (0.95, 0.88, 0.70), (np.array([(-0.014, 0.024), (0.001, 0.024), (0.001, 0.017), (-0.014, 0.017)]),)),
)
"""Layers of the image, each over those before it: name, colour and convex areas, x (up) and y (left) [m]."""


def _center(row: int, column: int) -> FloatArray:
    """Return x, y of the middle of a piece in the image [m]."""
    return np.array([(row - (ROWS - 1) / 2.0) * CELL, (column - (COLUMNS - 1) / 2.0) * CELL])


def _tab(row: int, column: int, step: tuple[int, int]) -> int:
    """Return whether a piece has a tab (1), a socket (-1) or a straight edge (0) towards a neighbour."""
    other = (row + step[0], column + step[1])
    if not (0 <= other[0] < ROWS and 0 <= other[1] < COLUMNS):
        return 0
    low = min((row, column), other)
    sign = 1 if (low[0] + low[1] + abs(step[0])) % 2 else -1
    return sign if (row, column) == low else -sign


def _outline(row: int, column: int) -> FloatArray:
    """Return the outline of a piece around its middle (n, 2), counter-clockwise."""
    radius, inside = TAB
    half, reach = CELL / 2.0, float(np.arccos(inside / radius))
    points: list[FloatArray] = []
    for step in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        out = np.array(step, dtype=float)
        along = np.array([-out[1], out[0]])
        points.append(half * out - half * along)
        kind = _tab(row, column, step)
        for a in np.linspace(-reach, reach, 3) if kind else ():
            bump = radius * np.cos(a) - inside
            points.append((half + kind * bump) * out + radius * np.sin(a) * along)
    return np.array(points)


def _clipped(subject: FloatArray, area: FloatArray) -> FloatArray:
    """Return the part of a convex polygon (n, 2) inside a convex, counter-clockwise area."""
    for a, b in zip(area, np.roll(area, -1, axis=0), strict=True):
        edge = b - a
        inside = edge[0] * (subject[:, 1] - a[1]) - edge[1] * (subject[:, 0] - a[0])
        kept: list[FloatArray] = []
        for i in range(len(subject)):
            j = (i + 1) % len(subject)
            if inside[i] >= 0.0:
                kept.append(subject[i])
            if inside[i] * inside[j] < 0.0:
                kept.append(subject[i] + (subject[j] - subject[i]) * inside[i] / (inside[i] - inside[j]))
        if len(kept) < 3:
            return np.zeros((0, 2))
        subject = np.array(kept)
    return subject


def _painted(row: int, column: int, area: FloatArray, height: float) -> list[Mesh]:
    """Return an area of the image on a piece as flat polygons, in the axes of the image."""
    if np.cross(area[1] - area[0], area[2] - area[1]) < 0.0:
        area = area[::-1]
    center = _center(row, column)
    corners = grown(_outline(row, column), -SEAM) + center
    found = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        part = _clipped(np.array([center, a, b]), area)
        if len(part):
            faces = np.array([(0, i, i + 1) for i in range(1, len(part) - 1)])
            found.append(Mesh(np.column_stack([part, np.full(len(part), height)]), faces))
    return found


def _upper_side(outline: FloatArray, top: float) -> Mesh:
    """Return the upper side of a glued piece, of which no more is seen."""
    count = len(outline)
    vertices = np.column_stack([np.vstack([outline, np.zeros(2)]), np.full(count + 1, top)])
    return Mesh(vertices, np.array([(count, i, (i + 1) % count) for i in range(count)]))


def _whole(outline: FloatArray, top: float) -> Mesh:
    """Return a loose piece."""
    return prism(outline, top - THICKNESS, top, (0.0, 0.0), bevel=0.0007)


def _printed(
    pieces: list[tuple[int, int]], top: float, around: FloatArray, body: Callable[[FloatArray, float], Mesh]
) -> tuple[Visual, ...]:
    """Return pieces, each with its body and the image on it, in the axes of a point of the image."""
    shift = (-around[0], -around[1], 0.0)
    square = rectangle(CELL, CELL)  # of a piece that is not beside the empty place no more is seen than its seams
    bodies = []
    for piece in pieces:
        steps = np.abs(np.subtract(piece, EMPTY)).sum()
        outline = square if steps > 1 else grown(_outline(*piece), 0.0 if steps else -0.0002)
        bodies.append(body(outline, top).moved((*_center(*piece), 0.0)))
    visuals = [Visual(mesh_shape("pieces", merge(bodies).moved(shift)), SEAMS, crease=0.3)]
    for layer, (name, color, areas) in enumerate((("sky", SKY, (rectangle(2.0 * X + 0.02, 2.0 * Y + 0.02),)), *IMAGE), start=1):
        parts = [part for piece in pieces for area in areas for part in _painted(*piece, area, top + 0.0001 * layer)]
        if parts:
            visuals.append(Visual(mesh_shape(name, merge(parts).moved(shift)), color, crease=0.1))
    return tuple(visuals)


def _tray() -> Model:
    x, y, z = TRAY
    cells = [piece for piece in product(range(ROWS), range(COLUMNS)) if piece != EMPTY]
    border = [
        bevelled_box(size, 0.002).moved(place)
        for size, place in (
            *(((x, (y - 2 * Y) / 2.0 - 0.0003, z), (0.0, s * (y / 2.0 + Y) / 2.0, 0.0)) for s in (-1, 1)),
            *((((x - 2 * X) / 2.0 - 0.0003, 2 * Y, z), (s * (x / 2.0 + X) / 2.0, 0.0, 0.0)) for s in (-1, 1)),
        )
    ]
    low_x, low_y = _center(*EMPTY) - CELL / 2.0 - GAP
    high_x, high_y = _center(*EMPTY) + CELL / 2.0 + GAP
    walls: list[Shape] = [
        box_shape((b - a, y, z), ((a + b) / 2.0, 0.0, z / 2.0)) for a, b in ((-x / 2.0, low_x), (high_x, x / 2.0))
    ]
    walls += [
        box_shape((high_x - low_x, b - a, z), ((low_x + high_x) / 2.0, (a + b) / 2.0, z / 2.0))
        for a, b in ((-y / 2.0, low_y), (high_y, y / 2.0))
    ]
    floor = box_shape((high_x - low_x, high_y - low_y, FLOOR), ((low_x + high_x) / 2.0, (low_y + high_y) / 2.0, FLOOR / 2.0))
    visuals = (
        Visual(mesh_shape("border", merge(border)), patterned(WOOD, "wood")),
        Visual(mesh_shape("floor", box((2 * X, 2 * Y, FLOOR), (0.0, 0.0, FLOOR / 2.0))), patterned((0.46, 0.32, 0.20), "wood")),
        *_printed(cells, z, np.zeros(2), _upper_side),
    )
    link = Link("jigsaw_tray", 0.8, visuals, (*walls, floor), friction=0.6)
    middle = _center(*EMPTY)
    notes = (
        f"image upright seen from -x; the empty place is around ({middle[0]:.2f}, {middle[1]:.2f}), its floor at z = {FLOOR}",
        f"that place is {CELL + 2 * GAP:.3f} wide for a piece of {CELL}",
    )
    return Model("jigsaw_tray", "objects/jigsaw_tray", "bottom centre", (link,), notes=notes)


def _piece() -> Model:
    half = CELL / 2.0 - SKIN
    corners = [
        (*point, z)
        for side, z in ((half - CHAMFER, SKIN), (half, CHAMFER), (half, THICKNESS - SKIN))
        for point in rectangle(2 * side, 2 * side)
    ]
    solid = hull_of(np.round(np.array(corners), 6))
    place = (0.0, 0.0, THICKNESS + KNOB[2] / 2.0)
    visuals = (
        *_printed([EMPTY], THICKNESS, _center(*EMPTY), _whole),
        Visual(mesh_shape("knob", bevelled_box(KNOB, 0.003).moved((0.0, 0.0, THICKNESS))), patterned((0.80, 0.62, 0.40), "wood")),
    )
    link = Link("jigsaw_piece", 0.04, visuals, (mesh_shape("piece_hull", solid), box_shape(KNOB, place)), friction=0.6)
    notes = (
        f"{CELL} x {CELL} x {THICKNESS}, lower edges slanted; matches the empty place of `jigsaw_tray` at equal yaw",
        f"knob {KNOB} on top: grasp it at z = {THICKNESS + 0.014}",
    )
    return Model("jigsaw_piece", "objects/jigsaw_piece", "bottom centre", (link,), notes=notes)


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (_tray(), _piece())
