"""Table, floor, walls and ceiling, drawn by formulas.

Over the pixels (u, v) of one rectangle, 1/z, s/z and t/z are affine functions, where z is the depth and s, t are the coordinates
along its edges. So a rectangle costs a few additions and comparisons per pixel, its depth is exact, and what a camera that stands
still sees of the room is drawn once and kept.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView, pixel_rays
from rlbench_pin.sim.render.lighting import Lighting
from rlbench_pin.sim.render.texture import Texture

_OUTSIDE = (118, 128, 138)
_CLOSE = 1e-3  # [m]
_SLACK = 1.0001  # for rounding


@dataclass(frozen=True, eq=False)
class Panel:
    """One rectangle in the world."""

    corner: NDArray[np.float64]
    """(3,) [m]."""
    edges: NDArray[np.float64]
    """(2, 3) [m]."""
    id: int
    """Mask id."""
    color: tuple[float, float, float]
    texture: Texture | None = None
    uv: NDArray[np.float64] | None = None

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit vector (3,) out of the side that is seen."""
        n = np.cross(self.edges[0], self.edges[1])
        return n / np.linalg.norm(n)


@dataclass(frozen=True, eq=False)
class Backdrop:
    """The room as one camera sees it; rows from the top. Colours are rgba bytes in one uint32."""

    lit: NDArray[np.uint32]
    """Colours where the key light reaches, (h, w)."""
    dark: NDArray[np.uint32]
    """Colours in its shadow, (h, w)."""
    depth: NDArray[np.float32]
    """Depth [m], `far` where nothing is in range, (h, w)."""
    mask: NDArray[np.int32]
    """Ids, 0 where nothing is in range, (h, w)."""


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
        self._paints: dict[int, tuple[NDArray[np.uint32], NDArray[np.uint32]]] = {}

    def draw(self, view: CameraView) -> Backdrop:
        """Draw all rectangles as a camera sees them."""
        canvas = _Canvas(view)
        to_camera = np.linalg.inv(view.extrinsics())
        rotation, shift = to_camera[:3, :3], to_camera[:3, 3]
        corners, edges = self._corners @ rotation.T + shift, self._edges @ rotation.T
        bases = self._bases @ rotation.T
        sights = [canvas.sight(n, corners[n], edges[n], bases[n]) for n in self._in_sight(view, corners, edges, bases[:, 0])]
        for sight in sorted((sight for sight in sights if sight is not None), key=lambda sight: -sight.nearest):
            canvas.add(sight)
        lit, dark = self._paint(canvas)
        inverse, owner = canvas.inverse, canvas.owner
        in_range = (owner >= 0) & (inverse * np.float32(view.far) >= 1.0)
        depth = np.full(owner.shape, view.far, dtype=np.float32)
        np.divide(np.float32(1.0), inverse, out=depth, where=in_range)
        return Backdrop(lit, dark, depth, self._ids[np.where(in_range, owner, -1)])

    @staticmethod
    def _in_sight(view: CameraView, corners: NDArray, edges: NDArray, normals: NDArray) -> list[int]:
        """Numbers of the rectangles that face the camera and reach into its pyramid."""
        facing = np.einsum("ij,ij->i", normals, corners) < 0.0
        points = corners[:, None] + np.stack([0.0 * corners, edges[:, 0], edges[:, 1], edges[:, 0] + edges[:, 1]], axis=1)
        width, height = view.size
        slope_x, slope_y = (0.5 * (side + 2) / abs(view.intrinsics()[0, 0]) * points[..., 2] for side in (width, height))
        x, y, z = points[..., 0], points[..., 1], points[..., 2]
        outside = [x > slope_x, -x > slope_x, y > slope_y, -y > slope_y, z < view.near]
        return np.flatnonzero(facing & ~np.any([side.all(axis=1) for side in outside], axis=0)).tolist()

    def _paint(self, canvas: _Canvas) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """Colours in the key light and in its shadow."""
        lit, dark = (np.full(canvas.owner.size, _packed(np.array([_OUTSIDE]) / 255.0)[0]) for _ in range(2))
        for number, pixels in canvas.visible():
            bright, shaded = self._colors(number)
            texels = canvas.texels(self._panels[number], pixels)
            lit[pixels], dark[pixels] = bright[texels], shaded[texels]
        return lit.reshape(canvas.owner.shape), dark.reshape(canvas.owner.shape)

    def _colors(self, number: int) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
        """All texels of a rectangle in the key light and in its shadow; one texel where there is no texture."""
        if number not in self._paints:
            panel = self._panels[number]
            texels = np.ones((1, 3), dtype=np.float32) if panel.texture is None else panel.texture.texels
            bright, shaded = _light_on(panel, self._lighting)
            self._paints[number] = _packed(texels * bright), _packed(texels * shaded)
        return self._paints[number]


