"""Pictures as chunks of some frames each, shuffled and deflated here, so that HDF5 only has to store them.

Deflate finds what repeats within 32 kB. A chunk holds a few frames of as many rows as fit into that, so that what a camera at
rest sees again costs next to nothing. Any HDF5 reader undoes it: the filters are the standard ones, shuffle and gzip.
"""

from __future__ import annotations

from collections.abc import Sequence

import h5py
import numpy as np
from isal import isal_zlib
from numpy.typing import NDArray

FRAMES = 4
"""Frames of a chunk."""
_REACH = 24576
"""Bytes of one frame in one plane of a chunk, well within deflate's window."""
_LEVEL = 2
_LEAST = 4096
"""Smaller frames are no pictures [bytes]."""


def are_pictures(values: Sequence[object]) -> bool:
    """Whether these are large arrays of two or more dimensions, one per frame, all of one kind that can be stacked."""
    first = values[0]
    return isinstance(first, np.ndarray) and first.ndim >= 2 and first.nbytes >= _LEAST


def write_pictures(group: h5py.Group, name: str, frames: Sequence[NDArray]) -> h5py.Dataset:
    """Store pictures of one shape and type, stacked along the first axis."""
    first = frames[0]
    chunk = _chunk(first.shape, len(frames))
    dataset = group.create_dataset(
        name,
        shape=(len(frames), *first.shape),
        dtype=first.dtype,
        chunks=chunk,
        compression="gzip",
        compression_opts=_LEVEL,
        shuffle=first.itemsize > 1,
    )
    block = np.zeros(chunk, dtype=first.dtype)
    for start in range(0, len(frames), chunk[0]):
        for top in range(0, first.shape[0], chunk[1]):
            data = _filled(block, frames[start : start + chunk[0]], top)
            offset = (start, top, *(0 for _ in first.shape[1:]))
            dataset.id.write_direct_chunk(offset, isal_zlib.compress(_shuffled(data), _LEVEL))
    return dataset


def _chunk(shape: tuple[int, ...], frames: int) -> tuple[int, ...]:
    """Return the shape of a chunk: some frames of as many rows as deflate sees again in the next frame."""
    height, row = shape[0], int(np.prod(shape[1:]))
    parts = -(-height * row // _REACH)
    return (min(FRAMES, frames), max(1, -(-height // parts)), *shape[1:])


def _filled(block: NDArray, frames: Sequence[NDArray], top: int) -> NDArray:
    """Return the block with the rows from `top` on of some frames; zeros where there are none."""
    rows = min(block.shape[1], frames[0].shape[0] - top)
    if len(frames) < len(block) or rows < block.shape[1]:
        block[:] = 0
    for place, frame in zip(block, frames):
        place[:rows] = frame[top : top + rows]
    return block


def _shuffled(data: NDArray) -> bytes | NDArray[np.uint8]:
    """Return the first bytes of all numbers, then their second bytes, and so on, as HDF5's shuffle does."""
    size = data.itemsize
    values = data.view(np.uint8).reshape(-1)
    if size == 1:
        return values
    planes = np.empty((size, data.size), dtype=np.uint8)
    for number, plane in enumerate(planes):
        plane[:] = values[number::size]
    return planes.reshape(-1)
