"""A baking tray with a grip at its front, and the low wooden block that it stands on."""

from __future__ import annotations

from assets_lib.cabinets import bevelled_box
from assets_lib.mesh import Mesh, box, merge
from assets_lib.urdf import Link, Model, Shape, Visual, box_shape, mesh_shape, metal

DEPTH, WIDTH, HEIGHT, SHEET = 0.16, 0.24, 0.02, 0.003
RIM = 0.007
"""How far the folded rim stands out to the outside, included in depth and width [m]."""
GRIP = (0.036, 0.014, 0.032)
GRIP_CENTER = (-DEPTH / 2.0 - GRIP[0] / 2.0, 0.0, 0.022)
BLOCK = (0.20, 0.27, 0.03)
STEEL, DARK, RUBBER, WOOD = metal((0.60, 0.62, 0.66)), metal((0.46, 0.48, 0.52)), (0.16, 0.16, 0.17), (0.66, 0.50, 0.33)


def _parts() -> tuple[Shape, ...]:
    """Return floor, four walls and grip."""
    x, y = DEPTH / 2.0 - RIM - SHEET / 2.0, WIDTH / 2.0 - RIM - SHEET / 2.0
    middle = HEIGHT / 2.0
    return (
        box_shape((DEPTH - 2 * RIM, WIDTH - 2 * RIM, SHEET), (0.0, 0.0, SHEET / 2.0)),
        *(box_shape((SHEET, WIDTH - 2 * RIM, HEIGHT), (side * x, 0.0, middle)) for side in (-1, 1)),
        *(box_shape((DEPTH - 2 * RIM, SHEET, HEIGHT), (0.0, side * y, middle)) for side in (-1, 1)),
        box_shape(GRIP, GRIP_CENTER),
    )


def _rim() -> Mesh:
    """Return the folded edge."""
    wide, z = RIM + SHEET, HEIGHT - 0.0013
    x, y = (DEPTH - wide) / 2.0, (WIDTH - wide) / 2.0
    bars = [bevelled_box((wide, WIDTH, 0.004), (side * x, 0.0, z), 0.0015) for side in (-1, 1)]
    return merge([*bars, *(bevelled_box((DEPTH, wide, 0.004), (0.0, side * y, z), 0.0015) for side in (-1, 1))])


def _ridges() -> Mesh:
    """Return the pressed ridges of the floor."""
    return merge(box((0.12, 0.004, 0.0012), (0.0, -0.09 + 0.03 * k, SHEET + 0.0004)) for k in range(7))


def _bracket() -> Mesh:
    """Return the sheet that joins the grip to the rim."""
    return merge(
        [
            bevelled_box((0.012, 0.05, 0.005), (-DEPTH / 2.0 - 0.003, 0.0, HEIGHT - 0.003), 0.001),
            bevelled_box((0.02, GRIP[1] + 0.004, 0.036), (-DEPTH / 2.0, 0.0, GRIP_CENTER[2]), 0.002),
        ]
    )


def models() -> tuple[Model, ...]:
    """Return the models of this family."""
    *sheets, grip = _parts()
    visuals = (
        Visual(mesh_shape("sheet", merge(shape.mesh() for shape in sheets)), STEEL, crease=0.1),
        Visual(mesh_shape("rim", _rim()), DARK, crease=0.3),
        Visual(mesh_shape("ridges", _ridges()), DARK, crease=0.1),
        Visual(mesh_shape("bracket", _bracket()), STEEL, crease=0.3),
        Visual(mesh_shape("grip", bevelled_box(grip.size, grip.xyz, 0.003)), RUBBER, crease=0.3),
    )
    tray_notes = (
        f"hollow, {DEPTH} deep, {WIDTH} wide, {HEIGHT} high, front towards -x",
        f"an upright grip of {GRIP} in the middle of the front, its centre at {tuple(round(v, 4) for v in GRIP_CENTER)}",
    )
    tray = Link("tray", 0.08, visuals, _parts(), friction=1.0)
    block = Link(
        "block",
        0.6,
        (
            Visual(mesh_shape("board", bevelled_box(BLOCK, (0.0, 0.0, BLOCK[2] / 2.0))), WOOD, crease=0.3),
            Visual(mesh_shape("ends", merge(_ends())), (0.54, 0.39, 0.24), crease=0.3),
        ),
        (box_shape(BLOCK, (0.0, 0.0, BLOCK[2] / 2.0)),),
    )
    return (
        Model("baking_tray", "objects/baking_tray", "bottom centre, without the grip", (tray,), notes=tray_notes),
        Model("tray_block", "objects/tray_block", "bottom centre", (block,), notes=(f"{BLOCK} along x, y, z",)),
    )


def _ends() -> list[Mesh]:
    """Return the ledges across both ends of the board."""
    x, y, z = BLOCK
    return [bevelled_box((x + 0.002, 0.016, z + 0.001), (0.0, side * (y / 2.0 - 0.012), z / 2.0)) for side in (-1, 1)]