def _bases(edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Normals n, and vectors whose products with a point of a rectangle give s and t, stacked to (m, 3, 3)."""
    normals = np.cross(edges[:, 0], edges[:, 1])
    across = np.stack([np.cross(edges[:, 1], normals), np.cross(normals, edges[:, 0])], axis=1)
    along = across / np.einsum("ijk,ijk->ij", edges, across)[..., None]
    return np.concatenate([normals[:, None], along], axis=1)


@dataclass(frozen=True, eq=False)
class _Sight:
    """Where one rectangle can be seen, and how 1/z, s/z and t/z follow from the ray of a pixel."""

    number: int
    window: tuple[slice, slice]
    """Rows and columns."""
    forms: NDArray[np.float64]
    """(3, 3): each times (x, y, 1) of a ray."""
    nearest: float
    """Greatest 1/z that its plane has in the window."""


class _Canvas:
    """Which rectangle each pixel sees, and where on it."""

    def __init__(self, view: CameraView) -> None:
        width, height = view.size
        self._view, self._shape = view, (height, width)
        self._k = view.intrinsics()
        self._columns, self._rows = pixel_rays(view)
        self.owner = np.full(self._shape, -1, dtype=np.int32)
        self.inverse, self._s, self._t = (np.zeros(self._shape, dtype=np.float32) for _ in range(3))

    def sight(self, number: int, corner: NDArray, edges: NDArray, basis: NDArray) -> _Sight | None:
        """Where a rectangle, given in camera coordinates, can be seen; None when it is out of sight."""
        window = self._window(corner, edges)
        if window is None:
            return None
        forms = np.empty((3, 3))
        forms[0] = basis[0] / (basis[0] @ corner)
        for form, along in zip(forms[1:], basis[1:], strict=True):
            form[:] = along - (along @ corner) * forms[0]
        rows, columns = (rays[part][[0, -1]] for rays, part in zip((self._rows, self._columns), window, strict=True))
        nearest = float((forms[0, 1] * rows).max() + (forms[0, 0] * columns).max() + forms[0, 2])
        return _Sight(number, window, forms, nearest)

    def add(self, sight: _Sight) -> None:
        """Draw one rectangle where it is nearer than what is there."""
        window = sight.window
        there = self.inverse[window]
        if float(there.min()) > sight.nearest * _SLACK:
            return
        inverse, s, t = (self._affine(form, window) for form in sight.forms)
        seen = (inverse > there) & (s >= 0.0) & (s <= inverse) & (t >= 0.0) & (t <= inverse)
        seen &= inverse * np.float32(self._view.near) < 1.0
        np.copyto(self.owner[window], sight.number, where=seen)
        for target, value in ((self.inverse, inverse), (self._s, s), (self._t, t)):
            np.copyto(target[window], value, where=seen)

    def _affine(self, form: NDArray, window: tuple[slice, slice]) -> NDArray[np.float32]:
        rows = (form[1] * self._rows[window[0]] + form[2]).astype(np.float32)
        columns = (form[0] * self._columns[window[1]]).astype(np.float32)
        return rows[:, None] + columns[None, :]

    def _window(self, corner: NDArray, edges: NDArray) -> tuple[slice, slice] | None:
        """Rows and columns that the rectangle can cover, or None when it is out of sight."""
        points = corner + np.array([np.zeros(3), edges[0], edges[1], edges[0] + edges[1]])
        depths = points[:, 2]
        if depths.min() < _CLOSE:
            return slice(0, self._shape[0]), slice(0, self._shape[1])
        pixels = points[:, :2] / depths[:, None] @ self._k[:2, :2] + self._k[:2, 2]
        low = np.maximum(np.floor(pixels.min(axis=0)), 0).astype(int)
        high = np.minimum(np.ceil(pixels.max(axis=0)) + 1, self._shape[::-1]).astype(int)
        if np.any(low >= high):
            return None
        return slice(low[1], high[1]), slice(low[0], high[0])

    def visible(self) -> Iterator[tuple[int, NDArray[np.int64]]]:
        """Rectangles that are seen, each with the flat indices of its pixels."""
        owner = self.owner.ravel()
        for number in np.flatnonzero(np.bincount(owner + 1)[1:]).tolist():
            yield number, np.flatnonzero(owner == number)

    def texels(self, panel: Panel, pixels: NDArray[np.int64]) -> NDArray[np.int32] | int:
        """Rows of the texture of a rectangle that its pixels show."""
        texture = panel.texture
        if texture is None:
            return 0
        assert panel.uv is not None
        depth = 1.0 / self.inverse.ravel()[pixels]
        s, t = self._s.ravel()[pixels] * depth, self._t.ravel()[pixels] * depth
        (u0, v0), (us, vs), (ut, vt) = panel.uv.astype(np.float32)
        density = texture.size * np.linalg.norm(panel.uv[1]) / np.linalg.norm(panel.edges[0])  # [texels/m]
        per_depth = np.float32(1.4 * density / -self._k[0, 0])
        return texture.indices(u0 + us * s + ut * t, v0 + vs * s + vt * t, depth * per_depth)


def _light_on(panel: Panel, lighting: Lighting) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Colour (3,) of the rectangle in the key light, and in its shadow."""
    normal, tint = panel.normal, np.array(panel.color)
    shaded = lighting.ambient + sum(float(fill.on(normal)) * np.array(fill.color) for fill in lighting.fills)
    key = float(lighting.key.on(normal)) * np.array(lighting.key.color)
    ambient_color = np.array(lighting.key.color) * 0.5 + 0.5
    shaded = shaded * ambient_color
    return (tint * (shaded + key)).astype(np.float32), (tint * shaded).astype(np.float32)


def _packed(colors: NDArray) -> NDArray[np.uint32]:
    """Colours (n, 3) in 0..1 as rgba bytes in one number."""
    rgba = np.full((len(colors), 4), 255, dtype=np.uint8)
    rgba[:, :3] = np.minimum(colors * 255.0 + 0.5, 255.0)
    return rgba.view(np.uint32).ravel()
