"""Rerender stored demonstrations with other cameras. A seed determines a demonstration, so a list of seeds is a dataset."""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

from rlbench_pin.datasets import EpisodeEntry, kept_task, read_manifest, stored_tasks
from rlbench_pin.datasets.layout import check_inside, checked_task_name, chosen_tasks, episode_path
from rlbench_pin.datasets.manifest import is_whole, parse_json, short
from rlbench_pin.datasets.storage import hold, remove_leftovers, write_whole
from rlbench_pin.environment.factors import FactorSetting
from rlbench_pin.environment.recovery import as_disturbances
from rlbench_pin.errors import DatasetConflict, DatasetError, EpisodeFileError, InvalidArgument
from rlbench_pin.observation import Disturbance
from rlbench_pin.processes import Engine
from rlbench_pin.recording.config import RECORDING, ImageConfig, WorkItem, read_recording
from rlbench_pin.recording.record import OnProgress, RecordReport, check_work, run_items
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.tasks import OwnTasks, Task, keep_tasks, stored_task, task_class, task_digest, task_origin, task_reference
from rlbench_pin.values import as_number, as_path, as_record, as_several

SEEDS_FORMAT = "rlbench_pin.seeds"
VERSION = 1


@dataclass(frozen=True)
class EpisodeSeed:
    """The data that determine one demonstration, together with the task and the versions of the libraries."""

    task: str
    """Task name."""
    variation: int
    """Variation of the task."""
    episode: int
    """Number of the episode within its variation."""
    seed: int
    """Seed of the episode."""
    attempt: int
    """Number of the attempt of the seed."""
    robot: str = DEFAULT_ROBOT
    """Name of the arm, or path of its TOML file."""
    factors: str = ""
    """Factors of generalisation, such as `light_color:2`; none when empty."""
    disturb: tuple[Disturbance, ...] = ()
    """Disturbances of which one happens; none when empty."""
    max_velocity: float = 1.0
    """Limit of the speed along the joint-space path [rad/s]."""
    max_acceleration: float = 4.0
    """Limit of the acceleration along the joint-space path [rad/s^2]."""

    def __post_init__(self) -> None:
        """Raise InvalidArgument for factors or disturbances that do not exist."""
        FactorSetting.of(self.factors)
        object.__setattr__(self, "disturb", as_disturbances(self.disturb))

    def check(self) -> None:
        """Raise DatasetError or ValueError unless the task name and the numbers are valid: paths of files contain them."""
        checked_task_name(self.task)
        for name in ("variation", "episode", "seed", "attempt"):
            if not is_whole(value := getattr(self, name)):
                raise ValueError(f"{name}={short(value)} of '{self.task}' is not a whole number of at least 0")
        for name in ("max_velocity", "max_acceleration"):
            as_number(getattr(self, name), name, InvalidArgument, above=0.0)
        robot_description(self.robot)


def seeds_of(root: Path) -> list[EpisodeSeed]:
    """Return the seeds of a dataset.

    Args:
        root: Folder of the dataset; only its manifests are needed.

    Raises:
        DatasetError: An episode has no seed.
    """
    entries = _entries(root, ())
    more = _common(root)
    return [_seed(task, entry, **more) for task, entry in entries]


def write_seeds(path: Path, seeds: Sequence[EpisodeSeed]) -> Path:
    """Write a list of seeds, about 40 bytes for each episode instead of megabytes, and return the path."""
    seeds = [as_record(seed, EpisodeSeed, "an entry of seeds") for seed in as_several(seeds, "seeds")]
    content = {"format": SEEDS_FORMAT, "version": VERSION, "episodes": [_written(seed) for seed in seeds]}
    return write_whole(as_path(path, "path"), (json.dumps(content, indent=1) + "\n").encode())


def _written(seed: EpisodeSeed) -> dict[str, Any]:
    """Return a seed as a table, without values that equal their defaults."""
    defaults = {field.name: field.default for field in fields(EpisodeSeed)}
    return {key: value for key, value in asdict(seed).items() if value != defaults[key]}


def read_seeds(path: Path) -> list[EpisodeSeed]:
    """Read a list of seeds.

    Raises:
        EpisodeFileError: The file contains no list of seeds.
    """
    try:
        content = parse_json(as_path(path, "path").read_text(encoding="utf-8"))
        if (content["format"], content["version"]) != (SEEDS_FORMAT, VERSION):
            found = f"format {content['format']!r}, version {content['version']!r}"
            raise ValueError(f"it has {found}, this package reads {SEEDS_FORMAT!r}, version {VERSION}")
        seeds = [EpisodeSeed(**seed) for seed in content["episodes"]]
        for seed in seeds:
            seed.check()
    except (OSError, ValueError, KeyError, TypeError, DatasetError) as error:
        raise EpisodeFileError(
            path, f"'{path}' is not a list of seeds: {error}. `rlbench-pin dataset seeds ROOT FILE` writes one."
        ) from error
    return seeds


