"""Layout of a dataset: `<root>/<task>/variation<k>/episodes/episode<j>.h5`, and one `manifest.json` per task."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Sequence
from pathlib import Path

from rlbench_pin.errors import DatasetError, EpisodeFileError, nearest_name, shown
from rlbench_pin.values import as_flag, as_names, as_path, as_whole

EPISODE_SUFFIX = ".h5"
MANIFEST = "manifest.json"
ALL_VARIATIONS = -1
"""Number that means all variations, or one drawn for each episode."""

_EPISODE = re.compile(r"episode(0|[1-9][0-9]*)\.h5")
_VARIATION = re.compile(r"variation(0|[1-9][0-9]*)")
_TASK = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,127}")


def checked_task_name(task: str) -> str:
    """Return the name of a task if it is a valid name of a folder.

    Raises:
        DatasetError: It has a slash, a dot or another character that is not allowed.
    """
    if not isinstance(task, str) or _TASK.fullmatch(task) is None:
        raise DatasetError(f"{shown(task)} is not a task name. Use letters, digits, '_' and '-', at most 128 of them.")
    return task


def episode_file(variation: int, episode: int) -> str:
    """Return the path of an episode below the folder of its task."""
    return f"variation{variation}/episodes/episode{episode}{EPISODE_SUFFIX}"


def episode_path(root: Path, task: str, variation: int, episode: int) -> Path:
    """Return the file of one episode."""
    variation, episode = as_whole(variation, "variation", least=0), as_whole(episode, "episode", least=0)
    return as_path(root, "root") / checked_task_name(task) / episode_file(variation, episode)


def manifest_path(root: Path, task: str) -> Path:
    """Return the manifest of one task."""
    return as_path(root, "root") / checked_task_name(task) / MANIFEST


def is_episode_place(path: Path) -> bool:
    """Whether a path ends like a path from `episode_path`."""
    parts = path.parts[-4:]
    checks = (_TASK, _VARIATION, re.compile("episodes"), _EPISODE)
    return len(path.parts) > 4 and all(check.fullmatch(part) for check, part in zip(checks, parts))


def episode_number(path: Path) -> int:
    """Return j of `episode<j>.h5`."""
    match = _EPISODE.fullmatch(as_path(path, "path").name)
    if match is None:
        raise DatasetError(f"'{path}' is not the name of an episode. Rename it to episode<number>{EPISODE_SUFFIX}.")
    return int(match[1])


def stored_tasks(root: Path, *, at_least_one: bool = False) -> tuple[str, ...]:
    """Return the tasks that have a folder with a manifest or variations, by name.

    Args:
        root: Folder of the dataset.
        at_least_one: Whether a folder without tasks is an error.

    Raises:
        DatasetError: The root does not exist, it has no tasks, or the folder of a task is a link out of it.
    """
    at_least_one = as_flag(at_least_one, "at_least_one")
    folders = [p for p in _root_folder(root).iterdir() if p.is_dir() and _TASK.fullmatch(p.name)]
    tasks = sorted(p.name for p in folders if (p / MANIFEST).is_file() or any(p.glob("variation*/episodes")))
    for task in tasks:
        check_inside(root, as_path(root, "root") / task)
    if at_least_one and not tasks:
        raise DatasetError(f"'{root}' contains no demonstrations. Record some with `rlbench-pin record TASK --out {root}`.")
    return tuple(tasks)


def chosen_tasks(place: Path, stored: Sequence[str], tasks: Sequence[str]) -> tuple[str, ...]:
    """Return the named tasks, each once, or all stored tasks if none is named.

    Raises:
        DatasetError: One of them is not stored.
    """
    stored, tasks = as_names(stored, "stored"), as_names(tasks, "tasks")
    for task in tasks:
        if task not in stored:
            raise _unknown_task(place, task, stored)
    return tuple(dict.fromkeys(tasks or stored))


def stored_variations(root: Path, task: str) -> tuple[int, ...]:
    """Return the variations of a task that have a folder, ascending."""
    matches = (_VARIATION.fullmatch(p.name) for p in _task_folder(root, task).iterdir() if p.is_dir())
    return tuple(sorted(int(m[1]) for m in matches if m))


def episode_files(root: Path, task: str, variation: int = ALL_VARIATIONS) -> tuple[Path, ...]:
    """Return the episodes of one variation, or of all (-1), in natural order.

    Raises:
        DatasetError: The root, the task or the variation is not stored there.
    """
    stored = stored_variations(root, task)
    check_variation(root, task, variation, stored)
    wanted = stored if variation == ALL_VARIATIONS else (variation,)
    folders = [episode_path(root, task, v, 0).parent for v in wanted]
    for folder in folders:
        check_inside(root, folder)
    return tuple(path for folder in folders for path in _episodes_in(folder))


def check_variation(root: Path, task: str, variation: int, stored: Collection[int]) -> None:
    """Raise DatasetError unless the variation is stored, or is -1 (all)."""
    variation = as_whole(variation, "variation, -1 for all,")
    if variation != ALL_VARIATIONS and variation not in stored:
        raise DatasetError(f"'{root}' has no variation {variation} of '{task}'. Choose one of {sorted(stored)}, or -1 for all.")


def _episodes_in(folder: Path) -> list[Path]:
    files = [p for p in folder.glob(f"episode*{EPISODE_SUFFIX}") if _EPISODE.fullmatch(p.name)] if folder.is_dir() else []
    return sorted(files, key=episode_number)


def _root_folder(root: Path) -> Path:
    root = as_path(root, "root")
    if not root.is_dir():
        raise DatasetError(f"The dataset folder '{root}' does not exist. Create it with `rlbench-pin record TASK --out {root}`.")
    return root


def _task_folder(root: Path, task: str) -> Path:
    folder = _root_folder(root) / checked_task_name(task)
    if not folder.is_dir():
        raise _unknown_task(root, task, sorted(p.name for p in as_path(root, "root").iterdir() if p.is_dir()))
    check_inside(root, folder)
    return folder


def _unknown_task(place: Path, task: str, stored: Sequence[str]) -> DatasetError:
    near = nearest_name(task, stored)
    guess = f"Did you mean '{near}'?" if near else "Name one of these, or record it with `rlbench-pin record`."
    return DatasetError(f"'{place}' has no task '{task}', only {list(stored)}. {guess}")


def check_inside(root: Path, path: Path) -> None:
    """Raise EpisodeFileError when a link leads from a path below `root` out of it; the root itself may be a link."""
    real = os.path.realpath(path)
    if not Path(real).is_relative_to(os.path.realpath(root)):
        raise EpisodeFileError(path, f"'{path}' is a link out of '{root}', to '{real}'. Do not trust this dataset.")
