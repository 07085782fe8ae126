"""The arm is an even veil: as light everywhere, with a darker outline, fainter before bodies, and gone close to the camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.checking.overlay import with_veil
from rlbench_pin.sim import Images

SIDE = 96
ARM, FINGER, BODY = 1, 2, 61


def image(depth: float = 0.8) -> NDArray[np.int64]:
    """Veil over a grey room with a body on the right, behind an arm of stripes that is so far away [m]."""
    room, far = np.full((SIDE, SIDE, 3), 120, np.uint8), np.ones((SIDE, SIDE), np.float32)
    mask = np.zeros((SIDE, SIDE), np.int32)
    mask[:, 60:] = BODY
    bare = Images(room, far, mask)
    rgb, near, own = room.copy(), far.copy(), mask.copy()
    rgb[20:76, 20:76], near[20:76, 20:76], own[20:76, 20:76] = 255, depth, ARM
    rgb[20:76:8, 20:76] = 0
    return with_veil(bare, Images(rgb, near, own), [ARM, FINGER], [FINGER], [BODY]).astype(int)


def test_the_veil_is_even_and_light() -> None:
    """Stripes of the arm are not seen, its outline is; the veil is fainter before a body."""
    seen = image()
    before_room, before_body = seen[30:66, 28:52, 0], seen[30:66, 66:70, 0]
    assert np.ptp(before_room) <= 1
    assert 120 < before_body.mean() < before_room.mean() < 205
    assert seen[48, 18:23, 0].min() < 120
    assert (seen[:12] == 120).all()


def test_what_is_close_to_the_camera_is_not_shown() -> None:
    """An arm just before the camera hides nothing."""
    assert np.abs(image(0.1) - 120).max() == 0