def rerender(
    source: Path,
    out: Path,
    images: ImageConfig,
    *,
    tasks: Sequence[str] = (),
    engine: Engine | None = None,
    on_progress: OnProgress | None = None,
    stop: threading.Event | None = None,
    own: OwnTasks | None = None,
    trust_task_files: bool = False,
) -> RecordReport:
    """Record the demonstrations of a dataset again, with other images. The same call continues an interrupted run.

    Each demonstration is made again from its seed. If the old file exists, the new joint positions must be byte-identical to the
    old ones. If they are not, the old start is restored and the old actions are repeated. Then the joint positions must be within
    1 mrad of the old ones.

    Args:
        source: Folder of the dataset (only its manifests are needed), or a file with a list of seeds.
        out: Folder of the new dataset.
        images: Images of the new episodes.
        tasks: Only these tasks; all tasks when empty.
        engine: The engine; None uses one process.
        on_progress: Same as for `record`.
        stop: Same as for `record`.
        own: Task name -> task class of the user; these replace tasks of the same name in the dataset.
        trust_task_files: Whether task files in the dataset may be run.

    Raises:
        UntrustedTaskFile: A task is code in the dataset, and `trust_task_files` is not set.
        DatasetError: The source cannot be used, or is `out`.
    """
    source, out, _ = as_path(source, "source"), as_path(out, "out"), as_record(images, ImageConfig, "images")
    check_work(engine, on_progress, stop, trust_task_files)
    _check_apart(source, out)
    items = _items(source, tasks)
    classes = _classes(source, sorted({item.task for item in items}), own, trust_task_files)
    with hold(out):
        remove_leftovers(out)
        keep_tasks(out, classes.values())
        return run_items(images, _with_tasks(items, classes), out, engine=engine, on_progress=on_progress, stop=stop)


def _check_apart(source: Path, out: Path) -> None:
    if source.is_dir() and source.resolve() == out.resolve():
        raise DatasetConflict(f"'{out}' is the dataset to rerender. Choose another folder for the result.")


def _classes(source: Path, names: Sequence[str], own: OwnTasks | None, trust_task_files: bool) -> dict[str, type[Task]]:
    """Return the tasks of the user, of the dataset and of other packages; workers find all others by name."""
    own = {} if own is None else as_record(own, Mapping, "own")  # type: ignore[type-abstract]
    found = {name: own[name] for name in names if name in own}
    for name in names:
        if name not in own and source.is_dir() and kept_task(source, name) is not None:
            found[name] = stored_task(source, name, own, trust_task_files)
        elif name not in own and task_origin(name):
            found[name] = task_class(name)
    return found


def _with_tasks(items: Sequence[WorkItem], classes: Mapping[str, type[Task]]) -> list[WorkItem]:
    """Return the items with the name or path of their tasks for the workers, and the SHA-256 of the task files."""
    found_by = {name: (task_reference(task), task_digest(task)) for name, task in classes.items()}
    return [replace(i, task=found_by[i.name][0], task_digest=found_by[i.name][1]) if i.name in found_by else i for i in items]


def _items(source: Path, tasks: Sequence[str]) -> list[WorkItem]:
    if source.is_file():
        seeds = read_seeds(source)
        chosen = chosen_tasks(source, sorted({seed.task for seed in seeds}), tasks)
        return _at_least_one(source, [_item(seed) for seed in seeds if seed.task in chosen])
    items, more = [], _common(source)
    for task, entry in _entries(source, tasks):
        path = episode_path(source, task, entry.variation, entry.episode)
        check_inside(source, path)
        held = path.is_file()
        items.append(_item(_seed(task, entry, **more), str(path) if held else "", entry.sha256 if held else ""))
    return _at_least_one(source, items)


def _at_least_one(source: Path, items: list[WorkItem]) -> list[WorkItem]:
    if not items:
        raise DatasetError(f"'{source}' lists no episodes to rerender. Record some with `rlbench-pin record TASK`.")
    return items


def _item(seed: EpisodeSeed, source: str = "", sha256: str = "") -> WorkItem:
    found_by = (seed.task, seed.task, seed.variation, seed.episode, seed.seed, (seed.attempt,))
    return WorkItem(
        *found_by,
        source,
        sha256,
        seed.max_velocity,
        seed.max_acceleration,
        seed.robot,
        factors=seed.factors,
        disturb=seed.disturb,
    )


def _common(root: Path) -> dict[str, Any]:
    """Return the factors, disturbances and limits of the recording in a folder; none if it has no recording file."""
    if not (as_path(root, "root") / RECORDING).exists():
        return {}
    config = read_recording(root)
    limits = {"max_velocity": config.max_velocity, "max_acceleration": config.max_acceleration}
    return {"factors": config.factors, "disturb": config.disturb, **limits}


def _entries(root: Path, tasks: Sequence[str]) -> list[tuple[str, EpisodeEntry]]:
    return [(task, entry) for task in chosen_tasks(root, stored_tasks(root), tasks) for entry in read_manifest(root, task)]


def _seed(task: str, entry: EpisodeEntry, **more: Any) -> EpisodeSeed:
    if entry.random_seed is None:
        raise DatasetError(f"'{entry.file}' of '{task}' has no seed, so it cannot be made again. Record the task again.")
    return EpisodeSeed(task, entry.variation, entry.episode, entry.random_seed, entry.attempt, entry.robot, **more)
