"""Backdrop: table, floor, walls and ceiling as rectangles, drawn analytically.

Over the pixels (u, v) of one rectangle, 1/z, s/z and t/z are affine functions, where z is the depth and s, t are the coordinates
along its edges. So a rectangle costs a few additions and comparisons per pixel, and its depth is exact. The view of a stationary
camera is drawn once and cached.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView, pixel_rays
from rlbench_pin.sim.render.lighting import Lighting
from rlbench_pin.sim.render.texture import Texture
from rlbench_pin.sim.render.tone import toned

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

    @cached_property
    def normal(self) -> NDArray[np.float64]:
        """Unit normal (3,) of the visible side."""
        n = np.cross(self.edges[0], self.edges[1])
        return n / np.linalg.norm(n)


@dataclass(frozen=True, eq=False)
class VisiblePanel:
    """Candidate pixels of one rectangle, and the affine forms of 1/z, s/z and t/z for the ray of a pixel."""

    number: int
    window: tuple[slice, slice]
    """Rows and columns."""
    forms: NDArray[np.float64]
    """(3, 3): each times (x, y, 1) of a ray."""
    nearest: float
    """Greatest 1/z that its plane has in the window."""


class Canvas:
    """An image to which rectangles are added.

    Args:
        view: The camera.

    Attributes:
        view: The same.
        owner: Number of the rectangle in each pixel, -1 for none, (h, w).
        inverse: Its inverse depth (h, w) [1/m].
        only: The rectangle that fills the whole image, or None.
    """

    def __init__(self, view: CameraView) -> None:
        width, height = view.size
        self.view, self._shape = view, (height, width)
        self.columns, self.rows = pixel_rays(view)
        self.owner = np.full(self._shape, -1, dtype=np.int32)
        self.inverse, self._s, self._t = (np.zeros(self._shape, dtype=np.float32) for _ in range(3))
        self.only: VisiblePanel | None = None
        self._drawn: list[int] = []

    def draw(self, panels: Sequence[VisiblePanel]) -> None:
        """Draw rectangles, the nearest first."""
        if panels and self._hides(panels[0], panels[1:]):
            self.only = panels[0]
            self.owner[:] = self.only.number
            self.inverse = self._affine(self.only.forms[0], self.only.window)
            return
        for panel in panels:
            self._add(panel)

    def draw_alone(self, corner: NDArray[np.float64], bases: NDArray[np.float64], number: int) -> bool:
        """Draw an unoccluded rectangle that faces the camera if it fills the image; return whether it does.

        Args:
            corner: Its first corner in the frame of the camera (3,) [m].
            bases: Its normal, and vectors whose products with one of its points give s and t, (3, 3).
            number: Its number.
        """
        panel = VisiblePanel(number, (slice(None), slice(None)), _forms(corner[None], bases[None])[0], 0.0)
        if not self._hides(panel, ()):
            return False
        self.draw([panel])
        return True

    def _hides(self, panel: VisiblePanel, others: Sequence[VisiblePanel]) -> bool:
        """Whether a rectangle fills the image in front of all others; a test of the corners of the image suffices."""
        rays = np.array([[x, y, 1.0] for x in self.columns[[0, -1]] for y in self.rows[[0, -1]]])
        inverse, s, t = panel.forms @ rays.T
        beside = np.minimum(np.minimum(s, t), inverse - np.maximum(s, t)).min()
        nearest = max((other.nearest for other in others), default=0.0)
        return bool(beside > 0.0 and inverse.max() * self.view.near * _SLACK < 1.0 and inverse.min() > nearest * _SLACK)

    def _add(self, panel: VisiblePanel) -> None:
        """Draw one rectangle where it is nearer than the present content."""
        window = panel.window
        there = self.inverse[window]
        if float(there.min()) > panel.nearest * _SLACK:
            return
        inverse, s, t = (self._affine(form, window) for form in panel.forms)
        seen = (inverse > there) & (s >= 0.0) & (s <= inverse) & (t >= 0.0) & (t <= inverse)
        seen &= inverse * np.float32(self.view.near) < 1.0
        if not seen.any():
            return
        self._drawn.append(panel.number)
        np.copyto(self.owner[window], panel.number, where=seen)
        for target, value in ((self.inverse, inverse), (self._s, s), (self._t, t)):
            np.copyto(target[window], value, where=seen)

    def _affine(self, form: NDArray, window: tuple[slice, slice]) -> NDArray[np.float32]:
        rows = (form[1] * self.rows[window[0]] + form[2]).astype(np.float32)
        columns = (form[0] * self.columns[window[1]]).astype(np.float32)
        return rows[:, None] + columns[None, :]

    def visible(self) -> Iterator[tuple[int, NDArray[np.int64] | slice]]:
        """Visible rectangles, each with the flat indices of its pixels."""
        if self.only is not None:
            yield self.only.number, slice(None)
            return
        owner = self.owner.ravel()
        for number in self._drawn:
            pixels = (owner == number).nonzero()[0]
            if len(pixels):
                yield number, pixels

    def texels(self, panel: Panel, pixels: NDArray[np.int64] | slice) -> NDArray[np.int32]:
        """Rows (n,) of the texture of a rectangle for its pixels."""
        inverse = self.inverse.ravel()[pixels]
        texture = panel.texture
        if texture is None:
            return np.zeros(len(inverse), dtype=np.int32)
        assert panel.uv is not None
        depth = np.float32(1.0) / inverse
        density = texture.size * math.hypot(*panel.uv[1]) / math.hypot(*panel.edges[0])  # [texels/m]
        per_depth = np.float32(1.4 * density / -self.view.intrinsics()[0, 0])
        if self.only is not None:
            forms = panel.uv.T @ self.only.forms
            u, v = (self._affine(form, self.only.window).ravel() for form in forms)
        else:
            (u0, v0), (us, vs), (ut, vt) = panel.uv.astype(np.float32)
            s, t = self._s.ravel()[pixels], self._t.ravel()[pixels]
            u, v = us * s + ut * t + u0 * inverse, vs * s + vt * t + v0 * inverse
        u *= depth
        v *= depth
        depth *= per_depth
        return texture.indices(u, v, depth)


def visible_panels(canvas: Canvas, corners: NDArray, edges: NDArray, bases: NDArray) -> list[VisiblePanel]:
    """Return the rectangles that face a camera and are at least partly in its image, the nearest first.

    Args:
        canvas: The image.
        corners: First corner of each rectangle in the frame of the camera (m, 3) [m].
        edges: Its edges (m, 2, 3) [m].
        bases: Its normal, and vectors whose products with one of its points give s and t, (m, 3, 3).
    """
    view = canvas.view
    points = corners[:, None] + np.stack([0.0 * corners, edges[:, 0], edges[:, 1], edges[:, 0] + edges[:, 1]], axis=1)
    chosen = _visible(view, np.einsum("ij,ij->i", bases[:, 0], corners) < 0.0, points)
    corners, bases, points = corners[chosen], bases[chosen], points[chosen]
    forms = _forms(corners, bases)
    low, high = _windows(view, points)
    rows, columns = (rays[np.stack([low[:, axis], high[:, axis] - 1])] for rays, axis in ((canvas.rows, 1), (canvas.columns, 0)))
    nearest = (forms[:, 0, 1] * rows).max(axis=0) + (forms[:, 0, 0] * columns).max(axis=0) + forms[:, 0, 2]
    return [
        VisiblePanel(int(chosen[i]), (slice(low[i, 1], high[i, 1]), slice(low[i, 0], high[i, 0])), forms[i], float(nearest[i]))
        for i in np.argsort(-nearest, kind="stable").tolist()
        if (low[i] < high[i]).all()
    ]


def _forms(corners: NDArray[np.float64], bases: NDArray[np.float64]) -> NDArray[np.float64]:
    """Affine forms (m, 3, 3) of 1/z, s/z and t/z for a ray, from the first corners and the bases of rectangles."""
    along = np.einsum("ijk,ik->ij", bases, corners)
    forms = bases.copy()
    forms[:, 0] /= along[:, :1]
    forms[:, 1:] -= along[:, 1:, None] * forms[:, :1]
    return forms


def _visible(view: CameraView, facing: NDArray[np.bool_], points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Numbers of the rectangles that face the camera and are partly in its view frustum, by their corners (m, 4, 3)."""
    width, height = view.size
    slope_x, slope_y = (0.5 * (side + 2) / abs(view.intrinsics()[0, 0]) * points[..., 2] for side in (width, height))
    x, y, z = points[..., 0], points[..., 1], points[..., 2]
    outside = [x > slope_x, -x > slope_x, y > slope_y, -y > slope_y, z < view.near]
    return np.flatnonzero(facing & ~np.any([side.all(axis=1) for side in outside], axis=0))


