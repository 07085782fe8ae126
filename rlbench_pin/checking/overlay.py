"""The arm as an even, light veil with a thin outline over an image without it, so that what is behind it stays visible."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from rlbench_pin.sim import Images

_GREY, _LINE = np.array([205.0, 208.0, 214.0], np.float32), np.array([92.0, 96.0, 106.0], np.float32)
"""Colours of the veil and of its outline."""
_OVER_ROOM, _OVER_BODIES, _FINGERS = 0.42, 0.3, 0.65
"""Opacity of the veil before the room and before bodies of the task, and of the fingers, which keep their own colours."""
_OUTLINE, _SEAM = 0.55, 0.22
"""Opacity of the outline, and of the lines between links."""
_NEAR = (0.25, 0.6)
"""The arm fades from the second to the first of these distances from the camera, as multiples of that of the task."""
_STEP = 0.03
"""Difference of depth between two pixels of the arm that has an outline [m]."""
_SHORT = 0.001
"""Lines with a smaller share of all pixels are left out, as cracks between parts of a link."""
_HOLE = 25
"""Gaps in the arm that are narrower are closed [px]."""
_BLUR = 1.2
"""Softness of edges and lines [px]."""


def with_veil(
    bare: Images, whole: Images, arm: Collection[int], fingers: Collection[int], bodies: Collection[int]
) -> NDArray[np.uint8]:
    """Return an image uint8 (h, w, 3) with the arm as a veil.

    Args:
        bare: Colours, depth and mask without the arm.
        whole: The same with the arm.
        arm: Mask ids of the arm with its fingers.
        fingers: Mask ids of the fingers.
        bodies: Mask ids of the bodies of the task.
    """
    assert bare.rgb is not None and bare.depth is not None and bare.mask is not None
    assert whole.rgb is not None and whole.depth is not None and whole.mask is not None
    is_arm, is_finger, is_body = (
        np.isin(mask, list(ids)) for mask, ids in ((whole.mask, arm), (whole.mask, fingers), (bare.mask, bodies))
    )
    if not is_arm.any():
        return bare.rgb
    distance = float(np.median(bare.depth[is_body] if is_body.any() else bare.depth))
    nearness = np.clip((whole.depth / distance - _NEAR[0]) / (_NEAR[1] - _NEAR[0]), 0.0, 1.0)
    shown = np.where(is_arm, nearness * nearness * (3.0 - 2.0 * nearness), 0.0).astype(np.float32)
    shown = np.where(_without_holes(is_arm), ndimage.grey_closing(shown, _HOLE), shown)
    opacity = _soft(np.where(is_finger, _FINGERS, np.where(is_body, _OVER_BODIES, _OVER_ROOM)) * shown)[..., None]
    own = _soft(is_finger)[..., None]
    image = bare.rgb * (1.0 - opacity) + (_GREY * (1.0 - own) + whole.rgb * own) * opacity
    steps, seams = _edges(is_arm, whole.depth, whole.mask)
    line = np.maximum(_drawn(steps) * _OUTLINE, _drawn(seams) * _SEAM) * ndimage.grey_dilation(shown, 5)
    image += (_LINE - image) * line[..., None]
    return np.round(image).clip(0, 255).astype(np.uint8)


def _without_holes(is_arm: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the arm (h, w) without cracks and small holes."""
    closed = ndimage.binary_closing(is_arm, iterations=4)
    holes, _ = ndimage.label(~closed)
    return closed | (np.bincount(holes.ravel()) < _HOLE**2)[holes]


def _edges(
    is_arm: NDArray[np.bool_], depth: NDArray[np.float32], mask: NDArray[np.int32]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the pixels (h, w) at the outline of the arm and where its depth steps, and those between links."""
    steps, seams = np.zeros_like(is_arm), np.zeros_like(is_arm)
    for axis in (0, 1):
        before, after = (tuple(part if n == axis else slice(None) for n in (0, 1)) for part in (slice(None, -1), slice(1, None)))
        both = is_arm[before] & is_arm[after]
        steps[after] |= (is_arm[before] != is_arm[after]) | (both & (np.abs(depth[before] - depth[after]) > _STEP))
        seams[after] |= both & (mask[before] != mask[after])
    return steps, seams


def _drawn(line: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return how dark each pixel (h, w) of a line is, 0..1, without its short parts."""
    wide = ndimage.binary_dilation(line, iterations=2)
    parts, _ = ndimage.label(wide)
    is_long = np.bincount(parts.ravel()) > _SHORT * line.size
    is_long[0] = False
    return np.minimum(1.4 * _soft(ndimage.binary_dilation(line & is_long[parts])), 1.0)


def _soft(values: NDArray) -> NDArray[np.float32]:
    return ndimage.gaussian_filter(values.astype(np.float32), _BLUR)
