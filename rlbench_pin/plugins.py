"""Tasks of other packages, from their entry points, which are read once per process, without an import of the packages.

A package defines the names and the classes of its tasks in its `pyproject.toml`:

    [project.entry-points."rlbench_pin.tasks"]
    sort_two_cubes = "my_tasks.sort_two_cubes:SortTwoCubes"
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.metadata import Distribution, EntryPoint, distributions

GROUP = "rlbench_pin.tasks"
"""The group of entry points for tasks."""
_NAME = re.compile(r"[a-z][a-z0-9_]*")
_VALUE = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


@dataclass(frozen=True)
class PluginTask:
    """One task of an installed package."""

    name: str
    """Name of the task."""
    value: str
    """Reference of its class: `module:Class`."""
    origin: str
    """The package of the task, with its version."""

    def load(self) -> object:
        """Import the module and return the object of the entry point; errors of the module propagate."""
        module, _, attribute = self.value.partition(":")
        return getattr(importlib.import_module(module), attribute)


@dataclass(frozen=True)
class Plugins:
    """Tasks of the installed packages."""

    tasks: dict[str, PluginTask] = field(default_factory=dict)
    """Name -> task, in alphabetical order."""
    faults: dict[str, str] = field(default_factory=dict)
    """Name of a task or a package -> reason why it is omitted."""


def installed_plugins(library: Collection[str]) -> Plugins:
    """Return the tasks of installed packages, and the omitted ones: invalid entries, and names that occur twice.

    Args:
        library: Names of the tasks of the library; they take precedence.
    """
    entries, faults = _all_entries()
    claims: dict[str, list[PluginTask]] = {}
    found = Plugins(faults=dict(faults))
    for task in entries:
        claims.setdefault(task.name, []).append(task)
    for name, claimants in sorted(claims.items()):
        origins = [f"'{task.origin}' ({task.value})" for task in claimants]
        if name in library:
            found.faults[name] = (
                f"The task '{name}' of {' and '.join(origins)} is ignored: rlbench_pin has a task of that name. "
                "Rename the task in that package."
            )
        elif len(claimants) > 1:
            found.faults[name] = (
                f"The task name '{name}' occurs in {' and in '.join(origins)}, so these tasks are ignored. Uninstall one of them."
            )
        else:
            found.tasks[name] = claimants[0]
    return found


@lru_cache(maxsize=1)
def _all_entries() -> tuple[tuple[PluginTask, ...], dict[str, str]]:
    """Return the valid entries of all packages in the order of the path, and the faults of the others."""
    tasks: list[PluginTask] = []
    faults: dict[str, str] = {}
    seen: set[str] = set()
    for distribution in distributions():
        text = distribution.read_text("entry_points.txt")
        if text is None or GROUP not in text:
            continue
        package, origin = _origin(distribution)
        if package in seen:  # another copy, farther along the path, which Python does not import either
            continue
        seen.add(package)
        try:
            for entry in _entries(distribution):
                fault = _fault(entry, origin)
                if fault:
                    faults[entry.name] = fault
                else:
                    tasks.append(PluginTask(entry.name, entry.value, origin))
        except Exception as error:  # a file that no installer writes: the other packages go on
            faults[package] = f"The entry points of '{origin}' cannot be read: {error}. Reinstall that package."
    return tuple(tasks), faults


def _entries(distribution: Distribution) -> Iterator[EntryPoint]:
    return (entry for entry in distribution.entry_points if entry.group == GROUP)


def _origin(distribution: Distribution) -> tuple[str, str]:
    """Return the normalized name of a package, and its name with the version."""
    name = distribution.metadata["Name"] or "a package without a name"
    return re.sub(r"[-_.]+", "-", name).lower(), f"{name} {distribution.version}"


def _fault(entry: EntryPoint, origin: str) -> str:
    if _NAME.fullmatch(entry.name) is None:
        return f"'{origin}' has a task with the invalid name '{entry.name}'. Use lower-case letters, digits and underscores."
    if _VALUE.fullmatch(entry.value.strip()) is None:
        return f"'{origin}' defines the task '{entry.name}' as '{entry.value}'. Write `module:Class` instead."
    return ""


__all__ = ["GROUP", "PluginTask", "Plugins", "installed_plugins"]
