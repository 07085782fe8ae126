"""Films of several tasks side by side in one."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping

import numpy as np
from PIL import Image, ImageDraw, ImageFont

_GAP, _TEXT, _MARGIN = 4, 14, 6


class Reel:
    """Pictures of one film, compressed in memory."""

    def __init__(self) -> None:
        self._frames: list[bytes] = []

    def __len__(self) -> int:
        return len(self._frames)

    def add(self, picture: np.ndarray) -> None:
        """Append a picture, uint8 (h, w, 3)."""
        stream = io.BytesIO()
        Image.fromarray(picture).save(stream, "JPEG", quality=92)
        self._frames.append(stream.getvalue())

    def frame(self, number: int) -> Image.Image:
        """Return a picture; the last one stands still after the end."""
        return Image.open(io.BytesIO(self._frames[min(number, len(self) - 1)]))


def grid_shape(count: int) -> tuple[int, int]:
    """Columns and rows for `count` cells, nearly as many of both."""
    columns = int(np.ceil(np.sqrt(count)))
    return columns, -(-count // columns)


def grid_size(count: int, cell: tuple[int, int]) -> tuple[int, int]:
    """Width and height of a grid of cells [px], both even."""
    columns, rows = grid_shape(count)
    width, height = columns * (cell[0] + _GAP) - _GAP, rows * (cell[1] + _GAP) - _GAP
    return width + width % 2, height + height % 2


def grid_frames(reels: Mapping[str, Reel], cell: tuple[int, int]) -> Iterator[np.ndarray]:
    """Yield the pictures of all reels side by side, with captions, until the longest has ended."""
    columns, _ = grid_shape(len(reels))
    fonts = {name: _font(name, cell[0] - 2 * _MARGIN) for name in reels}
    for number in range(max(len(reel) for reel in reels.values())):
        sheet = Image.new("RGB", grid_size(len(reels), cell), (20, 20, 20))
        draw = ImageDraw.Draw(sheet)
        for i, (name, reel) in enumerate(reels.items()):
            corner = (i % columns) * (cell[0] + _GAP), (i // columns) * (cell[1] + _GAP)
            sheet.paste(reel.frame(number), corner)
            place = corner[0] + _MARGIN, corner[1] + 4
            draw.text(place, _caption(name), fill=(30, 30, 30), font=fonts[name], stroke_width=1, stroke_fill=(245, 245, 245))
        yield np.asarray(sheet)


def _caption(name: str) -> str:
    return name.replace("_", " ")


def _font(name: str, width: float) -> ImageFont.ImageFont | ImageFont.FreeTypeFont:
    """Return the largest font in which the caption is at most `width` [px] wide; 7 at least."""
    sizes = (ImageFont.load_default(size) for size in range(_TEXT, 7, -1))
    return next((font for font in sizes if font.getlength(_caption(name)) <= width), ImageFont.load_default(7))
