"""Table, floor, walls and ceiling, drawn by formulas.

Over the pixels (u, v) of one rectangle, 1/z, s/z and t/z are affine functions, where z is the depth and s, t are the coordinates
along its edges. So a rectangle costs a few additions and comparisons per pixel, its depth is exact, and what a camera that stands
still sees of the room is drawn once and kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.canvas import Canvas, Panel, sights_of
from rlbench_pin.sim.render.lighting import Lighting

_OUTSIDE = (118, 128, 138)
_ON_WALLS = 0.65
"""By how much more of the ambient light upright sides of the room get, as from lamps along the ceiling."""
PIXEL = np.dtype("V3")
"""Three bytes that are moved as one."""


@dataclass(frozen=True, eq=False)
class _Paint:
    """The colours of one rectangle, rgb bytes of type `PIXEL`; one texel where it has no texture."""

    lit: NDArray[np.void]
    """Texels (t,) in the key light."""
    dark: NDArray[np.void]
    """In its shadow."""


@dataclass(frozen=True, eq=False)
class Backdrop:
    """The room as one camera sees it; rows from the top."""

    rgb: NDArray[np.uint8]
    """Colours where the key light reaches, (h, w, 3)."""
    depth: NDArray[np.float32]
    """Depth [m], `far` where nothing is in range, (h, w)."""
    mask: NDArray[np.int32]
    """Ids, 0 where nothing is in range, (h, w)."""
    owner: NDArray[np.int32]
    """Number of the rectangle that each pixel sees, -1 for none, (h * w,)."""
    texel: NDArray[np.int32]
    """Its texel (h * w,)."""
    paints: Mapping[int, _Paint]
    """The colours of the rectangles that are seen, by number."""

    def dark(self, pixels: NDArray[np.int64]) -> NDArray[np.void]:
        """Colours (n,), of type `PIXEL`, of some pixels in the shadow of the key light."""
        texel = self.texel.take(pixels)
        if len(self.paints) == 1 and self.is_full:
            return next(iter(self.paints.values())).dark.take(texel)
        owner = self.owner.take(pixels)
        colors = self.rgb.reshape(-1).view(PIXEL).take(pixels)
        for number, paint in self.paints.items():
            chosen = (owner == number).nonzero()[0]
            colors[chosen] = paint.dark.take(texel.take(chosen))
        return colors

    @cached_property
    def is_full(self) -> bool:
        """Whether every pixel sees a rectangle."""
        return bool(self.owner.min() >= 0)

    @cached_property
    def all_dark(self) -> NDArray[np.void]:
        """Colours (h * w,), of type `PIXEL`, of all pixels in the shadow of the key light."""
        return self.dark(np.arange(self.owner.size))


class Painter:
    """Draws rectangles under fixed lights.

    Args:
        panels: The rectangles.
        lighting: The lights.
    """

    def __init__(self, panels: Sequence[Panel], lighting: Lighting) -> None:
        self._panels, self._lighting = tuple(panels), lighting
        self._ids = np.array([*(panel.id for panel in panels), 0], dtype=np.int32)
        self._corners, self._edges = np.array([p.corner for p in panels]), np.array([p.edges for p in panels])
        self._bases = _bases(self._edges)
        self._paints: dict[int, _Paint] = {}

    def draw(self, view: CameraView) -> Backdrop:
        """Draw all rectangles as a camera sees them."""
        canvas = Canvas(view)
        to_camera = np.linalg.inv(view.extrinsics())
        rotation, shift = to_camera[:3, :3], to_camera[:3, 3]
        corners, edges = self._corners @ rotation.T + shift, self._edges @ rotation.T
        for sight in sights_of(canvas, corners, edges, self._bases @ rotation.T):
            canvas.add(sight)
        owner, inverse = canvas.owner, canvas.inverse
        colors, texel = (
            np.full(owner.size, np.array(_OUTSIDE, dtype=np.uint8).view(PIXEL)[0]),
            np.zeros(owner.size, dtype=np.int32),
        )
        paints: dict[int, _Paint] = {}
        for number, pixels in canvas.visible():
            paints[number] = paint = self._paint(number)
            texels = canvas.texels(self._panels[number], pixels)
            colors[pixels], texel[pixels] = paint.lit.take(texels), texels
        with np.errstate(divide="ignore"):
            depth: NDArray[np.float32] = np.float32(1.0) / inverse
        ids = self._ids.take(owner, mode="wrap")
        if len(outside := np.flatnonzero((owner < 0) | (inverse * np.float32(view.far) < 1.0))):
            depth.ravel()[outside], ids.ravel()[outside] = view.far, 0
        return Backdrop(colors.view(np.uint8).reshape(*owner.shape, 3), depth, ids, owner.ravel(), texel, paints)

    def _paint(self, number: int) -> _Paint:
        """All texels of a rectangle in the key light and in its shadow."""
        if number not in self._paints:
            panel = self._panels[number]
            texels = np.ones((1, 3), dtype=np.float32) if panel.texture is None else panel.texture.texels
            bright, shaded = _light_on(panel, self._lighting)
            self._paints[number] = _Paint(_packed(texels * bright), _packed(texels * shaded))
        return self._paints[number]


def _bases(edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Normals n, and vectors whose products with a point of a rectangle give s and t, stacked to (m, 3, 3)."""
    normals = np.cross(edges[:, 0], edges[:, 1])
    across = np.stack([np.cross(edges[:, 1], normals), np.cross(normals, edges[:, 0])], axis=1)
    along = across / np.einsum("ijk,ijk->ij", edges, across)[..., None]
    return np.concatenate([normals[:, None], along], axis=1)


def _light_on(panel: Panel, lighting: Lighting) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Colour (3,) of the rectangle in the key light, and in its shadow."""
    normal, tint = panel.normal, np.array(panel.color)
    ambient = lighting.ambient * (1.0 + _ON_WALLS * (1.0 - abs(float(normal[2]))))
    shaded = ambient + sum(float(fill.on(normal)) * np.array(fill.color) for fill in lighting.fills)
    key = float(lighting.key.on(normal)) * np.array(lighting.key.color)
    ambient_color = np.array(lighting.key.color) * 0.5 + 0.5
    shaded = shaded * ambient_color
    return (tint * (shaded + key)).astype(np.float32), (tint * shaded).astype(np.float32)


def _packed(colors: NDArray) -> NDArray[np.void]:
    """Colours (n, 3) in 0..1 as rgb bytes (n,) of type `PIXEL`."""
    return np.minimum(colors * 255.0 + 0.5, 255.0).astype(np.uint8).reshape(-1).view(PIXEL)
