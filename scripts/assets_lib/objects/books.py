"""Books, a bookshelf with room on its upper board, and a bookcase of four compartments."""

from __future__ import annotations

from assets_lib.cabinets import bevelled
from assets_lib.mesh import Mesh, box, merge
from assets_lib.urdf import Link, Model, Vec3, Visual, box_shape, mesh_shape, plastic

Box = tuple[Vec3, Vec3]

BOOK = (0.09, 0.025, 0.13)
"""Depth, thickness and height of a book that stands, its spine at -x [m]."""
COVER, OVERHANG = 0.0025, 0.003
COLORS: dict[str, Vec3] = {"blue": (0.16, 0.29, 0.50), "red": (0.55, 0.15, 0.16), "yellow": (0.84, 0.63, 0.22)}
PAGES, GILT = (0.94, 0.91, 0.82), (0.93, 0.86, 0.66)
DEPTH, HEIGHT, BOARD, LOWER, UPPER = 0.18, 0.36, 0.015, 0.03, 0.25
"""Of the shelves; upper sides of both boards [m]."""
WIDTHS = {"bookshelf": 0.40, "bookcase": 0.56}
RECESS = 0.035
"""How far behind the front the partition of the bookcase begins [m]."""
WOOD, BACK = plastic((0.62, 0.43, 0.27)), (0.52, 0.35, 0.21)


def _book_parts(size: Vec3) -> tuple[Mesh, Mesh, Mesh]:
    """Return covers with spine, pages and lettering of a standing book, its centre at the origin."""
    x, y, z = size
    sides = [((x, COVER, z), (0.0, s * (y - COVER) / 2.0, 0.0)) for s in (-1.0, 1.0)]
    covers = bevelled([*sides, ((COVER, y, z), (-(x - COVER) / 2.0, 0.0, 0.0))], 0.0011)
    pages = box((x - OVERHANG, y - 2.0 * COVER + 0.0004, z - 2.0 * OVERHANG), (-OVERHANG / 2.0 + COVER / 2.0, 0.0, 0.0))
    spine = -x / 2.0 - 0.0002
    bands = [box((0.0006, y - 0.004, 0.003), (spine, 0.0, s * 0.38 * z)) for s in (-1, 1)]
    title = [box((0.0006, y * 0.32, z * 0.36), (spine, 0.0, z * 0.08))]
    fronts = [box((w, 0.0006, h), (0.004, s * (y / 2.0 + 0.0002), up)) for s in (-1, 1) for w, h, up in _title(x, z)]
    return covers, pages, merge([*bands, *title, *fronts])


def _title(x: float, z: float) -> tuple[tuple[float, float, float], ...]:
    """Return width, height and elevation of the lines on a cover."""
    return (x * 0.60, 0.007, z * 0.24), (x * 0.44, 0.007, z * 0.14), (x * 0.30, 0.003, -z * 0.30)


def _book(color: str) -> Model:
    covers, pages, letters = _book_parts(BOOK)
    visuals = (
        Visual(mesh_shape("covers", covers), plastic(COLORS[color])),
        Visual(mesh_shape("pages", pages), PAGES),
        Visual(mesh_shape("letters", letters), GILT if color != "yellow" else (0.35, 0.22, 0.12)),
    )
    link = Link(f"book_{color}", 0.2, visuals, (box_shape(BOOK),), friction=0.9)
    notes = (f"stands: {BOOK[0]} deep with its spine at -x, {BOOK[1]} thick along y, {BOOK[2]} high; grasp it across y",)
    return Model(f"book_{color}", f"objects/book_{color}", "centre", (link,), notes=notes)


def _boards(width: float) -> list[Box]:
    """Return size and centre of back, sides, both boards, and the plinth below."""
    inner, half = width - 2.0 * BOARD, HEIGHT / 2.0
    return [
        ((BOARD, inner, HEIGHT), ((DEPTH - BOARD) / 2.0, 0.0, half)),
        *(((DEPTH, BOARD, HEIGHT), (0.0, s * (width - BOARD) / 2.0, half)) for s in (-1.0, 1.0)),
        *(((DEPTH - BOARD, inner, BOARD), (-BOARD / 2.0, 0.0, z - BOARD / 2.0)) for z in (LOWER, UPPER)),
        ((BOARD, inner, LOWER - BOARD), (-DEPTH / 2.0 + 0.03, 0.0, (LOWER - BOARD) / 2.0)),
    ]


