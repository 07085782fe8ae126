"""Series of one value per frame in HDF5: arrays are stacked, other values are JSON. Nothing is pickled or rounded.

A series is a list with one value per frame; None means that the frame has no value. Each series is one HDF5 dataset. Its
attribute `kind` is the encoding:

* `array`: arrays of one shape and type, stacked along the first axis;
* `arrays`: lists of such arrays, all of one length, stacked along the first two axes;
* `float`: python floats, as float64;
* `json`: all other values, one JSON text per frame.

A dataset with the attribute `constant` has one value for all frames; `frames` lists the frames that have a value.

Images are stored in chunks of a few frames, which this module shuffles and deflates before HDF5 stores them. Deflate finds
repetitions within 32 kB. A chunk has as many rows of each frame as fit into 32 kB, so that the static parts of images of a
stationary camera take almost no space. Any HDF5 reader can decode them: the filters are shuffle, gzip and Fletcher-32.

Every chunk ends with its Fletcher-32 checksum. HDF5 checks it when it reads the chunk, so that a flipped bit is an error.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import h5py
import numpy as np
from isal import isal_zlib
from numpy.typing import NDArray

FRAMES = 4
"""Frames of a chunk."""
_REACH = 24576
"""Bytes of one frame in one plane of a chunk, well within deflate's window."""
_LEVEL = 2
_MIN_BYTES = 4096
"""Smaller frames are no images [bytes]."""


def are_images(values: Sequence[object]) -> bool:
    """Whether values are large arrays of two or more dimensions, one per frame, all of one shape and type."""
    first = values[0]
    return isinstance(first, np.ndarray) and first.ndim >= 2 and first.nbytes >= _MIN_BYTES


def write_images(group: h5py.Group, name: str, frames: Sequence[NDArray]) -> h5py.Dataset:
    """Store images of one shape and type, stacked along the first axis."""
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
        fletcher32=True,
    )
    block = np.zeros(chunk, dtype=first.dtype)
    for start in range(0, len(frames), chunk[0]):
        for top in range(0, first.shape[0], chunk[1]):
            data = _filled(block, frames[start : start + chunk[0]], top)
            offset = (start, top, *(0 for _ in first.shape[1:]))
            packed = isal_zlib.compress(_shuffled(data), _LEVEL)
            dataset.id.write_direct_chunk(offset, packed + _fletcher32(packed))
    return dataset


