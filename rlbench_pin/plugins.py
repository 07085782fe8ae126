"""Tasks that other packages bring, by their entry points: read when names are asked for, once per process, without an import.

A package says in its `pyproject.toml` what its tasks are called and where their classes are:

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
"""The group of entry points in which a package names its tasks."""
_NAME = re.compile(r"[a-z][a-z0-9_]*")
_VALUE = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


@dataclass(frozen=True)
class PluginTask:
    """One task that an installed package names."""

    name: str
    """Name of the task."""
    value: str
    """Reference of its class: `module:Class`."""
    origin: str
    """The package that brings it, with its version."""

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
    """Name of a task, or of a package -> why it was left out."""


def installed_plugins(library: Collection[str]) -> Plugins:
    """Return the tasks of installed packages, and what was left out: wrong entries, and names that two sides claim.

    Args:
        library: Names of the tasks of the library; they stay what they are.
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
                f"The task '{name}' of {' and '.join(origins)} is refused: rlbench_pin itself has a task of that name. "
                "Give the other one another name."
            )
        elif len(claimants) > 1:
            found.faults[name] = (
                f"The task name '{name}' is claimed by {' and by '.join(origins)}, so neither is used. Uninstall one of them."
            )
        else:
            found.tasks[name] = claimants[0]
    return found


@lru_cache(maxsize=1)
def _all_entries() -> tuple[tuple[PluginTask, ...], dict[str, str]]:
    """Return the sound entries of all packages in the order of the path, and the faults of others."""
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
            faults[package] = f"The entry points of '{origin}' cannot be read: {error}. Install it again."
    return tuple(tasks), faults


def _entries(distribution: Distribution) -> Iterator[EntryPoint]:
    return (entry for entry in distribution.entry_points if entry.group == GROUP)


def _origin(distribution: Distribution) -> tuple[str, str]:
    """Return the normalized name of a package, and its name with the version."""
    name = distribution.metadata["Name"] or "a package without a name"
    return re.sub(r"[-_.]+", "-", name).lower(), f"{name} {distribution.version}"


def _fault(entry: EntryPoint, origin: str) -> str:
    if _NAME.fullmatch(entry.name) is None:
        return f"'{origin}' calls a task '{entry.name}'. Use small letters, digits and underscores."
    if _VALUE.fullmatch(entry.value.strip()) is None:
        return f"'{origin}' says that the task '{entry.name}' is '{entry.value}'. Write `module:Class` there."
    return ""


__all__ = ["GROUP", "PluginTask", "Plugins", "installed_plugins"]
