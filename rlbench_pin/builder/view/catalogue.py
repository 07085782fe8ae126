"""Assets that can be added: the catalogue of the package with thumbnails, and URDF files of primitives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from rlbench_pin.assets import ASSETS
from rlbench_pin.builder.custom_assets.urdf_file import one_link_urdf
from rlbench_pin.errors import InvalidValue, RlbenchPinError
from rlbench_pin.robot.geometry import shape_surface
from rlbench_pin.spatial import FloatArray, pose_to_matrix
from rlbench_pin.urdf import read_urdf
from rlbench_pin.values import as_choice, as_number, as_text
from rlbench_pin.viewer.places import link_poses

SIZE = 128
"""Width and height of a thumbnail [px]."""
_OVERSAMPLING = 2
_BACKGROUND = (244, 246, 248)
_VIEWPOINT = np.array([-0.55, -0.75, 0.55])
_LIGHT = np.array([-0.3, -0.5, 0.81])
_TIE = 2e-5
"""Of surfaces within this distance, the later one is seen, such as a label [m]."""
Vector3 = tuple[float, float, float]
Primitive = Literal["box", "cylinder", "sphere"]
"""Shape of a primitive."""
PRIMITIVES: tuple[Primitive, ...] = ("box", "cylinder", "sphere")
SIZES = {"box": ("x", "y", "z"), "cylinder": ("diameter", "height"), "sphere": ("diameter",)}
"""Names of the sizes [m]."""
_MAX_SIZE = 2.0


@dataclass(frozen=True)
class Asset:
    """An object of the catalogue."""

    name: str
    """Such as `cup`."""
    path: str
    """Path in a scene file."""
    words: str
    """Description in the catalogue."""

    @property
    def is_mark(self) -> bool:
        """Whether it has no collision geometry."""
        return "visual only" in self.words


@lru_cache(maxsize=1)
def catalogue() -> tuple[Asset, ...]:
    """Return all objects, in alphabetical order."""
    texts = _descriptions((ASSETS / "CATALOGUE.md").read_text(encoding="utf-8"))
    names = sorted(path.parent.name for path in ASSETS.glob("objects/*/*.urdf") if path.stem == path.parent.name)
    return tuple(Asset(name, f"objects/{name}/{name}.urdf", texts.get(name, "")) for name in names)


def search(assets: Sequence[Asset], words: str) -> list[Asset]:
    """Return the assets with all words in name or description, those with all in the name first."""
    wanted = words.lower().split()
    hits = [asset for asset in assets if all(word in asset.name or word in asset.words.lower() for word in wanted)]
    return sorted(hits, key=lambda asset: (not all(word in asset.name for word in wanted), asset.name))


def _descriptions(page: str) -> dict[str, str]:
    """Return the bullets of each section of the catalogue, by its title."""
    texts: dict[str, list[str]] = {}
    title = ""
    for line in page.splitlines():
        if line.startswith("## "):
            title = line[3:].strip()
        elif line.startswith("- "):
            texts.setdefault(title, []).append(line[2:].strip())
    return {name: "; ".join(lines) for name, lines in texts.items()}


@lru_cache(maxsize=512)
def thumbnail(urdf: Path) -> NDArray[np.uint8]:
    """Return an image (128, 128, 3) of a model; an empty one for an unreadable file."""
    image = np.full((SIZE * _OVERSAMPLING, SIZE * _OVERSAMPLING, 3), _BACKGROUND, np.uint8)
    try:
        corners, colors = _triangles(urdf)
    except RlbenchPinError:
        return image[:SIZE, :SIZE]
    if len(corners):
        _draw(image, corners, colors)
    return np.asarray(Image.fromarray(image).resize((SIZE, SIZE), Image.Resampling.LANCZOS))


@lru_cache(maxsize=512)
def model_size(urdf: Path) -> Vector3:
    """Return the size of a model along x, y, z [m]; zeros for an unreadable file."""
    try:
        points = _triangles(urdf)[0].reshape(-1, 3)
    except RlbenchPinError:
        return 0.0, 0.0, 0.0
    x, y, z = np.ptp(points, axis=0).tolist() if len(points) else (0.0, 0.0, 0.0)
    return x, y, z


def _triangles(urdf: Path) -> tuple[FloatArray, FloatArray]:
    """Return triangles (m, 3, 3) and colours (m, 3) of the visuals of a model."""
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


def _draw(image: NDArray[np.uint8], corners: FloatArray, colors: FloatArray) -> None:
    """Draw the triangles that face the viewer, scaled to the image."""
    toward = _VIEWPOINT / np.linalg.norm(_VIEWPOINT)
    right = np.cross((0.0, 0.0, 1.0), toward)
    right /= np.linalg.norm(right)
    up = np.cross(toward, right)
    flat = corners @ np.stack([right, -up]).T
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    factor = 0.88 * len(image) / max(float((high - low).max()), 1e-9)
    flat = (flat - 0.5 * (low + high)) * factor + len(image) / 2
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    bright = 0.45 + 0.6 * np.clip(normals @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
    shades = np.clip(255 * colors * bright[:, None], 0, 255).astype(np.uint8)
    facing = normals @ toward > 0.0
    draw_triangles(image, flat[facing], corners[facing] @ toward, shades[facing])


def draw_triangles(image: NDArray[np.uint8], points: FloatArray, depths: FloatArray, shades: NDArray[np.uint8]) -> None:
    """Draw triangles with a depth buffer into an image.

    Args:
        image: (height, width, 3), changed in place.
        points: Corners (m, 3, 2) as x to the right and y downwards [px].
        depths: Nearness of the corners (m, 3) [m].
        shades: Colours (m, 3).
    """
    nearest = np.full(image.shape[:2], -np.inf)
    size = np.array(image.shape[1::-1])
    low = np.clip(np.floor(points.min(axis=1)), 0, size - 1).astype(int)
    high = np.clip(np.ceil(points.max(axis=1)) + 1, 1, size).astype(int)
    for (x0, y0), (x1, y1), corners, depth, shade in zip(low, high, points, depths, shades, strict=True):
        a, b, c = corners
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if abs(area) < 1e-9:
            continue
        x, y = np.arange(x0, x1) + 0.5, (np.arange(y0, y1) + 0.5)[:, None]
        second = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
        third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
        here = depth[0] + second * (depth[1] - depth[0]) + third * (depth[2] - depth[0])
        seen = (second >= -1e-9) & (third >= -1e-9) & (second + third <= 1 + 1e-9) & (here >= nearest[y0:y1, x0:x1] - _TIE)
        nearest[y0:y1, x0:x1][seen] = here[seen]
        image[y0:y1, x0:x1][seen] = shade


# Primitives ----------------------------------------------------------------------------------------------------------


def primitive_urdf(name: str, kind: Primitive, size: Sequence[float], mass: float, color: Sequence[float]) -> str:
    """Return a URDF file of one link around its centre, with the inertia of uniform density.

    Args:
        name: Name of model and link.
        kind: Shape.
        size: Sizes in the order of `SIZES` [m].
        mass: [kg].
        color: Red, green, blue from 0 to 1.

    Raises:
        InvalidValue: A size or the mass is not above 0, or there are too many or too few numbers.
    """
    words = SIZES[as_choice(kind, "kind", PRIMITIVES)]
    if len(size) != len(words):
        raise InvalidValue("size", size, f"has to be {', '.join(words)} [m]")
    lengths = [as_number(value, f"{word} [m]", above=0.0, most=_MAX_SIZE) for word, value in zip(words, size)]
    mass = as_number(mass, "mass [kg]", above=0.0, most=100.0)
    rgb = [as_number(share, "colour", least=0.0, most=1.0) for share in color[:3]]
    x, y, z = (f"{moment:.6g}" for moment in _moments(kind, lengths, mass))
    inertial = (f'<mass value="{mass:g}"/>', f'<inertia ixx="{x}" ixy="0" ixz="0" iyy="{y}" iyz="0" izz="{z}"/>')
    shape = _shape(kind, lengths)
    return one_link_urdf(as_text(name, "name"), inertial, shape, [shape], rgb)


def _shape(kind: Primitive, size: Sequence[float]) -> str:
    if kind == "box":
        return f'<box size="{size[0]:g} {size[1]:g} {size[2]:g}"/>'
    if kind == "cylinder":
        return f'<cylinder radius="{size[0] / 2.0:g}" length="{size[1]:g}"/>'
    return f'<sphere radius="{size[0] / 2.0:g}"/>'


def _moments(kind: Primitive, size: Sequence[float], mass: float) -> Vector3:
    """Moments of inertia about the centre [kg m^2]."""
    if kind == "box":
        x, y, z = (side * side for side in size)
        return mass * (y + z) / 12.0, mass * (x + z) / 12.0, mass * (x + y) / 12.0
    if kind == "cylinder":
        radius, height = size[0] / 2.0, size[1]
        across = mass * (3.0 * radius**2 + height**2) / 12.0
        return across, across, mass * radius**2 / 2.0
    moment = 0.4 * mass * (size[0] / 2.0) ** 2
    return moment, moment, moment
