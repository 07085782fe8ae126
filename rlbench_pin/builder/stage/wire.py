"""Records of the builder <-> what travels between processes: arrays, numbers, text, lists and maps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from rlbench_pin.builder.contracts import Frame
from rlbench_pin.scene.spec import BodySpec

RecordT = TypeVar("RecordT")


def plain(value: object) -> Any:
    """Return a value as arrays, numbers, text, lists and maps; records become maps, a frame a short one.

    Letters that cannot be written in UTF-8, as a task may print them, become `?`.
    """
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode()
    if isinstance(value, Frame):
        return _plain_frame(value)
    if isinstance(value, BodySpec):
        return value.model_dump()
    if isinstance(value, Mapping):
        return {plain(str(key)): plain(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    return str(value) if isinstance(value, Path) else value


def record(kind: type[RecordT], sent: object) -> RecordT:
    """Return the record of a kind that was made plain.

    Raises:
        ValueError: It is not what `plain` makes of such a record.
    """
    made: RecordT = _value(kind, sent)
    return made


def _plain_frame(frame: Frame) -> dict[str, Any]:
    """All poses in one array: a frame of a hundred links costs one array and not a hundred."""
    rest = {f.name: plain(getattr(frame, f.name)) for f in fields(frame) if f.name != "poses"}
    poses = np.array(list(frame.poses.values()), dtype=float).reshape(-1, 7)
    return {**rest, "links": list(frame.poses), "poses": poses}


def _frame(sent: Mapping[str, Any]) -> Frame:
    poses = dict(zip(sent["links"], np.asarray(sent["poses"], dtype=float).reshape(-1, 7), strict=True))
    hints = _hints(Frame)
    rest = {name: _value(hints[name], value) for name, value in sent.items() if name not in ("links", "poses")}
    return Frame(poses=poses, **rest)


def _value(kind: Any, sent: Any) -> Any:
    """Return what was sent as a value of a type, as annotations of records say it."""
    origin, inner = get_origin(kind), get_args(kind)
    if kind is Frame:
        return _frame(sent)
    if kind is BodySpec:
        return BodySpec(**sent)
    if isinstance(kind, type) and is_dataclass(kind):
        hints = _hints(kind)
        if not isinstance(sent, dict) or not set(sent) <= set(hints):
            raise ValueError(f"no {getattr(kind, '__name__', kind)}: {str(sent)[:80]}")
        return kind(**{name: _value(hints[name], value) for name, value in sent.items()})
    if origin in (Union, UnionType):
        return None if sent is None else _value(next(k for k in inner if k is not NoneType), sent)
    if origin is tuple:
        kinds = [inner[0]] * len(sent) if inner[-1] is Ellipsis else inner
        return tuple(_value(k, item) for k, item in zip(kinds, sent, strict=True))
    if origin is not None and origin is not Literal and issubclass(origin, Mapping):
        return {key: _value(inner[1], item) for key, item in sent.items()}
    return _single(origin or kind, sent)


def _single(kind: Any, sent: Any) -> Any:
    """Return a value that holds no others."""
    if kind is np.ndarray:
        return np.asarray(sent, dtype=float)
    if kind in (float, int, bool, str):
        return kind(sent)
    return Path(sent) if kind is Path else sent


@lru_cache(maxsize=64)
def _hints(kind: type) -> dict[str, Any]:
    return get_type_hints(kind)
