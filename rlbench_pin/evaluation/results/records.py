"""Results of an evaluation: one record per episode, the settings, and the JSON file with one episode per line."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, get_args

from rlbench_pin.datasets.manifest import parse_json, short
from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.errors import InvalidValue, ResultsFileError, UnknownName
from rlbench_pin.evaluation.protocols.protocol import Protocol
from rlbench_pin.values import (
    LARGEST_COUNT,
    as_choice,
    as_flag,
    as_names,
    as_number,
    as_path,
    as_record,
    as_seed,
    as_text,
    as_whole,
    one_of,
)

FORMAT = 5
"""Number of the format of results files. Format 1 has no seed key and no deaths of workers, 2 no protocol, 3 no factors,
4 no versions of tasks."""
End = Literal["success", "failed", "steps", "seconds", "fault"]
"""End of an episode: success, failure by a rule of the task, limit of steps, limit of seconds, or a fault of the policy."""
ENDS: tuple[str, ...] = get_args(End)
WORKER_DIED = "worker died"
"""The fault of an episode that was lost because its worker died."""
LONGEST_TEXT = 10_000
"""Maximum number of characters of a text in a results file."""
DEEPEST = 20
"""Maximum number of levels of lists and tables in the settings of a policy."""


@dataclass(frozen=True)
class EpisodeRecord:
    """Result of one episode. Policy, task, seed and limits determine all values; it contains no computation times."""

    task: str
    variation: int
    seed: int
    success: bool
    """Whether the goal was reached."""
    lasts: bool
    """Whether success still held after 1 s with the arm stationary."""
    steps: int
    """Number of actions, including refused actions."""
    seconds: float
    """Simulated time [s]."""
    end: End
    refused: Mapping[str, int] = field(default_factory=dict)
    """Cause -> number of actions that were refused for it."""
    collisions: int = 0
    """Number of collisions; see `Meter` for contacts that count."""
    max_force: float = 0.0
    """Largest force of these contacts [N]."""
    violations: Mapping[str, int] = field(default_factory=dict)
    """Limit of the arm -> number of control ticks in which it was violated."""
    fault: str = ""
    """Kind of the fault of the policy that ended the episode; empty without a fault."""
    fault_detail: str = ""
    """Detail of the fault."""
    worker_deaths: int = 0
    """Number of workers that died in the episode. After each death the episode was started again, unless it was lost."""
    factors: str = ""
    """Factors of generalisation and their levels, such as `light_color:2`; empty without factors."""

    def __post_init__(self) -> None:
        """Check every value, and convert it to a plain Python type."""
        what = type(self).__name__
        checked: dict[str, Any] = {
            "task": _name(self.task, f"{what}.task"),
            "variation": as_whole(self.variation, f"{what}.variation", least=0, most=LARGEST_COUNT),
            "seed": as_seed(self.seed, f"{what}.seed"),
            "success": as_flag(self.success, f"{what}.success"),
            "lasts": as_flag(self.lasts, f"{what}.lasts"),
            "steps": as_whole(self.steps, f"{what}.steps", least=0, most=LARGEST_COUNT),
            "seconds": as_number(self.seconds, f"{what}.seconds", least=0.0),
            "end": one_of(*ENDS)(self.end, f"{what}.end"),
            "refused": _counts(self.refused, f"{what}.refused"),
            "collisions": as_whole(self.collisions, f"{what}.collisions", least=0, most=LARGEST_COUNT),
            "max_force": as_number(self.max_force, f"{what}.max_force", least=0.0),
            "violations": _counts(self.violations, f"{what}.violations"),
            "fault": _text(self.fault, f"{what}.fault"),
            "fault_detail": _text(self.fault_detail, f"{what}.fault_detail"),
            "worker_deaths": as_whole(self.worker_deaths, f"{what}.worker_deaths", least=0, most=LARGEST_COUNT),
            "factors": _text(self.factors, f"{what}.factors"),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        if self.success != (self.end == "success"):
            raise InvalidValue(f"{what}.success", self.success, f"contradicts its end, '{self.end}'")
        if self.lasts and not self.success:
            raise InvalidValue(f"{what}.lasts", True, "needs a success")
        if bool(self.fault) != (self.end == "fault"):
            raise InvalidValue(f"{what}.fault", self.fault, f"contradicts its end, '{self.end}'")

    @property
    def key(self) -> tuple[str, int, int, str]:
        """Key of the episode: task, variation, seed, factors."""
        return self.task, self.variation, self.seed, self.factors


@dataclass(frozen=True)
class Results:
    """Results of an evaluation with their provenance. Equal content is byte-identical."""

    policy: str
    """Reference of the policy."""
    settings: Mapping[str, Any]
    """Settings of the policy as plain data: action mode, observations, steps."""
    task_set: str
    """Names of tasks, or sets of tasks, as the user gave them."""
    tasks: tuple[str, ...]
    """Names of the tasks, in order."""
    seeds: tuple[int, ...]
    """Seeds of the episodes, the same for each task, in order."""
    limits: Mapping[str, float | int | str | bool | None]
    """Limits of episodes, and other settings that determine them: steps, seconds, choice of variations."""
    versions: Mapping[str, str]
    """Library -> version, for this package and the libraries that affect an episode."""
    commit: str
    """Commit of the git checkout of the package; empty outside a checkout."""
    episodes: tuple[EpisodeRecord, ...]
    """Records of the episodes, in the order of tasks, and of seeds within a task."""
    policy_seed_key: str = ""
    """Key of the hash that gives the seeds of the policy; empty in files of format 1."""
    protocol: Protocol | None = None
    """Protocol of the evaluation; None without a protocol, and in files of formats 1 and 2."""
    factors: tuple[str, ...] = ()
    """Settings of factors that were played in addition to the episodes without factors, in order."""
    trained_on: str = ""
    """Factors in the training data, as the user stated them."""
    task_versions: Mapping[str, int] = field(default_factory=dict)
    """Task -> its version; empty in files of formats 1 to 4, where each is version 1."""

    def __post_init__(self) -> None:
        """Check every value, and convert it to a plain Python type."""
        checked: dict[str, Any] = {
            "policy": _name(self.policy, "Results.policy"),
            "settings": _plain_table(self.settings, "Results.settings"),
            "task_set": _name(self.task_set, "Results.task_set"),
            "tasks": tuple(_name(task, "Results.tasks") for task in as_names(self.tasks, "Results.tasks")),
            "seeds": tuple(as_seed(seed, "Results.seeds") for seed in _several(self.seeds, "Results.seeds")),
            "limits": _scalars(self.limits),
            "versions": {
                _name(k, "Results.versions"): _text(v, "Results.versions")
                for k, v in sorted(_table(self.versions, "Results.versions").items())
            },
            "commit": _text(self.commit, "Results.commit"),
            "episodes": tuple(
                as_record(e, EpisodeRecord, "Results.episodes") for e in _several(self.episodes, "Results.episodes")
            ),
            "policy_seed_key": _text(self.policy_seed_key, "Results.policy_seed_key"),
            "factors": tuple(_name(setting, "Results.factors") for setting in as_names(self.factors, "Results.factors")),
            "trained_on": _text(self.trained_on, "Results.trained_on"),
            "task_versions": {
                name: as_whole(version, f"Results.task_versions[{name!r}]", least=1, most=LARGEST_COUNT)
                for name, version in sorted(_table(self.task_versions, "Results.task_versions").items())
            },
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        if self.protocol is not None:
            as_record(self.protocol, Protocol, "Results.protocol")
        if self.task_versions and set(self.task_versions) != set(self.tasks):
            raise InvalidValue("Results.task_versions", sorted(self.task_versions), "have to be those of its tasks")
        self._check_episodes()

    def _check_episodes(self) -> None:
        tasks, seeds, met = {t: i for i, t in enumerate(self.tasks)}, set(self.seeds), set[tuple[str, int, int, str]]()
        if len(tasks) < len(self.tasks) or len(seeds) < len(self.seeds):
            raise InvalidValue("Results.tasks and seeds", (self.tasks, self.seeds), "have to be different from each other")
        place, settings = 0, {"", *self.factors}
        for episode in self.episodes:
            known = episode.task in tasks and episode.seed in seeds and episode.factors in settings
            if not known or episode.key in met or tasks[episode.task] < place:
                raise InvalidValue(
                    "Results.episodes",
                    episode.key,
                    "has to be of its tasks, seeds and factors, each once, in the order of the tasks",
                )
            met.add(episode.key)
            place = tasks[episode.task]

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the content."""
        return hashlib.sha256(canonical(self.content())).hexdigest()

    def content(self) -> dict[str, Any]:
        """Return the content of the file without the checksum as plain data, in the lowest format that can contain it."""
        format = 2 if self.policy_seed_key or any(episode.worker_deaths for episode in self.episodes) else 1
        format = format if self.protocol is None else 3
        format = 4 if self.factors else format
        format = 5 if self.task_versions else format
        head = {name: getattr(self, name) for name in HEAD[format]}
        if "protocol" in head:
            head["protocol"] = None if self.protocol is None else self.protocol.record()
        episodes = [{name: getattr(episode, name) for name in EPISODE[format]} for episode in self.episodes]
        return {"format": format, **head, "episodes": episodes}

    def of_factors(self, setting: str) -> Results:
        """Return the results of one setting of factors, in the form of results without factors.

        Args:
            setting: One of `factors`, or `""` for the episodes without factors.
        """
        as_choice(setting, "setting of factors in these results", ("", *self.factors))
        episodes = tuple(replace(episode, factors="") for episode in self.episodes if episode.factors == setting)
        played = {episode.task for episode in episodes}
        tasks = tuple(task for task in self.tasks if task in played)
        versions = {task: version for task, version in self.task_versions.items() if task in played}
        return replace(self, tasks=tasks, episodes=episodes, factors=(), task_versions=versions)

    def version_of(self, task: str) -> int:
        """Return the version of one task; 1 if the file does not contain it."""
        as_choice(task, "task of these results", self.tasks)
        return self.task_versions.get(task, 1)

    def of_task(self, task: str) -> tuple[EpisodeRecord, ...]:
        """Return the episodes of one task, in order."""
        as_choice(task, "task of these results", self.tasks)
        return tuple(episode for episode in self.episodes if episode.task == task)


