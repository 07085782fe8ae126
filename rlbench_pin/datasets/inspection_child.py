"""A program that reads all of an HDF5 file in a subprocess: a harmful file crashes or blocks it instead of its parent.

It imports nothing of this package and is started as a file. Each input line is JSON: a file and its time limit [s]. The program
answers each line with one line, also if h5py raises an error, because the parent gets the same error. Only a missing answer
counts as a failure.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
from typing import Any

import h5py

_MEMORY = 6 << 30
"""So much memory may be asked for, beside 64 times the size of the file [bytes]."""
_BLOCK = 1 << 24
"""So much of an array is read at once [bytes]."""
_MAX_INFLATION, _SMALL = 1100, 1 << 20
"""No compression makes an array smaller than by this factor; small arrays may be of any size [bytes]."""


def is_oversized(dataset: Any) -> bool:
    """Whether an array declares more bytes than its stored data can expand to."""
    return bool(dataset.nbytes > _MAX_INFLATION * dataset.id.get_storage_size() + _SMALL)


def read_all(path: str) -> None:
    """Read every attribute and every value of a file; pass on errors that h5py raises for its structure."""
    with h5py.File(path, "r") as file:
        _read_attributes(file)
        file.visititems(_read)


def _read(name: str, item: Any) -> None:
    _read_attributes(item)
    if not isinstance(item, h5py.Dataset) or item.external or item.is_virtual:
        return
    _try(_read_rows, item)


def _read_rows(dataset: Any) -> None:
    if dataset.ndim == 0 or not dataset.size:
        _try(dataset.__getitem__, ())
        return
    if is_oversized(dataset):
        return  # the reader refuses it, too
    chunk = dataset.chunks[0] if dataset.chunks else 1
    rows = max(chunk, _BLOCK * len(dataset) // max(1, dataset.nbytes))
    for first in range(0, len(dataset), rows):
        _try(dataset.__getitem__, slice(first, first + rows))


def _read_attributes(item: Any) -> None:
    for name in list(item.attrs):
        _try(item.attrs.__getitem__, name)


def _try(read: Any, *args: Any) -> None:
    """Continue after an error, because the parent reads the rest as well."""
    try:
        read(*args)
    except Exception:
        return


def main() -> None:
    """Answer every input line until the input ends."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what libraries print is not an answer
    for line in sys.stdin:
        path, seconds = json.loads(line)
        signal.alarm(seconds)  # ends this process also where it hangs and its parent is gone
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        limit = _MEMORY + 64 * os.path.getsize(path)
        resource.setrlimit(resource.RLIMIT_AS, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard))
        _try(read_all, path)
        signal.alarm(0)
        print("read", file=answers, flush=True)


if __name__ == "__main__":
    main()
