"""Small images for the room and for domain randomization, computed from formulas."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from assets_lib.files import png_bytes
from assets_lib.mesh import FloatArray

ROOM, SET, PATTERNS = "room", "textures", "patterns"
PATTERN_SIZES = {"wood": 0.24, "brushed": 0.16, "cardboard": 0.12, "cloth": 0.06}
"""Side of each pattern on a surface [m]."""
TABLE_X, TABLE_Y = (-0.65, 0.95), (-0.75, 0.75)
ROOM_X, ROOM_Y = (-1.75, 2.25), (-2.0, 2.0)
"""Area of table and floor; no wall is farther from the work than the cameras see [m]."""


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
    """Return the whole top of the table: one slab of warm pale wood, the grain along x, with a darker lipping at its edge."""
    rng = np.random.default_rng(3)
    bend = 0.02 * _noise(rng, size, size, (3, 4)) + np.arange(size)[:, None] / size
    rings = 0.5 + 0.5 * np.sin(2.0 * np.pi * 9.0 * (bend + 0.05 * _noise(rng, size, size, (5, 2))))
    shade = 1.0 + 0.018 * (rings**3 - 0.4) + 0.012 * _noise(rng, size, size, (160, 6)) + 0.01 * _noise(rng, size, size, (4, 3))
    edge = _edge_distance(size, size)
    shade[edge < 9] *= 0.80
    shade[(edge >= 9) & (edge < 10)] *= 0.68
    shade[edge < 1] *= 1.18
    return _paint((0.83, 0.725, 0.59), np.round(shade, 2))


def floor(size: int = 512) -> NDArray[np.uint8]:
    """Return the whole floor: grey linoleum, darker below the table and along the walls, where less light gets."""
    rng = np.random.default_rng(5)
    x, y = (np.linspace(low, high, size) for low, high in (ROOM_X, ROOM_Y))
    beyond = np.hypot(*np.meshgrid(_beyond(x, TABLE_X), _beyond(y[::-1], TABLE_Y)))
    open_sky = 1.0 - 0.42 * np.exp(-((beyond / 0.45) ** 2))
    wall = _edge_distance(size, size) * (ROOM_X[1] - ROOM_X[0]) / size
    shade = open_sky * (1.0 - 0.20 * np.exp(-wall / 0.25)) + 0.012 * _noise(rng, size, size, (96, 96))
    return _paint((0.47, 0.50, 0.54), np.round(shade, 2))


def wall(size: int = 128) -> NDArray[np.uint8]:
    """Return a plainly painted wall, a little darker towards floor, ceiling and corners."""
    y = (np.arange(size) + 0.5) / size
    x = np.minimum(y, 1.0 - y)
    shade = (
        1.0 - 0.10 * np.exp(-(1.0 - y) / 0.10)[:, None] - 0.05 * np.exp(-y / 0.08)[:, None] - 0.06 * np.exp(-x / 0.05)[None, :]
    )
    return _paint((0.78, 0.815, 0.83), shade)


def _edge_distance(height: int, width: int) -> NDArray[np.int64]:
    """Return of each pixel (h, w) how many lie between it and the nearest border."""
    rows, columns = (np.minimum(np.arange(side), np.arange(side)[::-1]) for side in (height, width))
    return np.minimum(rows[:, None], columns[None, :])


def _beyond(values: FloatArray, span: tuple[float, float]) -> FloatArray:
    """Return how far values lie outside a span."""
    return np.maximum(np.maximum(span[0] - values, values - span[1]), 0.0)


def write_room_textures(assets: Path) -> None:
    """Write the pictures of the room below `assets`."""
    _write(assets / ROOM, {"wood": wood(), "floor": floor(), "wall": wall()})


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


# Surfaces of objects -------------------------------------------------------------------------------------------------


def patterns(size: int = 64) -> dict[str, NDArray[np.uint8]]:
    """Return what brightens and darkens colours: grain along x, brushing along x, corrugation along y, and a weave."""
    rng = np.random.default_rng(29)
    x, y = _grid(size)
    tau = 2.0 * np.pi
    bend = y + 0.03 * _noise(rng, size, size, (3, 2)) + 0.012 * np.sin(tau * x)
    rings = 0.5 + 0.5 * np.sin(tau * 6.0 * bend + 2.0 * _noise(rng, size, size, (4, 1)))
    shades = {
        "wood": 0.07 * (rings**2 - 0.4) + 0.03 * _noise(rng, size, size, (32, 3)) + 0.04 * _noise(rng, size, size, (3, 2)),
        "brushed": 0.07 * _noise(rng, size, size, (size, 2)) + 0.04 * _noise(rng, size, size, (16, 1)),
        "cardboard": 0.015 * np.sin(tau * 16.0 * x)
        + 0.03 * _noise(rng, size, size, (16, 16))
        + 0.02 * _noise(rng, size, size, (3, 3)),
        "cloth": 0.10 * np.sin(tau * 8.0 * x) * np.sin(tau * 8.0 * y) + 0.05 * _noise(rng, size, size, (8, 8)),
    }
    tints = {"wood": (0.6, 1.0, 1.5)}
    return {
        name: np.round(200.0 * (1.0 + np.round(shade, 2)[:, :, None] * np.array(tints.get(name, (1.0, 1.0, 1.0))))).astype(
            np.uint8
        )
        for name, shade in shades.items()
    }


def write_patterns(assets: Path) -> None:
    """Write the patterns of the surfaces of objects below `assets`."""
    _write(assets / PATTERNS, patterns())
