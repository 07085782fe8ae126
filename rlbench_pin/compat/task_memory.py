"""Save and restore the attributes of the objects of a user's task file, with the state of the episode.

Such a task may have any attributes: views, lists, records, conditions. Views have no state of their own, since the
world has it; all other values are saved with their contents.
"""

from __future__ import annotations

import random
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import numpy as np

from rlbench_pin.tasks.saved.portable_state import FUNCTIONS, PLAIN

Recall = Callable[[], Any]
"""Restores the contents of a value, and returns it."""
AS_THEY_ARE = ("pyrep.", "rlbench_pin.", "rlbench.")
"""Modules of classes whose objects are not saved: they have no state of an episode, or the world and the task save it."""
OPENED = ("rlbench.backend.conditions.", "rlbench.backend.spawn_boundary.", "rlbench.backend.waypoints.")
"""Modules among them whose objects are saved like those of a user."""
VIEWS, ROBOTS = ("pyrep.objects.",), ("pyrep.robots.",)
"""Modules of views (saved: whether their object was removed), and modules of robots (not saved)."""


def keep(value: Any, seen: dict[int, Any] | None = None) -> Recall:
    """Save a value with its contents.

    Args:
        value: Any value.
        seen: Objects that are being saved already, by id, for circular references.

    Returns:
        A function that restores the contents; the value itself stays the same object.
    """
    seen = {} if seen is None else seen
    is_view = _is_of(value, VIEWS) and not _is_of(value, ROBOTS)
    stays = _is_of(value, AS_THEY_ARE) and not _is_of(value, OPENED) and not is_view
    if isinstance(value, (*PLAIN, *FUNCTIONS)) or id(value) in seen or stays:
        return lambda: value
    seen[id(value)] = value
    if is_view:
        attributes = dict(vars(value))
        return _keep_by(value, attributes, vars(value).update)
    if isinstance(value, np.ndarray):
        return _keep_array(value)
    if isinstance(value, np.random.Generator):
        return _keep_by(value, value.bit_generator.state, lambda state: _set_bits(value, state))
    if isinstance(value, np.random.RandomState):
        return _keep_by(value, value.get_state(), value.set_state)
    if isinstance(value, random.Random):
        return _keep_by(value, value.getstate(), value.setstate)
    if isinstance(value, list | tuple | set | frozenset | deque | dict):
        return _keep_container(value, seen)
    if hasattr(value, "__dict__") and not _is_foreign(value):
        contents = _keep_container(vars(value), seen)
        return _keep_by(value, None, lambda _: contents())
    return lambda: value


def _is_of(value: Any, modules: tuple[str, ...]) -> bool:
    """Return whether the class of a value, or one of its bases, is from one of the modules (prefixes with a final dot)."""
    return any(f"{kind.__module__}.".startswith(modules) for kind in type(value).__mro__)


def _is_foreign(value: Any) -> bool:
    """Return whether the class of a value is from the standard library or numpy: a module, a logger, a lock."""
    package = type(value).__module__.partition(".")[0]
    return (package in sys.stdlib_module_names or package == "numpy") and not isinstance(value, SimpleNamespace)


def _set_bits(generator: np.random.Generator, state: Any) -> None:
    generator.bit_generator.state = state


def _keep_by(value: Any, state: Any, give_back: Callable[[Any], object]) -> Recall:
    """Return a function that calls `give_back(state)` and returns the value."""

    def recall() -> Any:
        give_back(state)
        return value

    return recall


def _keep_array(value: np.ndarray) -> Recall:
    """Save the numbers of an array; a read-only array is not restored."""
    copy = value.copy()

    def recall() -> Any:
        if value.flags.writeable:
            value[...] = copy
        return value

    return recall


def _keep_container(value: Any, seen: dict[int, Any]) -> Recall:
    """Save the items of a dict, list, deque, set or tuple with their contents."""
    if isinstance(value, dict):
        pairs = [(key, keep(item, seen)) for key, item in value.items()]
        return _keep_by(value, None, lambda _: _refill(value, value.update, [(key, item()) for key, item in pairs]))
    items = [keep(item, seen) for item in value]
    if isinstance(value, list | deque):
        return _keep_by(value, None, lambda _: _refill(value, value.extend, [item() for item in items]))
    if isinstance(value, set):
        return _keep_by(value, None, lambda _: _refill(value, value.update, [item() for item in items]))
    return _keep_by(value, None, lambda _: [item() for item in items])


def _refill(container: Any, fill: Callable[[Iterable[Any]], object], items: list[Any]) -> None:
    """Replace the items of a container; `fill` adds items to it."""
    container.clear()
    fill(items)


class SavedAttributes:
    """Saves and restores the attributes of one object, with the interface of the state of native tasks.

    Args:
        owner: The object.
        without: Names of attributes that are not saved.
    """

    def __init__(self, owner: object, without: Iterable[str] = ()) -> None:
        self.owner, self._without = owner, frozenset(without)

    def state(self) -> dict[str, Recall]:
        """Return the current values of the attributes, as functions that restore them."""
        seen: dict[int, Any] = {id(self.owner): self.owner}
        return {name: keep(value, seen) for name, value in vars(self.owner).items() if name not in self._without}

    def set_state(self, state: dict[str, Recall]) -> None:
        """Restore the values that `state()` returned."""
        attributes = vars(self.owner)
        for name in [name for name in attributes if name not in self._without and name not in state]:
            del attributes[name]
        for name, recall in state.items():
            attributes[name] = recall()


class GlobalDraws:
    """A separate state of the global random generators of numpy and Python, for a task.

    Task files in the style of RLBench draw from `np.random`. With this class their draws depend on the seed of the episode
    only, and the draws of other code do not change.
    """

    def __init__(self) -> None:
        self._lent = False
        self.seed(0)

    def seed(self, seed: int) -> None:
        """Set the state from a seed, 0 to 2**32 - 1."""
        self._state = (np.random.RandomState(seed).get_state(), random.Random(seed).getstate())

    @contextmanager
    def lent(self) -> Iterator[None]:
        """Use the state of the task in the global generators within a `with` block; nested blocks have no effect."""
        if self._lent:
            yield
            return
        before = _global_state()
        self._lent = True
        _set_global_state(self._state)
        try:
            yield
        finally:
            self._state = _global_state()
            self._lent = False
            _set_global_state(before)

    def state(self) -> object:
        """Return the state of the generators of the task."""
        return self._state

    def set_state(self, state: Any) -> None:
        """Restore the state that `state()` returned."""
        self._state = state


def _global_state() -> tuple[Any, Any]:
    return np.random.get_state(), random.getstate()  # noqa: NPY002


def _set_global_state(state: tuple[Any, Any]) -> None:
    np.random.set_state(state[0])  # noqa: NPY002
    random.setstate(state[1])