_HEAD = ("policy", "settings", "task_set", "tasks", "seeds", "limits", "versions", "commit")
HEAD: Mapping[int, tuple[str, ...]] = {
    1: _HEAD,
    2: (*_HEAD, "policy_seed_key"),
    3: (*_HEAD, "policy_seed_key", "protocol"),
    4: (*_HEAD, "policy_seed_key", "protocol", "factors", "trained_on"),
    5: (*_HEAD, "policy_seed_key", "protocol", "factors", "trained_on", "task_versions"),
}
"""Format -> fields of a results file, in addition to format, episodes and checksum."""
_EPISODE = tuple(field.name for field in fields(EpisodeRecord))
EPISODE: Mapping[int, tuple[str, ...]] = {
    1: tuple(name for name in _EPISODE if name not in ("worker_deaths", "factors")),
    2: tuple(name for name in _EPISODE if name != "factors"),
    3: tuple(name for name in _EPISODE if name != "factors"),
    4: _EPISODE,
    5: _EPISODE,
}
"""Format -> fields of an episode."""


def canonical(content: object) -> bytes:
    """Return plain data as JSON; equal data give byte-identical JSON."""
    return json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def _name(value: object, what: str) -> str:
    text = _text(value, what)
    if not text:
        raise InvalidValue(what, value, "has to be a name")
    return text


