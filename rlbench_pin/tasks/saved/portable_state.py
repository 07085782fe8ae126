"""What a task remembers, in a form that another process can take over.

Objects cannot travel: functions, conditions, bodies. Of each it is told where it is in the task and what it held; the task that
takes the state over has begun the same episode, and so has the same objects in the same places. What the world hands out travels
by name.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from rlbench_pin.errors import TaskError
from rlbench_pin.tasks.saved.state import FUNCTIONS, PLAIN, Memory, Stateful, is_handle

if TYPE_CHECKING:
    from rlbench_pin.sim import World

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
    """What a task remembers, as plain data."""

    task: str
    """Name of the task."""
    attributes: dict[str, PortableMemory]


@dataclass(frozen=True)
class TaskState:
    """What a task remembers at one instant; valid for the task object it came from. Pickled, it is a `PortableTaskState`."""

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
    """Return the value that a memory stands for.

    Args:
        memory: As from `portable`.
        own: What lies in its place in this task; None where nothing does. It is changed where it can be.
        world: Has the things by name.
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
    """Return what the world hands out under a name; the arm, the hand and the world itself have none."""
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
