"""Masks over three channels become ids again, whatever numbers carry them."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment import rgb_handles_to_mask
from rlbench_pin.environment.observations.observe import spread_mask
from rlbench_pin.errors import CameraError

IDS = np.array([[0, 1, 61, 255], [256, 300, 65535, 2**24 - 1]], dtype=np.int32)
BYTES = np.stack([IDS & 255, IDS >> 8 & 255, IDS >> 16], axis=-1)


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.int64])
def test_whole_numbers_are_bytes(kind: type) -> None:
    """Lowest byte first; small types do not overflow, and the image stays as it was."""
    rgb = BYTES.astype(kind)
    before = rgb.copy()
    mask = rgb_handles_to_mask(rgb)
    assert np.array_equal(mask, IDS)
    assert mask.dtype == np.int32
    assert np.array_equal(rgb, before)


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64])
def test_floats_are_parts_of_one(kind: type) -> None:
    """Each of the 256 values comes back exactly."""
    assert np.array_equal(rgb_handles_to_mask((BYTES / 255.0).astype(kind)), IDS)
    every = np.arange(256, dtype=np.int32)
    assert np.array_equal(rgb_handles_to_mask(np.stack([every / kind(255)] * 3, axis=-1).astype(kind)), every * 65793)


def test_it_undoes_what_observations_do() -> None:
    """Masks with `masks_as_one_channel=False`, one, several or as lists."""
    assert np.array_equal(rgb_handles_to_mask(spread_mask(IDS)), IDS)
    assert np.array_equal(rgb_handles_to_mask(np.stack([spread_mask(IDS)] * 2)), np.stack([IDS] * 2))
    assert rgb_handles_to_mask([61, 1, 0]) == 317


@pytest.mark.parametrize(
    ("rgb", "words"),
    [
        (np.zeros((4, 4)), "shape"),
        (np.float64(0.5), "shape"),
        (np.zeros((4, 3), dtype=bool), "of bool"),
        (np.full((4, 4, 3), 61.0), r"float64 lie in 0\.\.1"),
        (np.full((4, 4, 3), np.nan), r"lie in 0\.\.1"),
        (np.full((4, 4, 3), 256), r"int64 lie in 0\.\.255"),
        (np.full((4, 4, 3), -1), r"lie in 0\.\.255"),
    ],
)
def test_what_is_no_mask_is_refused(rgb: np.ndarray, words: str) -> None:
    """A shape without three channels, and numbers that are neither bytes nor parts of one."""
    with pytest.raises(CameraError, match=words):
        rgb_handles_to_mask(rgb)