def _chunk(shape: tuple[int, ...], frames: int) -> tuple[int, ...]:
    """Return the shape of a chunk: some frames, each with as many rows as fit into the window of deflate."""
    height, row = shape[0], int(np.prod(shape[1:]))
    parts = -(-height * row // _REACH)
    return (min(FRAMES, frames), max(1, -(-height // parts)), *shape[1:])


def _filled(block: NDArray, frames: Sequence[NDArray], top: int) -> NDArray:
    """Return the block with the rows from `top` on of some frames, padded with zeros."""
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


def _fletcher32(data: bytes) -> bytes:
    """Return the checksum that HDF5's filter appends to these bytes.

    The sum of all 16-bit words and the sum of all partial sums, modulo 65535, where only zeros give 0: J. G. Fletcher, "An
    Arithmetic Checksum for Serial Transmissions", IEEE Transactions on Communications 30(1), 1982.
    """
    words = np.frombuffer(data + bytes(len(data) % 2), dtype=">u2").astype(np.uint64)
    sums = int(words.sum()), int(words @ np.arange(len(words), 0, -1, dtype=np.uint64))
    first, second = ((total - 1) % 65535 + 1 if total else 0 for total in sums)
    return (second << 16 | first).to_bytes(4, "little")


Value = Any
"""Values of `Observation.misc`: arrays, numbers, texts, and lists and dicts of them."""

_ARRAY, _TUPLE, _PAIRS, _SCALAR = "__array__", "__tuple__", "__pairs__", "__scalar__"
_EXACT = (str, int, bool, type(None))
_SMALL = 256
_WIDEST = 1 << 20
"""Bytes of the longest text in an array."""


def write_series(group: h5py.Group, name: str, values: Sequence[Value], compression: str) -> None:
    """Store one value per frame under `name`; do nothing if every value is None."""
    frames = [i for i, v in enumerate(values) if v is not None]
    if not frames:
        return
    present = [values[i] for i in frames]
    kind = _kind(present)
    if kind == "array" and len(present) > 1 and are_images(present):
        constant = _are_equal(present)
        dataset = _create_images(group, name, present[:1] if constant else present, compression)
    else:
        data = _pack(kind, present)
        constant = kind != "float" and len(present) > 1 and _are_equal(data)
        dataset = _create(group, name, data[:1] if constant else data, compression)
    dataset.attrs["kind"] = kind
    if constant:
        dataset.attrs["constant"] = True
    if len(frames) != len(values):
        group.create_dataset(f"{name}@frames", data=np.array(frames, dtype=np.int64))


def read_series(stored: h5py.Dataset, beside: h5py.Dataset | None, length: int, wanted: range | None = None) -> list[Value]:
    """Read the values that `write_series` stored; None for a frame without a value.

    Args:
        stored: The dataset.
        beside: The dataset `<name>@frames`, or None.
        length: Number of frames of the episode.
        wanted: The frames to read, consecutive ones; None reads all. Only these are read from the file.
    """
    attributes = dict(stored.attrs)
    frames = range(length) if beside is None else _frames(beside[()], length)
    constant = bool(attributes.get("constant", False))
    if len(stored) != (1 if constant else len(frames)):
        raise ValueError(f"'{stored.name}' has {len(stored)} values for {len(frames)} frames")
    wanted = range(length) if wanted is None else wanted
    rows = wanted if beside is None else [row for row, frame in enumerate(frames) if frame in wanted]
    result: list[Value] = [None] * len(wanted)
    if not rows:
        return result
    data = np.repeat(stored[()], len(rows), axis=0) if constant else stored[rows[0] : rows[-1] + 1]
    for row, value in zip(rows, _unpack(attributes["kind"], data), strict=True):
        result[frames[row] - wanted.start] = value
    return result


def _frames(stored: np.ndarray, length: int) -> list[int]:
    """Return the frames that have a value.

    Raises:
        ValueError: They are not ascending frame numbers of the episode.
    """
    ends = np.concatenate([[-1], np.atleast_1d(stored), [length]])
    if stored.ndim != 1 or stored.dtype.kind != "i" or not (np.diff(ends) > 0).all():
        raise ValueError(f"values belong to frames that an episode of {length} frames does not have")
    frames: list[int] = stored.tolist()
    return frames


def to_json(value: Value) -> str:
    """Return a value as JSON without loss of arrays, tuples, numpy scalars and keys of dicts that are not texts."""
    return json.dumps(_plain(value))


def from_json(text: str | bytes) -> Value:
    """Return the value of a text from `to_json`.

    Raises:
        ValueError: It is not JSON, or is nested too deeply.
    """
    try:
        return json.loads(text, object_hook=_restore)
    except RecursionError as error:
        raise ValueError("a text is nested too deeply") from error


def _kind(values: Sequence[Value]) -> str:
    first = values[0]
    if all(type(v) is float for v in values):
        return "float"
    if _stackable(values):
        return "array"
    if isinstance(first, list) and first and all(isinstance(v, list) and len(v) == len(first) for v in values):
        flat = [item for v in values for item in v]
        return "arrays" if _stackable(flat) else "json"
    return "json"


def _stackable(values: Sequence[Value]) -> bool:
    """Whether all are arrays of one shape and one plain type."""
    first = values[0]
    if not isinstance(first, np.ndarray) or first.dtype.kind not in "biuf":
        return False
    return all(isinstance(v, np.ndarray) and v.shape == first.shape and v.dtype == first.dtype for v in values)


def _pack(kind: str, values: Sequence[Value]) -> np.ndarray:
    if kind == "json":
        return np.array(_texts(values), dtype=object)
    if kind == "arrays":
        return np.stack([np.stack(v) for v in values])
    return np.array(values, dtype=np.float64) if kind == "float" else np.stack(values)


def _texts(values: Sequence[Value]) -> list[str]:
    """Return values as JSON; repeated values share one text."""
    texts = [to_json(values[0])]
    for last, value in zip(values, values[1:]):
        texts.append(texts[-1] if _is_same(last, value) else to_json(value))
    return texts


def _is_same(a: Value, b: Value) -> bool:
    """Whether two values certainly have the same JSON: equal texts, whole numbers and None, and lists and dicts of these."""
    if type(a) is not type(b):
        return False
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(_is_same, a, b))
    if isinstance(a, dict):
        return len(a) == len(b) and all(map(_is_same, a, b)) and all(map(_is_same, a.values(), b.values()))
    return type(a) in _EXACT and bool(a == b)


def _unpack(kind: str, data: np.ndarray) -> list[Value]:
    if kind == "json":
        return [from_json(text) for text in data]
    if kind == "arrays":
        return [[item.copy() for item in row] for row in data]
    if kind == "array":
        return [np.array(row) for row in data]
    if kind == "float":
        return [float(v) for v in data]
    raise ValueError(f"unknown kind of series '{kind}'")


def _are_equal(rows: Sequence[Value] | np.ndarray) -> bool:
    """Whether all texts or arrays are bit-equal (so that NaN equals NaN and -0.0 differs from 0.0)."""
    if isinstance(rows[0], str):
        return all(text == rows[0] for text in rows)
    first = rows[0].tobytes()
    return all(row.tobytes() == first for row in rows[1:])


def _create(group: h5py.Group, name: str, data: np.ndarray, compression: str) -> h5py.Dataset:
    """Create a dataset; a large one is shuffled and compressed as one chunk that ends with its checksum."""
    if data.dtype == object:
        return group.create_dataset(name, data=data, dtype=h5py.string_dtype("utf-8"))
    if data.nbytes < _SMALL or data.size == 0:
        return group.create_dataset(name, data=data)
    return group.create_dataset(name, data=data, chunks=data.shape, compression=compression, shuffle=True, fletcher32=True)


def _create_images(group: h5py.Group, name: str, frames: Sequence[np.ndarray], compression: str) -> h5py.Dataset:
    """Create a dataset of images in chunks of some frames."""
    if compression == "gzip":
        return write_images(group, name, frames)
    data, chunk = np.stack(frames), (1, *frames[0].shape)
    return group.create_dataset(name, data=data, chunks=chunk, compression=compression, shuffle=True, fletcher32=True)


def _plain(value: Value) -> Value:
    """Replace values that JSON cannot express by marked dicts."""
    if isinstance(value, np.ndarray):
        return {_ARRAY: value.tolist(), "dtype": str(value.dtype), "shape": list(value.shape)}
    if isinstance(value, np.generic):
        return {_SCALAR: value.item(), "dtype": str(value.dtype)}
    if isinstance(value, tuple):
        return {_TUPLE: [_plain(v) for v in value]}
    if isinstance(value, list):
        return [_plain(v) for v in value]
    if isinstance(value, dict):
        if all(isinstance(k, str) and not k.startswith("__") for k in value):
            return {k: _plain(v) for k, v in value.items()}
        return {_PAIRS: [[_plain(k), _plain(v)] for k, v in value.items()]}
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"a {type(value).__name__} cannot be stored; use arrays, numbers, texts, lists and dicts")


def _restore(marked: dict[str, Value]) -> Value:
    if _ARRAY in marked:
        return np.array(marked[_ARRAY], dtype=_plain_type(marked["dtype"])).reshape(marked["shape"])
    if _SCALAR in marked:
        return _plain_type(marked["dtype"]).type(marked[_SCALAR])
    if _TUPLE in marked:
        return tuple(marked[_TUPLE])
    if _PAIRS in marked:
        return dict(marked[_PAIRS])
    return marked


def _plain_type(name: str) -> np.dtype:
    found = np.dtype(name)
    if found.kind not in "biufcSUOmM" or found.itemsize > _WIDEST:
        raise ValueError(f"a value is of type {name!r}")
    return found
