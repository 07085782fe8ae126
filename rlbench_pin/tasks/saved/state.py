"""What a task remembers: which attributes are saved with the world, how, and which are refused."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from functools import partial
from pathlib import PurePath
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Any, Protocol, runtime_checkable

import numpy as np

from rlbench_pin.errors import TaskError
from rlbench_pin.scene.spec import Spec

PLAIN = (type(None), bool, int, float, complex, str, bytes, range, slice, np.generic, Enum, PurePath, Spec, type)
"""Immutable values: kept as they are."""
FUNCTIONS = (FunctionType, MethodType, BuiltinFunctionType, partial)
"""Hooks and the like: kept as they are."""
SIMULATION = "rlbench_pin.sim."
"""Where the classes are of what the world hands out: bodies, joints, frames, regions, sensors, the arm, the hand. These are
kept as they are, since the world saves what they stand for. Their name is enough: to list tasks, no simulator is loaded."""


@runtime_checkable
class Stateful(Protocol):
    """An object that changes during an episode and says how: conditions, `SpawnBoundary`, classes of a task file."""

    def state(self) -> object:
        """Return what is remembered, as a value that later changes do not touch."""
        ...

    def set_state(self, state: Any) -> None:
        """Remember `state`, which `state()` returned before."""
        ...


@dataclass(frozen=True, eq=False)
class Memory:
    """One value and what it held at one instant."""

    value: Any
    """The object itself; other references to it see the old contents when they come back."""
    contents: Any = None
    """Memories of the items, a copy of an array, the state of a `Stateful`; None for what cannot change."""


class _Refused(Exception):
    """A value cannot be saved; carries where it is below its attribute, and the value."""


def remember(task: str, attributes: Mapping[str, Any]) -> dict[str, Memory]:
    """Remember the attributes of a task.

    Args:
        task: Name of the task, for the message.
        attributes: Name -> value.

    Raises:
        TaskError: An attribute is or holds something that cannot be saved; names task, attribute and type.
    """
    memories = {}
    for name, value in attributes.items():
        try:
            memories[name] = _remember(value, "")
        except _Refused as refused:
            where, found = refused.args
            raise TaskError(
                f"Task '{task}' keeps a {type(found).__name__} in self.{name}{where}, which cannot be saved with the world. "
                "Use numbers, strings, arrays, lists, dicts, sets, conditions and what the world hands out, "
                "or a class of your own with the methods state() and set_state(state)."
            ) from None
    return memories


def recall(memory: Memory) -> Any:
    """Give a value its old contents back and return it."""
    value, contents = memory.value, memory.contents
    if contents is None:
        return value
    if isinstance(value, np.ndarray):
        value[...] = contents
    elif isinstance(value, Stateful):
        value.set_state(contents.value)
    else:
        _refill(value, [recall(item) for item in contents])
    return value


def _refill(container: Any, items: list[Any]) -> None:
    """Put items back into a list, dict or set; tuples and frozen records have kept theirs."""
    if isinstance(container, list):
        container[:] = items
    elif isinstance(container, dict | set):
        container.clear()
        container.update(items)


def _remember(value: Any, where: str) -> Memory:
    if isinstance(value, (*PLAIN, *FUNCTIONS)) or is_handle(value):
        return Memory(value)
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        return Memory(value, value.copy() if value.flags.writeable else None)
    if isinstance(value, Stateful):
        return Memory(value, Memory(value.state()))
    if isinstance(value, list | tuple):
        return Memory(value, [_remember(item, f"{where}[{i}]") for i, item in enumerate(value)])
    if isinstance(value, dict):
        return Memory(value, [_remember_pair(pair, f"{where}[{pair[0]!r}]") for pair in value.items()])
    if isinstance(value, set | frozenset):
        return Memory(value, [_remember(item, f"{where}{{}}") for item in value])
    if is_dataclass(value) and value.__dataclass_params__.frozen:  # type: ignore[union-attr]
        return Memory(value, [_remember(getattr(value, f.name), f"{where}.{f.name}") for f in fields(value)])
    raise _Refused(where, value)


def is_handle(value: Any) -> bool:
    """Whether the world hands the value out."""
    return any(kind.__module__.startswith(SIMULATION) for kind in type(value).__mro__)


def _remember_pair(pair: tuple[Any, Any], where: str) -> Memory:
    return Memory(pair, [_remember(part, where) for part in pair])
