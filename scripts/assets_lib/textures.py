"""Small pictures for the room and for domain randomization, drawn by formulas."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from assets_lib.files import png_bytes
from assets_lib.mesh import FloatArray

ROOM, SET = "room", "textures"


def _noise(rng: np.random.Generator, height: int, width: int, cells: tuple[int, int]) -> FloatArray:
    """Return smooth noise in -1..1 that repeats at the borders."""
    grid = rng.uniform(-1.0, 1.0, cells)
    y, x = np.arange(height) / height * cells[0], np.arange(width) / width * cells[1]
    iy, ix = y.astype(int), x.astype(int)
    fy, fx = _ease(y - iy)[:, None], _ease(x - ix)[None, :]
    at = [grid[np.ix_((iy + dy) % cells[0], (ix + dx) % cells[1])] for dy in (0, 1) for dx in (0, 1)]
    return (at[0] * (1 - fx) + at[1] * fx) * (1 - fy) + (at[2] * (1 - fx) + at[3] * fx) * fy


def _ease(t: FloatArray) -> FloatArray:
    return t * t * (3.0 - 2.0 * t)


def _paint(color: tuple[float, float, float], shade: FloatArray) -> NDArray[np.uint8]:
    """Return an RGB image of one colour times a brightness (h, w)."""
    image = np.clip(np.array(color) * shade[:, :, None], 0.0, 1.0)
    return np.round(image * 255.0).astype(np.uint8)


def wood(size: int = 512) -> NDArray[np.uint8]:
    """Return a pale table top of narrow boards, each with a grain and a tone of its own."""
    rng = np.random.default_rng(3)
    boards, seam = 10, 2
    board = np.arange(size) * boards // size
    shade = 1.0 + rng.uniform(-0.022, 0.022, boards)[board][:, None] + np.zeros((size, size))
    grain = 0.016 * _noise(rng, size, size, (128, 5)) + 0.008 * _noise(rng, size, size, (256, 12))
    # each board is cut from another place, so that no grain runs over a seam
    shifts = rng.integers(0, size, boards)[board]
    shade += np.take_along_axis(grain, (np.arange(size)[None, :] + shifts[:, None]) % size, axis=1)
    row = np.arange(size) - np.ceil(board * size / boards).astype(int)
    shade[row < seam] *= 0.89
    for number, end in enumerate(rng.integers(0, size - seam, boards)):
        shade[board == number, end : end + seam] *= 0.90
    return _paint((0.785, 0.755, 0.71), np.round(shade, 2))


def tiles(size: int = 128) -> NDArray[np.uint8]:
    """Return a grey tiled floor, two by two tiles."""
    rng = np.random.default_rng(5)
    y, x = np.mgrid[0:size, 0:size] * 2 // size
    tone = rng.uniform(0.94, 1.04, (2, 2))[y, x]
    shade = tone + 0.03 * _noise(rng, size, size, (16, 16))
    seam = (np.arange(size) * 2 % size) < 4
    shade[seam, :] = shade[:, seam] = 0.78
    return _paint((0.58, 0.59, 0.60), np.round(shade, 2))


def wall(height: int = 128, width: int = 128) -> NDArray[np.uint8]:
    """Return a painted wall: off-white above, a panelled dado in light grey and a skirting board below."""
    image = _paint((0.885, 0.885, 0.875), np.ones((height, width)))
    low = int(0.62 * height)
    dado = np.ones((height, width))
    dado[:, (np.arange(width) * 5 % width) < 5] = 0.93
    image[low:] = _paint((0.69, 0.715, 0.735), dado)[low:]
    image[low - 3 : low] = (236, 236, 234)
    image[int(0.95 * height) :] = (236, 236, 234)
    return image


def write_room_textures(assets: Path) -> None:
    """Write the pictures of the room below `assets`."""
    _write(assets / ROOM, {"wood": wood(), "tiles": tiles(), "wall": wall()})


def _write(folder: Path, images: dict[str, NDArray[np.uint8]]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, image in images.items():
        (folder / f"{name}.png").write_bytes(png_bytes(image))


# Domain randomization ------------------------------------------------------------------------------------------------


def _blend(a: tuple[float, ...], b: tuple[float, ...], share: FloatArray) -> NDArray[np.uint8]:
    """Return an RGB image between two colours; shares are rounded so that the files stay small."""
    share = np.round(np.clip(share, 0.0, 1.0), 1)[:, :, None]
    return np.round(255.0 * (np.array(a) * (1.0 - share) + np.array(b) * share)).astype(np.uint8)


def _grid(size: int) -> tuple[FloatArray, FloatArray]:
    y, x = np.mgrid[0:size, 0:size] / size
    return x, y


def _clouds(rng: np.random.Generator, size: int, cells: int) -> FloatArray:
    total = _noise(rng, size, size, (cells, cells)) + 0.5 * _noise(rng, size, size, (2 * cells, 2 * cells))
    return 0.5 + 0.5 * total


def texture_set(size: int = 64) -> dict[str, NDArray[np.uint8]]:
    """Return two dozen patterns that repeat at their borders."""
    rng = np.random.default_rng(17)
    x, y = _grid(size)
    tau = 2.0 * np.pi
    shares: dict[str, FloatArray] = {
        "checks": (((x * 4).astype(int) + (y * 4).astype(int)) % 2).astype(float),
        "stripes": 0.5 + 0.5 * np.sign(np.sin(tau * 4 * x)),
        "diagonal": 0.5 + 0.5 * np.sign(np.sin(tau * 3 * (x + y))),
        "waves": 0.5 + 0.5 * np.sin(tau * (4 * y + 0.2 * np.sin(tau * 2 * x))),
        "dots": (np.hypot((x * 4) % 1 - 0.5, (y * 4) % 1 - 0.5) < 0.3).astype(float),
        "rings": 0.5 + 0.5 * np.sin(tau * 5 * np.hypot(np.sin(np.pi * x), np.sin(np.pi * y))),
        "bricks": _bricks(x, y),
        "clouds": _clouds(rng, size, 3),
        "speckle": _clouds(rng, size, 16),
        "marble": 0.5 + 0.5 * np.sin(tau * (2 * x + 0.5 * _clouds(rng, size, 4))),
        "grain": 0.5 + 0.5 * _noise(rng, size, size, (32, 3)),
        "weave": 0.5 + 0.25 * np.sin(tau * 8 * x) + 0.25 * np.sin(tau * 8 * y),
    }
    images = {}
    for name, share in shares.items():
        for number in (1, 2):
            low, high = rng.uniform(0.05, 0.6, 3), rng.uniform(0.35, 1.0, 3)
            images[f"{name}_{number}"] = _blend(tuple(low), tuple(high), share)
    return images


def _bricks(x: FloatArray, y: FloatArray) -> FloatArray:
    row = (y * 8).astype(int)
    across = (x * 4 + 0.5 * (row % 2)) % 1.0
    return ((across > 0.08) & ((y * 8) % 1.0 > 0.16)).astype(float)


def write_texture_set(assets: Path) -> None:
    """Write the patterns for domain randomization below `assets`."""
    _write(assets / SET, texture_set())
