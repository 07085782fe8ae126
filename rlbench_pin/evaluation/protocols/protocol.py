"""A protocol: the checked content of its TOML file, and the errors of protocols. This module needs no simulator."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from rlbench_pin.errors import (
    EvaluationError,
    InvalidValue,
    RlbenchPinError,
    TaskEnvironmentError,
    UnknownName,
    nearest_name,
)
from rlbench_pin.observation import CAMERAS
from rlbench_pin.tasks import usable_task_names
from rlbench_pin.values import (
    LARGEST_COUNT,
    as_choice,
    as_flag,
    as_image_size,
    as_names,
    as_number,
    as_record,
    as_several,
    as_text,
    as_whole,
    items_of,
)

SPLITS = ("train", "validation", "test")
"""Splits of a protocol: training demonstrations, validation demonstrations, and the episodes of the evaluation."""
TASK, VARIATION = "task", "variation"
PROTOCOLS_COMMAND = "rlbench-pin list --protocols"
LARGEST_SPLIT_SEED = 2**48
"""Largest seed of a split."""
MOST_EPISODES = 100_000
"""Maximum number of episodes of a split, for one task or variation and one seed."""
_FOLDER = Path(__file__).parent


class ProtocolError(EvaluationError):
    """A protocol cannot be used."""


class ProtocolFileError(ProtocolError):
    """A file is missing, or its content is not a protocol; `path` is the file."""

    def __init__(self, path: Path | str, problem: str) -> None:
        self.path, self.problem = Path(path), problem
        super().__init__(f"'{path}' is not a protocol that can be used: {problem}. docs/protocols.md describes every key.")


class ProtocolTasksMissing(ProtocolError, TaskEnvironmentError):
    """A protocol names tasks that are not installed.

    Attributes:
        missing: Names of the tasks.
        complete: Parts of the protocol whose tasks all exist, such as `gembench:L1`.
    """

    def __init__(self, protocol: str, missing: Sequence[str], complete: Sequence[str], known: Collection[str]) -> None:
        self.protocol, self.missing, self.complete = protocol, tuple(missing), tuple(complete)
        near = [nearest_name(name, known) for name in self.missing]
        names = ", ".join(f"{name} (did you mean {other}?)" if other else name for name, other in zip(self.missing, near))
        parts = f"Use a complete part: {', '.join(self.complete)}." if self.complete else "`rlbench-pin list` lists the tasks."
        super().__init__(f"The protocol '{protocol}' names tasks that are not installed: {names}. {parts}")


class ProtocolConflict(ProtocolError, TaskEnvironmentError):
    """A setting contradicts the protocol.

    Attributes:
        setting: Name of the setting.
        value: Its value.
        wanted: The value of the protocol.
    """

    def __init__(self, protocol: str, setting: str, value: object, wanted: object, advice: str = "") -> None:
        self.protocol, self.setting, self.value, self.wanted = protocol, setting, value, wanted
        advice = advice or "Leave it out, or use your own protocol file."
        super().__init__(
            f"{_words(setting, value)} contradicts the protocol '{protocol}', which has {_words(setting, wanted)}. {advice}"
        )


def _words(setting: str, value: object) -> str:
    """Return a setting with its value; a flag of a command is in the form of the command line."""
    if isinstance(value, bool) and setting.startswith("--"):
        return f"`{setting}`" if value else f"`--no-{setting[2:]}`"
    values = " ".join(map(str, value)) if isinstance(value, tuple | list) else str(value)
    return f"`{setting} {values if len(values) <= 120 else values[:120] + '...'}`"


@dataclass(frozen=True)
class ProtocolTask:
    """A task of a protocol.

    Raises:
        InvalidValue: A name or a variation cannot be used.
    """

    name: str
    """Task name."""
    variations: tuple[int, ...]
    """Its variations in the protocol; a number n means the first n variations."""
    title: str = ""
    """Name in the published tables; the task name when empty."""
    part: str = ""
    """Part of the protocol, such as a level; empty for a protocol without parts."""

    def __post_init__(self) -> None:
        name = _name(self.name, "The name of a task")
        given: object = self.variations
        found = items_of(given) if not isinstance(given, int) or isinstance(given, bool) else tuple(range(_count(given, name)))
        numbers = tuple(as_whole(v, f"A variation of '{name}'", least=0, most=LARGEST_COUNT) for v in found)
        if not numbers or len(set(numbers)) < len(numbers):
            raise InvalidValue(f"variations of '{name}'", given, "have to be a number, or a list of different numbers")
        object.__setattr__(self, "variations", numbers)
        object.__setattr__(self, "title", as_text(self.title, f"title of '{name}'") or name)
        if ":" in as_text(self.part, f"part of '{name}'"):
            raise InvalidValue(f"part of '{name}'", self.part, "has to be a word without a colon")


def _count(value: object, name: str) -> int:
    return as_whole(value, f"variations of '{name}'", least=1, most=MOST_EPISODES)


@dataclass(frozen=True)
class Split:
    """Episodes of a split.

    Raises:
        InvalidValue: A number cannot be used.
    """

    episodes: int
    """Episodes of each task, or of each variation, for each seed."""
    seeds: tuple[int, ...] = (0,)
    """Seeds of recordings, or of evaluations in the split `test`; with several seeds, all episodes are repeated with each."""
    part: str = ""
    """Part of the protocol with the tasks of the split; all parts when empty."""

    def __post_init__(self) -> None:
        as_whole(self.episodes, "episodes of a split", least=1, most=MOST_EPISODES)
        seeds = tuple(as_whole(s, "A seed of a split", least=0, most=LARGEST_SPLIT_SEED) for s in as_several(self.seeds, "seeds"))
        if not seeds or len(set(seeds)) < len(seeds):
            raise InvalidValue("seeds of a split", seeds, "have to be different numbers, at least one")
        object.__setattr__(self, "seeds", seeds)
        as_text(self.part, "part of a split")


@dataclass(frozen=True)
class Protocol:
    """A protocol: tasks with variations, episodes of the splits, cameras, action modes and limits.

    Raises:
        InvalidValue: A value cannot be used.
        UnknownName: A camera, a split or a part is unknown; proposes the nearest name.
    """

    name: str
    version: int
    """Version; it increases with every change of the content."""
    cameras: tuple[str, ...]
    """Cameras that a policy may use."""
    image_size: tuple[int, int]
    """Width and height of the images [px]."""
    arm: str
    """Arm action mode of policies, the name of a class such as `EndEffectorPoseViaPlanning`."""
    gripper: str
    """Gripper action mode of policies, the name of a class such as `Discrete`."""
    max_steps: int
    """Maximum number of actions of an episode."""
    max_seconds: float
    """Maximum simulated time of an episode [s]."""
    episodes_of: str
    """`task`: episodes are counted for a task and spread over its variations; `variation`: for each variation."""
    tasks: tuple[ProtocolTask, ...]
    """Tasks, in the order of the published tables."""
    splits: Mapping[str, Split]
    """Name of a split -> split: `test`, and optionally `train` and `validation`."""
    about: str = ""
    """Description, one sentence."""
    source: str = ""
    """Publication of the protocol."""
    robot: str = "panda"
    """Name of the arm."""
    tell_task: bool = False
    """Whether policies get the name of the task in addition to the instruction."""
    factors: tuple[str, ...] = ()
    """Settings of factors, such as `friction:colosseum`, with which the test episodes are repeated."""
    initial_states: Mapping[str, str] = field(default_factory=dict)
    """Task -> SHA-256 of the initial states of its test episodes, from `scripts/write_protocol_states.py`."""
    part: str = ""
    """The selected part; the whole protocol when empty."""

    def __post_init__(self) -> None:
        tasks = tuple(as_record(task, ProtocolTask, "A task") for task in as_several(self.tasks, "tasks"))
        checked: dict[str, Any] = {
            "name": _name(self.name, "name"),
            "version": as_whole(self.version, "version", least=1, most=LARGEST_COUNT),
            "cameras": tuple(as_choice(name, "camera", CAMERAS) for name in as_names(self.cameras, "cameras")),
            "image_size": as_image_size(self.image_size, "image_size"),
            "arm": _name(self.arm, "arm"),
            "gripper": _name(self.gripper, "gripper"),
            "max_steps": as_whole(self.max_steps, "max_steps", least=1, most=LARGEST_COUNT),
            "max_seconds": as_number(self.max_seconds, "max_seconds", above=0.0),
            "episodes_of": as_choice(self.episodes_of, "unit of episodes", (TASK, VARIATION)),
            "tasks": tasks,
            "splits": {name: split for name in SPLITS if (split := _table(self.splits, "splits").get(name)) is not None},
            "about": as_text(self.about, "about"),
            "source": as_text(self.source, "source"),
            "robot": _name(self.robot, "robot"),
            "tell_task": as_flag(self.tell_task, "tell_task"),
            "factors": tuple(as_names(self.factors, "factors")),
            "initial_states": {k: as_text(v, "initial_states") for k, v in _table(self.initial_states, "initial_states").items()},
            "part": as_text(self.part, "part"),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        for name in _table(self.splits, "splits"):
            as_record(self.split(name), Split, f"splits.{name}")
        self._check_tasks()

    def _check_tasks(self) -> None:
        if not self.tasks:
            raise InvalidValue("tasks", self.tasks, "name no task", "Add at least one task.")
        places = [(task.name, variation) for task in self.tasks for variation in task.variations]
        if twice := [place for place in places if places.count(place) > 1] if len(set(places)) < len(places) else []:
            raise InvalidValue("tasks", twice[0], "name this variation of a task twice", "Remove one of them.")
        for part in (self.part, *(split.part for split in self.splits.values())):
            if part:
                as_choice(part, f"part of the protocol '{self.name}'", self.parts)
        test = self.split("test")
        if test.part:
            raise InvalidValue("splits.test.part", test.part, "cannot be set", "Select a part with `--protocol NAME:PART`.")
        starts = sorted(test.seeds)
        if any(after - before < test.episodes for before, after in zip(starts, starts[1:])):
            hint = f"Episode i of seed s has evaluation seed s + i: choose seeds at least {test.episodes} apart."
            raise InvalidValue("splits.test.seeds", test.seeds, "give the same episodes twice", hint)

    @property
    def label(self) -> str:
        """Name, and the selected part after a colon if there is one."""
        return f"{self.name}:{self.part}" if self.part else self.name

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the parts, in order; empty without parts."""
        return tuple(dict.fromkeys(task.part for task in self.tasks if task.part))

    @property
    def selected(self) -> tuple[ProtocolTask, ...]:
        """Tasks of the selected part, in order."""
        return tuple(task for task in self.tasks if self.part in ("", task.part))

    @property
    def task_names(self) -> tuple[str, ...]:
        """Names of the tasks of the selected part, each once, in order."""
        return tuple(dict.fromkeys(task.name for task in self.selected))

    @property
    def episodes(self) -> int:
        """Number of test episodes of the selected part."""
        test = self.split("test")
        return (
            test.episodes
            * len(test.seeds)
            * sum(len(t.variations) if self.episodes_of == VARIATION else 1 for t in self.selected)
        )

    def of_part(self, part: str) -> Protocol:
        """Return the protocol with one of its parts selected.

        Raises:
            UnknownName: The protocol has no such part.
        """
        return replace(self, part=part)

    def split(self, name: str) -> Split:
        """Return a split.

        Raises:
            UnknownName: The protocol has no such split.
        """
        return self.splits[as_choice(name, f"split of the protocol '{self.name}'", tuple(self.splits))]

    def for_split(self, name: str) -> Protocol:
        """Return the protocol with the part of a split selected.

        Raises:
            UnknownName: The protocol has no such split.
            ProtocolConflict: Another part is selected.
        """
        part = self.split(name).part
        if part and self.part not in ("", part):
            advice = f"Use `--protocol {self.name}:{part}`."
            raise ProtocolConflict(self.name, f"part of the split {name}:", self.part, part, advice)
        return self.of_part(part or self.part)

    def check_tasks_exist(self) -> None:
        """Raise ProtocolTasksMissing if a task of the selected part is not installed."""
        known = set(usable_task_names())
        if missing := [name for name in self.task_names if name not in known]:
            parts = [self.of_part(part) for part in self.parts]
            complete = [part.label for part in parts if known.issuperset(part.task_names)]
            raise ProtocolTasksMissing(self.label, missing, complete, () if self.name in protocol_names() else known)

    def check_agrees(self, given: Mapping[str, object], fixed: Mapping[str, object], tasks: str = "--tasks") -> None:
        """Raise ProtocolConflict if a setting differs from its value in the protocol; the error names the flag.

        Args:
            given: Setting -> value.
            fixed: Setting -> value of the protocol.
            tasks: Name of the argument for tasks, for the error.
        """
        for setting, wanted in fixed.items():
            if given[setting] != wanted:
                flag = tasks if setting == "tasks" else f"--{setting.replace('_', '-')}"
                raise ProtocolConflict(self.label, flag, given[setting], wanted)

    def content(self) -> dict[str, Any]:
        """Return the whole protocol as plain data, in the form of its file."""
        plain = {name: getattr(self, name) for name in _KEYS if name not in ("tasks", "splits")}
        plain["cameras"], plain["image_size"] = list(self.cameras), list(self.image_size)
        plain["factors"] = list(self.factors)
        if not self.factors:  # protocols without factors keep their SHA-256
            del plain["factors"]
        plain["initial_states"] = dict(self.initial_states)
        plain["splits"] = {name: {**vars(split), "seeds": list(split.seeds)} for name, split in self.splits.items()}
        plain["tasks"] = [{**vars(task), "variations": _short_variations(task.variations)} for task in self.tasks]
        return plain

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the content of the whole protocol; comments and the order of keys do not count."""
        text = json.dumps(self.content(), sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()

    def record(self) -> dict[str, Any]:
        """Return the data for a results file: name, part, version, SHA-256 and content."""
        return {
            "name": self.name,
            "part": self.part,
            "version": self.version,
            "sha256": self.sha256,
            "content": self.content(),
        }

    @classmethod
    def from_record(cls, record: object) -> Protocol:
        """Return the protocol of a results file.

        Raises:
            InvalidValue, UnknownName: The data are not from `record`, or were changed.
        """
        table = _entries(record, ("name", "part", "version", "sha256", "content"), "protocol")
        protocol = replace(protocol_of(table.get("content")), part=as_text(table.get("part"), "protocol.part"))
        for name, value in protocol.record().items():
            if name != "content" and table.get(name) != value:
                raise InvalidValue(f"protocol.{name}", table.get(name), f"contradicts its content, which has {value!r}")
        return protocol


_KEYS = tuple(f.name for f in fields(Protocol) if f.name != "part")


def _short_variations(variations: tuple[int, ...]) -> int | list[int]:
    return len(variations) if variations == tuple(range(len(variations))) else list(variations)


def _name(value: object, what: str) -> str:
    text = as_text(value, what)
    if not text or not text.isprintable() or len(text) > 200:
        raise InvalidValue(what, value, "has to be a name")
    return text


def _table(value: object, what: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
        raise InvalidValue(what, value, "has to be a table")
    return value


def _entries(value: object, known: Sequence[str], what: str, needed: Sequence[str] = ()) -> dict[str, Any]:
    """Return a table, after a check that it has only known keys and all needed keys."""
    table = dict(_table(value, what))
    for name in table:
        as_choice(name, f"key of {what}", known)
    if missing := [name for name in needed if name not in table]:
        raise InvalidValue(what, list(table), f"lacks {', '.join(missing)}", "Add the missing keys.")
    return table


def protocol_of(content: object) -> Protocol:
    """Return the protocol of plain data, from a TOML file or from `Protocol.content`.

    Raises:
        InvalidValue, UnknownName: A key is missing or unknown, or a value cannot be used.
    """
    needed = (
        "name", "version", "cameras", "image_size", "arm", "gripper", "max_steps", "max_seconds", "episodes_of", "tasks",
        "splits",
    )  # fmt: skip
    table = _entries(content, _KEYS, "a protocol", needed)
    tasks = [
        ProtocolTask(**_entries(task, ("name", "variations", "title", "part"), "a task", ("name", "variations")))
        for task in as_several(table.pop("tasks"), "tasks")
    ]
    splits = {
        name: Split(**_entries(split, ("episodes", "seeds", "part"), f"splits.{name}", ("episodes",)))
        for name, split in _entries(table.pop("splits"), SPLITS, "splits", ("test",)).items()
    }
    return Protocol(tasks=tuple(tasks), splits=splits, **table)


def protocol_names() -> tuple[str, ...]:
    """Return the names of the published protocols."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def load_protocol(name: str) -> Protocol:
    """Return a protocol.

    Args:
        name: `peract18`, `gembench`, `gembench:L1`, or the path of a TOML file, optionally with `:PART`.

    Raises:
        UnknownName: No protocol has this name, or it has no such part; proposes the nearest name.
        ProtocolFileError: The file is missing, or is not a protocol.
    """
    text = as_text(name, "protocol")
    whole, part = (text, "") if text.endswith(".toml") or ":" not in text else text.rsplit(":", 1)
    if whole.endswith(".toml") or "/" in whole:
        return _read(Path(whole)).of_part(part)
    if whole not in protocol_names():
        raise UnknownName("protocol", whole, protocol_names(), PROTOCOLS_COMMAND)
    return _read(_FOLDER / f"{whole}.toml").of_part(part)


def _read(path: Path) -> Protocol:
    try:
        return protocol_of(tomllib.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError as error:
        raise ProtocolFileError(path, "there is no such file") from error
    except (OSError, ValueError, RlbenchPinError) as error:
        raise ProtocolFileError(path, str(error).rstrip(".")) from error
