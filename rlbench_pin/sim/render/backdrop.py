"""Table, floor, walls and ceiling, drawn by formulas.

Over the pixels (u, v) of one rectangle, 1/z, s/z and t/z are affine functions, where z is the depth and s, t are the coordinates
along its edges. So a rectangle costs a few additions and comparisons per pixel, its depth is exact, and what a camera that stands
still sees of the room is drawn once and kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.canvas import Canvas, Panel, sights_of
from rlbench_pin.sim.render.lighting import Lighting

_ON_WALLS = 0.65
"""By how much more of the ambient light upright sides of the room get, as from lamps along the ceiling."""
PIXEL = np.dtype("V3")
"""Three bytes that are moved as one."""
_OUTSIDE = np.array((118, 128, 138), dtype=np.uint8).view(PIXEL)[0]


class Paints:
    """The colours of all rectangles that were seen so far, rgb bytes of type `PIXEL`; the first is that of emptiness.

    Attributes:
        lit: Texels (t,) in the key light.
        dark: In its shadow.
    """

    def __init__(self) -> None:
        self.lit = self.dark = np.array([_OUTSIDE], dtype=PIXEL)
        self._starts: dict[int, int] = {}

    def start(self, number: int, panel: Panel, lighting: Lighting) -> int:
        """Number of the first texel of a rectangle, one texel where it has no texture; added when it is asked for first."""
        if number not in self._starts:
            self._starts[number] = len(self.lit)
            texels = np.ones((1, 3), dtype=np.float32) if panel.texture is None else panel.texture.texels
            bright, shaded = _light_on(panel, lighting)
            self.lit = np.concatenate([self.lit, _packed(texels * bright)])
            self.dark = np.concatenate([self.dark, _packed(texels * shaded)])
        return self._starts[number]


@dataclass(frozen=True, eq=False)
class Backdrop:
    """The room as one camera sees it; rows from the top."""

    rgb: NDArray[np.uint8]
    """Colours where the key light reaches, (h, w, 3)."""
    depth: NDArray[np.float32]
    """Depth [m], `far` where nothing is in range, (h, w)."""
    mask: NDArray[np.int32]
    """Ids, 0 where nothing is in range, (h, w)."""
    texel: NDArray[np.int32]
    """Number of the texel that each pixel sees (h * w,)."""
    paints: Paints
    """The colours of the texels."""

    def dark(self, pixels: NDArray[np.int64]) -> NDArray[np.void]:
        """Colours (n,), of type `PIXEL`, of some pixels in the shadow of the key light."""
        return self.paints.dark.take(self.texel.take(pixels))

    @cached_property
    def all_dark(self) -> NDArray[np.void]:
        """Colours (h * w,), of type `PIXEL`, of all pixels in the shadow of the key light."""
        return self.paints.dark.take(self.texel)


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
        self._paints = Paints()

    def draw(self, view: CameraView) -> Backdrop:
        """Draw all rectangles as a camera sees them."""
        canvas = Canvas(view)
        to_camera = np.linalg.inv(view.extrinsics())
        rotation, shift = to_camera[:3, :3], to_camera[:3, 3]
        corners, edges = self._corners @ rotation.T + shift, self._edges @ rotation.T
        canvas.draw(sights_of(canvas, corners, edges, self._bases @ rotation.T))
        owner, inverse = canvas.owner, canvas.inverse
        texel = np.zeros(owner.size, dtype=np.int32)
        for number, pixels in canvas.visible():
            panel = self._panels[number]
            texels = canvas.texels(panel, pixels)
            texels += np.int32(self._paints.start(number, panel, self._lighting))
            if isinstance(pixels, slice):
                texel = texels
            else:
                texel[pixels] = texels
        with np.errstate(divide="ignore"):
            depth: NDArray[np.float32] = np.float32(1.0) / inverse
        ids = self._ids.take(owner, mode="wrap")
        if len(outside := (inverse.ravel() * np.float32(view.far) < 1.0).nonzero()[0]):
            depth.ravel()[outside], ids.ravel()[outside] = view.far, 0
        rgb = self._paints.lit.take(texel).view(np.uint8).reshape(*owner.shape, 3)
        return Backdrop(rgb, depth, ids, texel, self._paints)


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