def _text(value: object, what: str) -> str:
    text = as_text(value, what)
    if len(text) > LONGEST_TEXT:
        raise InvalidValue(what, text, f"has more than {LONGEST_TEXT} letters")
    return text


def _several(value: object, what: str) -> Sequence[Any]:
    if isinstance(value, str | bytes) or not isinstance(value, Sequence):
        raise InvalidValue(what, value, "has to be a list")
    return value


def _table(value: object, what: str) -> Mapping[Any, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
        raise InvalidValue(what, value, "has to be a table with names")
    return value


def _counts(value: object, what: str) -> dict[str, int]:
    table = _table(value, what)
    return {_name(name, what): as_whole(table[name], f"{what}[{name!r}]", least=0, most=LARGEST_COUNT) for name in sorted(table)}


def _scalars(value: object) -> dict[str, Any]:
    table = _table(value, "Results.limits")
    if any(isinstance(item, list | tuple | Mapping) for item in table.values()):
        raise InvalidValue("Results.limits", value, "has to contain only numbers, texts, true, false and null")
    return _plain_table(table, "Results.limits")


def _plain_table(value: object, what: str) -> dict[str, Any]:
    plain = _plain(_table(value, what), what, 0)
    assert isinstance(plain, dict)
    return plain


def _plain(value: object, what: str, depth: int) -> object:
    """Return plain data as they are after reading JSON: tables in alphabetical order, lists, finite numbers."""
    if depth > DEEPEST:
        raise InvalidValue(what, "...", f"has more than {DEEPEST} levels")
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        return _text(value, what)
    if isinstance(value, Mapping):
        table = _table(value, what)
        return {name: _plain(table[name], what, depth + 1) for name in sorted(table)}
    if isinstance(value, list | tuple):
        return [_plain(item, what, depth + 1) for item in value]
    if isinstance(value, int):
        return as_whole(value, what, least=-(2**63), most=2**64 - 1)
    if isinstance(value, float) and math.isfinite(value):
        return float(value)
    raise InvalidValue(what, value, "has to be plain data: texts, finite numbers, true, false, null, lists, tables")


# The file ---------------------------------------------------------------------------------------------------------------------

LARGEST = 256 << 20
"""Maximum size of a file that is read [bytes], enough for a million episodes."""


def results_text(results: Results) -> str:
    """Return the text of a results file."""
    content = as_record(results, Results, "results").content()
    lines = ",\n".join(json.dumps(episode, allow_nan=False) for episode in content.pop("episodes"))
    head = json.dumps({**content, "sha256": results.sha256}, indent=1, allow_nan=False)
    return f'{head[:-2]},\n "episodes": [\n{lines}\n ]\n}}\n'


def write_results(path: Path | str, results: Results) -> Path:
    """Write a results file atomically, and return its path.

    Raises:
        StorageError: The disk cannot be written to.
    """
    return write_whole(as_path(path, "path"), results_text(results).encode())


def read_results(path: Path | str) -> Results:
    """Return the results of a file.

    Raises:
        ResultsFileError: The file is missing, too large, not a results file, of another format, or was changed.
    """
    path = as_path(path, "path")
    try:
        if not path.is_file():
            raise ValueError("there is no such file")
        if (size := path.stat().st_size) > LARGEST:
            raise ValueError(f"it has {size} bytes, more than {LARGEST}")
        return _results(parse_json(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, UnknownName) as error:
        raise ResultsFileError(path, str(error).rstrip(".")) from error


def _results(content: object) -> Results:
    """Return results from plain data.

    Raises:
        ValueError: A value is missing, unknown or wrong, or the checksum differs.
    """
    if not isinstance(content, dict):
        raise ValueError("it is not a table")
    if type(found := content.get("format")) is not int or found not in HEAD:
        raise ValueError(f"it has format {short(found)}, this package reads formats 1 to {FORMAT}")
    _check_names(content, ("format", *HEAD[found], "sha256", "episodes"), "it")
    if not isinstance(content["episodes"], list):
        raise ValueError("its episodes are not a list")
    episodes = tuple(_episode(episode, EPISODE[found]) for episode in content["episodes"])
    head = {name: content[name] for name in HEAD[found]}
    if head.get("protocol") is not None or found == 3:
        head["protocol"] = Protocol.from_record(head["protocol"])
    results = Results(**head, episodes=episodes)
    if content["sha256"] != results.sha256:
        raise ValueError(f"it was changed: its content has sha256 {results.sha256}, not {short(content['sha256'])}")
    return results


def _episode(content: Any, names: tuple[str, ...]) -> EpisodeRecord:
    if not isinstance(content, dict):
        raise ValueError(f"an episode is {short(content)}, not a table")
    _check_names(content, names, "an episode")
    return EpisodeRecord(**content)


def _check_names(content: dict[str, Any], names: tuple[str, ...], what: str) -> None:
    """Raise ValueError unless a table has exactly these names."""
    if missing := [name for name in names if name not in content]:
        raise ValueError(f"{what} lacks {', '.join(missing)}")
    if unknown := [name for name in content if name not in names]:
        raise ValueError(f"{what} has {short(unknown[0])}, which is not part of this format")
