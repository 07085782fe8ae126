"""Contact sheets: many small pictures on one large one, with captions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw, ImageFont

_MARGIN = 8
_CAPTION = 18
_TITLE = 46
_INK, _PAPER, _FAINT = (30, 30, 30), (255, 255, 255), (110, 110, 110)


def contact_sheet(
    pictures: Sequence[Sequence[np.ndarray]], rows: Sequence[str], columns: Sequence[str], title: str, subtitle: str
) -> Image.Image:
    """Lay pictures out in a grid.

    Args:
        pictures: One row of uint8 (h, w, 3) arrays, all of one shape, per entry of `rows`.
        rows: Captions of the rows.
        columns: Captions of the columns.
        title: First line at the top.
        subtitle: Second line at the top.
    """
    height, width = pictures[0][0].shape[:2]
    cell = (width + _MARGIN, height + _CAPTION + _MARGIN)
    sheet = Image.new("RGB", (_MARGIN + len(columns) * cell[0], _TITLE + _MARGIN + len(rows) * cell[1]), _PAPER)
    draw = ImageDraw.Draw(sheet)
    draw.text((_MARGIN, 6), title, fill=_INK, font=font(17))
    draw.text((_MARGIN, 28), subtitle, fill=_FAINT, font=font(13))
    for i, (row, name) in enumerate(zip(pictures, rows)):
        for j, (picture, camera) in enumerate(zip(row, columns)):
            corner = (_MARGIN + j * cell[0], _TITLE + i * cell[1])
            draw.text(corner, f"{camera}, {name}", fill=_FAINT, font=font(12))
            sheet.paste(Image.fromarray(picture), (corner[0], corner[1] + _CAPTION))
    return sheet


def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return the letters of pictures, `size` high [px]."""
    return ImageFont.load_default(size)
