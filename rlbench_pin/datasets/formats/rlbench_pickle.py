"""Safe reader and writer of the pickled files of RLBench-style folders, without the package that defines their classes.

Only this module reads pickles from files, and only for that foreign format. The reader has a table of allowed names. It refuses
any other name before code runs. The writer stores the class paths of that package as text, without an import, and the names of
numpy's functions in the form that all versions of numpy accept.
"""

from __future__ import annotations

import codecs
import io
import pickle
import pickletools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rlbench_pin.errors import EpisodeFileError

_PROTOCOL = 2
_NOTES = ("PUT", "BINPUT", "LONG_BINPUT")
"""Operations that keep a value under a number, to be used again."""


class PickledDemo:
    """Replaces a demonstration of such a file; its attributes are those in the file."""


class PickledObservation:
    """Replaces an observation of such a file; its attributes are those in the file."""


_CLASS_PATHS = {
    PickledDemo: ("rlbench.demo", "Demo"),
    PickledObservation: ("rlbench.backend.observation", "Observation"),
}
_WRITTEN_AS = {(cls.__module__, cls.__name__): path for cls, path in _CLASS_PATHS.items()} | {
    ("numpy._core.multiarray", "_reconstruct"): ("numpy.core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"): ("numpy.core.multiarray", "scalar"),
}


def dump(value: object) -> bytes:
    """Pickle plain values, numpy arrays and the two replacement classes."""
    data = pickle.dumps(value, protocol=_PROTOCOL)
    parts, end = [], 0
    for opcode, argument, position in pickletools.genops(data):
        if opcode.name == "GLOBAL" and position is not None:
            module, name = str(argument).split(" ", 1)
            parts += [data[end:position], "c{}\n{}\n".format(*_WRITTEN_AS.get((module, name), (module, name))).encode()]
            end = position + len(f"c{module}\n{name}\n".encode())
    return b"".join([*parts, data[end:]])


def load(path: Path) -> Any:
    """Read a file that is not trusted.

    Raises:
        EpisodeFileError: It is missing or damaged, or has content other than demonstrations, observations and arrays.
    """
    try:
        data = Path(path).read_bytes()
        _check_numbers(data)
        return _plain(_Reader(io.BytesIO(data)).load(), {})
    except FileNotFoundError as error:
        raise EpisodeFileError(path, f"'{path}' does not exist. Check the path.") from error
    except _Refused as error:
        raise EpisodeFileError(path, f"'{path}' asks for {error}, which demonstrations do not need. Do not trust it.") from error
    except Exception as error:  # damaged pickles raise nearly everything
        problem = f"'{path}' is truncated or damaged ({type(error).__name__}: {error})"
        raise EpisodeFileError(path, f"{problem}. Restore it.") from error


def _check_numbers(data: bytes) -> None:
    """Refuse a memo number that is too large for the size of the file: the library would allocate all numbers below it."""
    for opcode, argument, _ in pickletools.genops(data):
        if opcode.name in _NOTES and isinstance(argument, int) and argument > len(data):
            raise _Refused(f"room for {argument} notes")


class _Refused(Exception):
    """A file asks for something that is not in the table."""


class _ArrayType:
    """Replaces `numpy.ndarray`, which a file may name but not call."""


class _Dtype:
    """A type of numbers or texts. Unlike numpy's own, it does not let a file declare that bytes are objects."""

    def __init__(self, code: str, align: object = False, copy: object = False) -> None:
        found = np.dtype(code)
        if found.kind not in "biufcSUO":
            raise _Refused(f"an array of type {code!r}")
        self.value = found

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        if state[1] in ("<", ">"):
            self.value = self.value.newbyteorder(state[1])


class _Array:
    """An array that is being read; `_plain` replaces it by the finished one."""

    value: np.ndarray

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        _, shape, dtype, fortran, data = state
        self.value = _array(data, dtype, shape, "F" if fortran else "C")


