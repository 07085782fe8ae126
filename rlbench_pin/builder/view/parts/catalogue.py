"""The objects that come with the package: what there is, what is said of each, and how each looks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from rlbench_pin.assets import ASSETS
from rlbench_pin.builder.figures.chain import link_poses
from rlbench_pin.builder.view.parts.raster import painted
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot.geometry import shape_surface
from rlbench_pin.spatial import FloatArray, pose_to_matrix
from rlbench_pin.urdf import read_urdf

SIZE = 128
"""Width and height of a picture [px]."""
_FINE = 2
_PAPER = (244, 246, 248)
_SEEN_FROM = np.array([-0.55, -0.75, 0.55])
_LIGHT = np.array([-0.3, -0.5, 0.81])


@dataclass(frozen=True)
class Asset:
    """One object."""

    name: str
    """Its name, such as `cup`."""
    path: str
    """As a scene file names it."""
    words: str
    """What the catalogue says of it."""

    @property
    def is_mark(self) -> bool:
        """Whether it is only seen, and nothing can touch it."""
        return "visual only" in self.words


@lru_cache(maxsize=1)
def catalogue() -> tuple[Asset, ...]:
    """Return all objects, in alphabetical order."""
    said = _said((ASSETS / "CATALOGUE.md").read_text(encoding="utf-8"))
    names = sorted(path.parent.name for path in ASSETS.glob("objects/*/*.urdf") if path.stem == path.parent.name)
    return tuple(Asset(name, f"objects/{name}/{name}.urdf", said.get(name, "")) for name in names)


def found(assets: Sequence[Asset], words: str) -> list[Asset]:
    """Return the assets whose name or description holds every one of some words, those whose name does first."""
    wanted = words.lower().split()
    hits = [asset for asset in assets if all(word in asset.name or word in asset.words.lower() for word in wanted)]
    return sorted(hits, key=lambda asset: (not all(word in asset.name for word in wanted), asset.name))


def _said(page: str) -> dict[str, str]:
    """Return the bullets of each section of the catalogue, by its title."""
    said: dict[str, list[str]] = {}
    title = ""
    for line in page.splitlines():
        if line.startswith("## "):
            title = line[3:].strip()
        elif line.startswith("- "):
            said.setdefault(title, []).append(line[2:].strip())
    return {name: "; ".join(lines) for name, lines in said.items()}


@lru_cache(maxsize=512)
def thumbnail(urdf: Path) -> NDArray[np.uint8]:
    """Return a picture (128, 128, 3) of a model from the front; an empty one where it cannot be read."""
    picture = np.full((SIZE * _FINE, SIZE * _FINE, 3), _PAPER, np.uint8)
    try:
        corners, colors = _triangles(urdf)
    except RlbenchPinError:
        return picture[:SIZE, :SIZE]
    if len(corners):
        _paint(picture, corners, colors)
    return np.asarray(Image.fromarray(picture).resize((SIZE, SIZE), Image.Resampling.LANCZOS))


def _triangles(urdf: Path) -> tuple[FloatArray, FloatArray]:
    """Return corners (m, 3, 3) and colours (m, 3) of what is seen of a model."""
    model = read_urdf(urdf)
    poses = link_poses(model, {})
    corners, colors = [np.zeros((0, 3, 3))], [np.zeros((0, 3))]
    for link in model.links:
        matrix = pose_to_matrix(poses[link.name]) if link.name in poses else np.eye(4)
        for shape in link.visuals:
            if shape.kind:
                points, triangles = shape_surface(shape)
                corners.append((points @ matrix[:3, :3].T + matrix[:3, 3])[triangles])
                colors.append(np.tile((shape.color or (1.0, 1.0, 1.0))[:3], (len(triangles), 1)))
    return np.concatenate(corners), np.concatenate(colors)


def _paint(picture: NDArray[np.uint8], corners: FloatArray, colors: FloatArray) -> None:
    """Paint the triangles that face the viewer, as large as the picture."""
    toward = _SEEN_FROM / np.linalg.norm(_SEEN_FROM)
    right = np.cross((0.0, 0.0, 1.0), toward)
    right /= np.linalg.norm(right)
    up = np.cross(toward, right)
    flat = corners @ np.stack([right, -up]).T
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    factor = 0.88 * len(picture) / max(float((high - low).max()), 1e-9)
    flat = (flat - 0.5 * (low + high)) * factor + len(picture) / 2
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    bright = 0.45 + 0.6 * np.clip(normals @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
    shades = np.clip(255 * colors * bright[:, None], 0, 255).astype(np.uint8)
    facing = normals @ toward > 0.0
    painted(picture, flat[facing], corners[facing] @ toward, shades[facing])
