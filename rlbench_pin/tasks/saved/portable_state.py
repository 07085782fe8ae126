"""The state of a task: attributes that are saved with the world, and a form that another process can take over.

Objects such as functions, conditions and bodies cannot be sent to another process. For each of them the state has its place in
the task and its own state; the task that takes the state over has begun the same episode, and so has the same objects in the same
places. What the world hands out is sent by name.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from enum import Enum
from functools import partial
from pathlib import PurePath
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import TYPE_CHECKING, Any, Literal, Protocol, runtime_checkable

import numpy as np

from rlbench_pin.errors import TaskError
from rlbench_pin.scene.spec import Spec

if TYPE_CHECKING:
    from rlbench_pin.sim import World


PLAIN = (type(None), bool, int, float, complex, str, bytes, range, slice, np.generic, Enum, PurePath, Spec, type)
"""Immutable values: kept as they are."""
FUNCTIONS = (FunctionType, MethodType, BuiltinFunctionType, partial)
"""Hooks and the like: kept as they are."""
SIMULATION = "rlbench_pin.sim."
"""Where the classes are of what the world hands out: bodies, joints, frames, regions, sensors, the arm, the gripper. These are
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


Kind = Literal["value", "own", "thing", "array", "stateful", "items", "pairs", "record"]


@dataclass(frozen=True, eq=False)
class PortableMemory:
    """One value of a task, and what it held."""

    kind: Kind
    type_name: str
    """Name of its class, for comparison."""
    contents: Any = None
    """A value, a name, an array, a state, or memories of items."""


@dataclass(frozen=True, eq=False)
class PortableTaskState:
    """State of a task as plain data."""

    task: str
    """Name of the task."""
    attributes: dict[str, PortableMemory]


@dataclass(frozen=True)
class TaskState:
    """State of a task at one instant; valid for the task object it came from. Pickled, it is a `PortableTaskState`."""

    task: str
    attributes: dict[str, Memory]
    """Name -> the value itself and what it held."""

    def __reduce__(self) -> tuple[type[PortableTaskState], tuple[str, dict[str, PortableMemory]]]:
        return PortableTaskState, (self.task, {name: portable(memory) for name, memory in self.attributes.items()})


def portable(memory: Memory) -> PortableMemory:
    """Return a memory as plain data."""
    value, contents = memory.value, memory.contents
    name = type(value).__name__
    if isinstance(value, FUNCTIONS):
        return PortableMemory("own", name)
    if is_handle(value):
        return PortableMemory("thing", name, getattr(value, "name", None))
    if isinstance(value, np.ndarray):
        return PortableMemory("array", name, value if contents is None else contents)
    if isinstance(value, PLAIN):
        return PortableMemory("value", name, value)
    if isinstance(value, Stateful):
        return PortableMemory("stateful", name, contents.value)
    if isinstance(value, dict):
        pairs = {pair.value[0]: portable(pair.contents[1]) for pair in contents}
        return PortableMemory("pairs", name, pairs)
    kind: Kind = "record" if is_dataclass(value) else "items"
    return PortableMemory(kind, name, [portable(item) for item in contents])


def take_over(memory: PortableMemory, own: Any, world: World, where: str) -> Any:
    """Return the value of a saved one.

    Args:
        memory: As from `portable`.
        own: What lies in its place in this task; None where nothing does. It is changed where it can be.
        world: Has the objects by name.
        where: Its place, for errors.

    Raises:
        TaskError: The objects of the task are others than those that the state was taken of.
    """
    kind, contents = memory.kind, memory.contents
    if kind == "value":
        return contents
    if kind == "thing":
        return _thing(memory, own, world, where)
    if kind == "array":
        if isinstance(own, np.ndarray) and own.shape == contents.shape and own.dtype == contents.dtype and own.flags.writeable:
            own[...] = contents
            return own
        return contents.copy()
    if kind in ("own", "stateful", "record") and type(own).__name__ != memory.type_name:
        raise TaskError(
            f"The state has a {memory.type_name} in {where}, where this task has a {type(own).__name__}. It cannot be taken over "
            "from another process: hooks and conditions must follow from the episode alone. Use states of this process."
        )
    if kind == "stateful":
        own.set_state(contents)
    if kind == "pairs":
        return _pairs(contents, own, world, where)
    if kind == "record":
        return _record(contents, own, world, where)
    return _items(memory, own, world, where) if kind == "items" else own


def _thing(memory: PortableMemory, own: Any, world: World, where: str) -> Any:
    """Return what the world hands out under a name; the arm, the gripper and the world itself have none."""
    name = memory.contents
    if type(own).__name__ == memory.type_name and getattr(own, "name", None) == name:
        return own
    if memory.type_name == "Body":
        return world.body(name)
    if memory.type_name == "ObjectJoint":
        return world.joint(name)
    if name is not None:
        return world.frame(name)
    raise TaskError(f"The state has a {memory.type_name} in {where}, which this task has not. Use states of this process.")


def _items(memory: PortableMemory, own: Any, world: World, where: str) -> Any:
    """Fill a list in place; make the tuple or set anew."""
    known = list(own) if isinstance(own, list | tuple) else []
    known += [None] * (len(memory.contents) - len(known))
    values = [take_over(item, known[i], world, f"{where}[{i}]") for i, item in enumerate(memory.contents)]
    if isinstance(own, list) and memory.type_name == "list":
        own[:] = values
        return own
    makers = {"list": list, "tuple": tuple, "set": set, "frozenset": frozenset}
    if memory.type_name not in makers and isinstance(own, tuple):
        return type(own)(*values)  # a named tuple
    if isinstance(own, set) and memory.type_name == "set":
        own.clear()
        own.update(values)
        return own
    return makers[memory.type_name](values)


def _pairs(contents: Mapping[Any, PortableMemory], own: Any, world: World, where: str) -> Any:
    known = own if isinstance(own, dict) else {}
    values = {key: take_over(item, known.get(key), world, f"{where}[{key!r}]") for key, item in contents.items()}
    known.clear()
    known.update(values)
    return known


def _record(contents: list[PortableMemory], own: Any, world: World, where: str) -> Any:
    names = [field.name for field in fields(own)]
    values = {n: take_over(item, getattr(own, n), world, f"{where}.{n}") for n, item in zip(names, contents, strict=True)}
    changed = {n: value for n, value in values.items() if value is not getattr(own, n)}
    return replace(own, **changed) if changed else own