def _array(data: Any, dtype: Any, shape: Any, order: str) -> np.ndarray:
    if not isinstance(dtype, _Dtype):
        raise _Refused(f"an array of type {dtype!r}")
    if dtype.value.kind == "O":
        if not isinstance(data, list):
            raise _Refused("an array of objects made from bytes")
        flat = np.empty(len(data), dtype=object)
        flat[:] = data
    else:
        if not isinstance(data, str | bytes | bytearray):
            raise _Refused(f"an array made from a {type(data).__name__}")
        raw = data.encode("latin1") if isinstance(data, str) else bytes(data)
        flat = np.frombuffer(raw, dtype=dtype.value).copy()
    return flat.reshape(shape, order="F" if order == "F" else "C")


def _reconstruct(kind: object, shape: object, code: object) -> _Array:
    if kind is not _ArrayType:
        raise _Refused(f"an array of class {kind!r}")
    return _Array()


def _scalar(dtype: Any, data: Any = b"") -> Any:
    return _array(data, dtype, (1,), "C")[0]


def _plain(value: Any, seen: dict[int, tuple[Any, Any]]) -> Any:
    """Replace unfinished arrays by finished ones, in containers and replacement classes of any depth.

    Args:
        value: The value that was read.
        seen: Identity -> the value, which stays alive by that, and its replacement. Each value is visited once, because a few
            bytes can describe a tree of tuples with too many leaves to visit.
    """
    if isinstance(value, _Array):
        return value.value
    if id(value) in seen:
        return seen[id(value)][1]
    if isinstance(value, tuple):
        seen[id(value)] = value, tuple(_plain(v, seen) for v in value)
        return seen[id(value)][1]
    if isinstance(value, list | dict | PickledDemo | PickledObservation):
        seen[id(value)] = value, value
    if isinstance(value, list):
        value[:] = [_plain(v, seen) for v in value]
    elif isinstance(value, dict):
        value.update({k: _plain(v, seen) for k, v in value.items()})
    elif isinstance(value, PickledDemo | PickledObservation):
        _plain(value.__dict__, seen)
    return value


def _encode(text: str, encoding: str = "latin1") -> bytes:
    if encoding.lower().replace("-", "") not in ("latin1", "utf8", "ascii"):
        raise _Refused(f"the encoding {encoding!r}")
    return codecs.encode(text, encoding)


def _no_bytes() -> bytes:
    """Return the empty bytes, which protocols 0 to 2 write as a call."""
    return b""


def _new_object(cls: type, base: type, state: object) -> object:
    if cls not in _CLASS_PATHS or base is not object or state is not None:
        raise _Refused(f"an object of {cls!r}")
    return cls()


_ALLOWED: Mapping[tuple[str, str], Callable[..., Any]] = {
    ("rlbench.demo", "Demo"): PickledDemo,
    ("rlbench.backend.observation", "Observation"): PickledObservation,
    ("rlbench_pin.observation", "Demo"): PickledDemo,  # a program's own `pickle.dump` of a live demonstration
    ("rlbench_pin.observation", "Observation"): PickledObservation,
    **{(f"numpy.{core}.multiarray", "_reconstruct"): _reconstruct for core in ("core", "_core")},
    **{(f"numpy.{core}.multiarray", "scalar"): _scalar for core in ("core", "_core")},
    **{(f"numpy.{core}.numeric", "_frombuffer"): _array for core in ("core", "_core")},
    ("numpy", "ndarray"): _ArrayType,
    ("numpy", "dtype"): _Dtype,
    ("_codecs", "encode"): _encode,
    **{(module, "bytes"): _no_bytes for module in ("builtins", "__builtin__")},
    **{(module, "_reconstructor"): _new_object for module in ("copyreg", "copy_reg")},
    **{(module, "object"): object for module in ("builtins", "__builtin__")},
}


class _Reader(pickle.Unpickler):
    """Resolves only the names in the table."""

    def find_class(self, module: str, name: str) -> Callable[..., Any]:
        if (module, name) not in _ALLOWED:
            raise _Refused(f"'{module}.{name}'")
        return _ALLOWED[(module, name)]

    def persistent_load(self, key: object) -> object:
        """Refuse references to objects outside the file."""
        raise _Refused(f"the outside object {key!r}")