def _windows(view: CameraView, points: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and one beyond the last column and row (m, 2) of rectangles with corners (m, 4, 3)."""
    k, depths = view.intrinsics(), points[..., 2]
    is_before = depths.min(axis=1) >= _CLOSE
    pixels = points[..., :2] / np.where(is_before[:, None], depths, 1.0)[..., None] @ k[:2, :2] + k[:2, 2]
    low = np.clip(np.floor(pixels.min(axis=1)), 0, np.array(view.size) - 1).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=1)) + 1, 0, view.size).astype(int)
    low[~is_before], high[~is_before] = 0, view.size
    return low, np.maximum(high, 1)


_LEVEL = 0.9999
"""From which z of its normal on a rectangle is level."""
_ON_WALLS = 0.65
"""By how much more of the ambient light upright sides of the room get, as from lamps along the ceiling."""
PIXEL = np.dtype("V3")
"""Three bytes that are moved as one."""
_OUTSIDE = np.array((118, 128, 138), dtype=np.uint8).view(PIXEL)[0]


class Paints:
    """Colours in the key light of all rectangles visible so far, rgb bytes of type `PIXEL`; the first is the empty background.

    Attributes:
        lit: Texels (t,).
    """

    def __init__(self) -> None:
        self.lit = np.array([_OUTSIDE], dtype=PIXEL)
        self._starts: dict[int, int] = {}

    def start(self, number: int, panel: Panel, lighting: Lighting) -> int:
        """Number of the first texel of a rectangle, which is added at the first request; one texel without a texture."""
        if number not in self._starts:
            self._starts[number] = len(self.lit)
            texels = np.ones((1, 3), dtype=np.float32) if panel.texture is None else panel.texture.texels
            self.lit = np.concatenate([self.lit, _packed(texels * _light_on(panel, lighting)[0])])
        return self._starts[number]


@dataclass(frozen=True, eq=False)
class Backdrop:
    """Image of the room from one camera; rows from the top."""

    rgb: NDArray[np.uint8]
    """Colours where the key light reaches, (h, w, 3)."""
    depth: NDArray[np.float32]
    """Depth [m], `far` where nothing is in range, (h, w)."""
    mask: NDArray[np.int32]
    """Ids, 0 where nothing is in range, (h, w)."""
    owner: NDArray[np.int32]
    """Number of the rectangle that each pixel sees, -1 for none, (h, w)."""
    table: NDArray[np.int64]
    """Flat indices of the pixels that see the table top (n,)."""


class Painter:
    """Painter of rectangles under fixed lights.

    Args:
        panels: The rectangles.
        lighting: The lights.

    Attributes:
        table_height: z of the highest horizontal rectangle, which is the table top [m].
        table_key: Share (3,) of its colour from the key light.
    """

    def __init__(self, panels: Sequence[Panel], lighting: Lighting) -> None:
        self._panels, self._lighting = tuple(panels), lighting
        self._ids = np.array([*(panel.id for panel in panels), 0], dtype=np.int32)
        self._corners, self._edges = np.array([p.corner for p in panels]), np.array([p.edges for p in panels])
        self._bases = _bases(self._edges)
        self._paints = Paints()
        heights = [panel.corner[2] if panel.normal[2] > _LEVEL else -np.inf for panel in panels]
        self._top = int(np.argmax(heights))
        self.table_height = float(heights[self._top])
        bright, shaded = _light_on(self._panels[self._top], lighting)
        self.table_key = (1.0 - shaded / np.maximum(bright, 1e-6)).astype(np.float32)

        corners = self._panels[self._top].corner + np.array([[0, 0], [1, 0], [0, 1], [1, 1]]) @ self._panels[self._top].edges
        aside = [
            p for p in panels if max(p.corner[2] + z for z in (0.0, *p.edges[:, 2], p.edges[:, 2].sum())) > self.table_height
        ]
        normals = np.array([panel.normal for panel in aside]).reshape(-1, 3)
        offsets = np.array([panel.normal @ panel.corner for panel in aside])
        sides = normals @ corners.T - offsets[:, None]
        # a camera that is on the same side of all of them as the table has none before it
        self._aside = normals, offsets, np.where(sides.min(axis=1) > 0.0, 1.0, np.where(sides.max(axis=1) < 0.0, -1.0, 0.0))

    def _is_clear(self, eye: NDArray[np.float64]) -> bool:
        """Whether no other rectangle is between a point and the table top."""
        normals, offsets, sides = self._aside
        return bool(eye[2] > self.table_height and ((normals @ eye - offsets) * sides > 0.0).all())

    def draw(self, view: CameraView) -> Backdrop:
        """Draw all rectangles from a camera."""
        canvas = Canvas(view)
        to_camera = np.linalg.inv(view.extrinsics())
        rotation, shift = to_camera[:3, :3], to_camera[:3, 3]
        corners, bases = self._corners @ rotation.T + shift, self._bases @ rotation.T
        top = self._top
        if not (self._is_clear(view.pose[:3]) and canvas.draw_alone(corners[top], bases[top], top)):
            canvas.draw(visible_panels(canvas, corners, self._edges @ rotation.T, bases))
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
        table = (
            np.arange(owner.size)
            if canvas.only is not None and canvas.only.number == self._top
            else (owner.ravel() == self._top).nonzero()[0]
        )
        return Backdrop(rgb, depth, ids, owner, table)


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
    return toned((colors * 255.0).astype(np.float32)).reshape(-1).view(PIXEL)