ROW: tuple[tuple[float, float, float, Vec3], ...] = (
    (0.018, 0.150, 0.110, (0.33, 0.42, 0.36)),
    (0.030, 0.165, 0.120, (0.44, 0.24, 0.18)),
    (0.022, 0.140, 0.105, (0.75, 0.70, 0.60)),
    (0.026, 0.158, 0.115, (0.22, 0.30, 0.42)),
    (0.034, 0.170, 0.120, (0.58, 0.48, 0.30)),
    (0.020, 0.145, 0.110, (0.40, 0.20, 0.30)),
    (0.028, 0.160, 0.118, (0.30, 0.34, 0.30)),
    (0.024, 0.150, 0.112, (0.66, 0.34, 0.22)),
    (0.030, 0.166, 0.120, (0.25, 0.36, 0.44)),
)
"""Thickness, height, depth and colour of the books on the lower board of the bookshelf [m]."""


def _bookshelf() -> Model:
    width = WIDTHS["bookshelf"]
    boards, along = _boards(width), -width / 2.0 + BOARD + 0.004
    visuals = [Visual(mesh_shape("boards", bevelled(boards[1:])), WOOD), Visual(mesh_shape("back", bevelled(boards[:1])), BACK)]
    pages, letters, solid = [], [], list(boards)
    for number, (thick, tall, deep, color) in enumerate(ROW):
        center = (-DEPTH / 2.0 + 0.01 + deep / 2.0, along + thick / 2.0, LOWER + tall / 2.0)
        x, y, z = center
        visuals.append(Visual(mesh_shape(f"row_{number}", bevelled([((deep, thick, tall), center)], 0.002)), plastic(color)))
        pages.append(box((deep - 0.006, thick - 2.0 * COVER, 0.0006), (x, y, z + tall / 2.0)))
        letters.append(box((0.0006, thick * 0.4, tall * 0.35), (x - deep / 2.0, y, z + tall * 0.12)))
        along += thick + 0.001
    row = along + width / 2.0 - BOARD
    solid.append(((0.12, row, 0.17), (-DEPTH / 2.0 + 0.07, along - row / 2.0, LOWER + 0.085)))
    visuals += [Visual(mesh_shape("row_pages", merge(pages)), PAGES), Visual(mesh_shape("row_letters", merge(letters)), GILT)]
    link = Link("bookshelf", 10.0, tuple(visuals), tuple(box_shape(size, center) for size, center in solid))
    return Model("bookshelf", "objects/bookshelf", "bottom centre", (link,), notes=_notes(width))


def _bookcase() -> Model:
    width = WIDTHS["bookcase"]
    boards = _boards(width)
    deep = DEPTH - BOARD - RECESS
    partition = [
        ((deep, BOARD, high - low), ((RECESS - BOARD) / 2.0, 0.0, (low + high) / 2.0))
        for low, high in ((LOWER, UPPER - BOARD), (UPPER, HEIGHT))
    ]
    visuals = (
        Visual(mesh_shape("boards", bevelled([*boards[1:], *partition])), WOOD),
        Visual(mesh_shape("back", bevelled(boards[:1])), BACK),
    )
    link = Link("bookcase", 10.0, visuals, tuple(box_shape(size, center) for size, center in (*boards, *partition)))
    notes = (*_notes(width), f"a partition in the middle, {BOARD} thick, begins {RECESS} behind the front")
    return Model("bookcase", "objects/bookcase", "bottom centre", (link,), notes=notes)


def _notes(width: float) -> tuple[str, ...]:
    return (
        f"open towards -x and upwards; front edge at x = {-DEPTH / 2.0}, back at x = {DEPTH / 2.0 - BOARD:.3f}, "
        f"sides at y = +-{width / 2.0 - BOARD:.3f}, as high as {HEIGHT}",
        f"upper sides of the boards at z = {LOWER} and {UPPER}; {UPPER - BOARD - LOWER:.3f} free above the lower one",
    )


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    return (*(_book(color) for color in COLORS), _bookshelf(), _bookcase())
