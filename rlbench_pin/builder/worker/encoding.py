"""Records of the builder as plain data for messages between processes: arrays, numbers, text, lists and maps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.viewer.recording import Frame

RecordT = TypeVar("RecordT")


def encode(value: object) -> Any:
    """Return a value as plain data; records become maps, the poses of a frame one array.

    Characters that UTF-8 does not have, as a task may print them, become `?`.
    """
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode()
    if isinstance(value, BodySpec):
        return value.model_dump()
    if isinstance(value, Mapping):
        return {encode(str(key)): encode(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [encode(item) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        sent = {field.name: getattr(value, field.name) for field in fields(value)}
        if isinstance(value, Frame):
            sent |= {"links": list(value.poses), "poses": np.array(list(value.poses.values()), dtype=float).reshape(-1, 7)}
        return {name: encode(item) for name, item in sent.items()}
    return str(value) if isinstance(value, Path) else value


def decode(kind: type[RecordT], sent: object) -> RecordT:
    """Return the record of a kind that `encode` made plain.

    Raises:
        ValueError: It is not the result of `encode` for such a record.
    """
    made: RecordT = _value(kind, sent)
    return made


def _value(kind: Any, sent: Any) -> Any:
    """Return plain data as a value of an annotated type."""
    origin, inner = get_origin(kind), get_args(kind)
    if kind is BodySpec:
        return BodySpec(**sent)
    if isinstance(kind, type) and is_dataclass(kind):
        if kind is Frame:
            sent = {**sent, "poses": dict(zip(sent["links"], sent["poses"], strict=True))}
            del sent["links"]
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
    kind = origin or kind
    if kind is np.ndarray:
        return np.asarray(sent, dtype=float)
    if kind in (float, int, bool, str, Path):
        return kind(sent)
    return sent


@lru_cache(maxsize=64)
def _hints(kind: type) -> dict[str, Any]:
    return get_type_hints(kind)
