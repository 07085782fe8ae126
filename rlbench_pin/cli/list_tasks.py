"""`rlbench-pin list`: list the tasks. Also parses the task names in the arguments of other commands."""

from __future__ import annotations

import inspect
import json
import os.path
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated

import tyro

MaybeName = Annotated[str | None, tyro.conf.arg(metavar="NAME", help_behavior_hint="")]
ALL = "all"
"""Name of all tasks on a command line."""


@dataclass(frozen=True)
class ListTasks:
    """List the tasks, each with its version and one line of description.

    Tasks of other packages come last, with the name of the package. `rlbench-pin list cup --tier 3` lists the tasks of tier 3
    with `cup` in the name or the description.
    """

    words: tyro.conf.Positional[Annotated[tuple[str, ...], tyro.conf.arg(metavar="[WORD...]", help_behavior_hint="")]] = ()
    """Only tasks whose name or description contains all these words."""
    tier: Annotated[int | None, tyro.conf.arg(metavar="1|2|3|4", help_behavior_hint="")] = None
    """Only tasks of this tier: 1 one motion, 2 one object or joint, 3 several stages, 4 long, precise or with tools."""
    set: MaybeName = None
    """Only tasks of this set."""
    family: MaybeName = None
    """Only tasks of this family, such as doors, stacking or tools."""
    sets: bool = False
    """List the sets of tasks instead; families are sets too."""
    protocols: bool = False
    """List the protocols of `evaluate --protocol` instead."""
    json: bool = False
    """Print JSON for programs."""

    def run(self) -> int:
        """Print one line per task, per set, or per protocol."""
        from rlbench_pin.tasks import task_class, task_origin, task_scene

        if self.sets:
            return self.print_sets()
        if self.protocols:
            return self.print_protocols()
        titles = {name: _title(name) for name in self._wanted()}
        titles = {
            name: title for name, title in titles.items() if all(w.lower() in f"{name} {title}".lower() for w in self.words)
        }
        if not titles and (self.words or self.tier or self.set or self.family):
            from rlbench_pin.evaluation.sets import task_sets

            sets = [name for name in task_sets() if name.lower() in map(str.lower, self.words)]
            hint = f"Use `--set {sets[0]}`." if sets else "Leave out a word or a filter."
            print(f"No task matches. {hint}", file=sys.stderr)
        versions = {name: task_scene(task_class(name)).version for name in titles}
        if self.json:
            print(json.dumps({name: {"title": title, "version": versions[name]} for name, title in titles.items()}, indent=1))
            return 0
        width = max(map(len, titles), default=0)
        for name, title in titles.items():
            origin = task_origin(name)
            print(f"{name:<{width}}  v{versions[name]}  {title}" + (f"  [{origin}]" if origin else ""))
        return 0

    def _wanted(self) -> tuple[str, ...]:
        """Return the names of the tasks of the tier, the set and the family."""
        from rlbench_pin.errors import UnknownName
        from rlbench_pin.evaluation.sets import task_families, task_set

        if self.tier not in (None, 1, 2, 3, 4):
            raise UnknownName("tier", str(self.tier), ("1", "2", "3", "4"))
        if self.family is not None and self.family not in task_families():
            raise UnknownName("family of tasks", self.family, task_families(), "rlbench-pin list --sets")
        if self.set is not None:
            task_set(self.set)
        filters = [name for name in (self.set, self.family, f"tier{self.tier}" if self.tier else None) if name]
        return tuple(name for name in usable_names() if all(name in task_set(known).tasks for known in filters))

    def print_sets(self) -> int:
        """Print one line per set; as JSON, all data of each."""
        from rlbench_pin.evaluation.sets import task_set, task_sets

        sets = [task_set(name) for name in task_sets()]
        if self.json:
            content = {s.name: {"about": s.about, "tasks": s.tasks, "parts": s.parts, "notes": s.notes} for s in sets}
            print(json.dumps(content, indent=1))
            return 0
        width = max(len(s.name) for s in sets)
        for s in sets:
            print(f"{s.name:<{width}}  {len(s.tasks):>3}  {s.about}")
        print("`FS10_V1:train` and `FS10_V1:test` are the parts of a set. `--json` names the tasks.")
        return 0

    def print_protocols(self) -> int:
        """Print one line per protocol and per part of one; as JSON, all data of each."""
        from rlbench_pin.evaluation.protocols import ProtocolTasksMissing, load_protocol, protocol_names

        whole = [load_protocol(name) for name in protocol_names()]
        if self.json:
            print(json.dumps({p.name: p.record() for p in whole}, indent=1))
            return 0
        head = "protocol version tasks variations episodes image[px] actions cameras"
        rows: list[tuple[str, ...]] = [(*head.split(), "")]
        for protocol in (each for p in whole for each in (p, *map(p.of_part, p.parts))):
            try:
                protocol.check_tasks_exist()
                remark = ""
            except ProtocolTasksMissing as error:
                remark = f"{len(error.missing)} tasks missing"
            counts = (len(protocol.task_names), sum(len(task.variations) for task in protocol.selected), protocol.episodes)
            size, cameras = "x".join(map(str, protocol.image_size)), " ".join(protocol.cameras)
            rows.append(
                (protocol.label, str(protocol.version), *map(str, counts), size, str(protocol.max_steps), cameras, remark)
            )
        widths = [max(map(len, column)) for column in zip(*rows)]
        for row in rows:
            print(
                "  ".join(cell.rjust(w) if 0 < i < 7 else cell.ljust(w) for i, (cell, w) in enumerate(zip(row, widths))).rstrip()
            )
        print("`gembench:L1` is a part of a protocol. docs/protocols.md describes what a protocol fixes.")
        return 0


def split_names(words: Iterable[str]) -> tuple[str, ...]:
    """Return the names in `words`, each once, in order; `a,b` is two names, unless there is a file of that name."""
    parts = [part.strip() for word in words for part in ([word] if os.path.isfile(word) else word.split(","))]
    return tuple(dict.fromkeys(part for part in parts if part))


def named_tasks(words: Iterable[str]) -> tuple[str, ...]:
    """Return the names in `words`, each once, in order; `all` is replaced by the names of all tasks."""
    names = (usable_names() if name == ALL else (name,) for name in split_names(words))
    return tuple(dict.fromkeys(name for some in names for name in some))


def usable_names() -> tuple[str, ...]:
    """Return the names of all tasks except those of broken packages; each broken package is reported on stderr."""
    from rlbench_pin.tasks import plugin_faults, usable_task_names

    for fault in plugin_faults().values():
        print(f"rlbench-pin: {fault}", file=sys.stderr)
    return usable_task_names()


def _title(name: str) -> str:
    """Return the first line of the docstring of a task's module."""
    from rlbench_pin.tasks import task_class

    module = inspect.getmodule(task_class(name))
    return (inspect.getdoc(module) or "").split("\n")[0]
