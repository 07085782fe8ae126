"""Stored demonstrations, as an observation config asks for them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from rlbench_pin.datasets import Episode, checked_task_name, stored_demos
from rlbench_pin.datasets.formats.rlbench import folder_demos, folder_descriptions, folder_episodes
from rlbench_pin.datasets.reader import check_there, counted_files
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.observations.stored_pictures import fit, wanted_fields
from rlbench_pin.errors import DatasetError, InvalidArgument
from rlbench_pin.observation import Demo
from rlbench_pin.values import as_flag, as_whole


@dataclass(frozen=True)
class StoredSelection:
    """Which stored demonstrations of a task are wanted."""

    amount: int
    """How many; -1 is all."""
    variation: int
    """Of which variation; -1 is any."""
    image_paths: bool
    """Leave pictures unread: fields hold the paths of PNG files, or what `datasets.read_picture` reads."""
    random_selection: bool
    """Pick at random."""
    from_episode_number: int
    """First episode when not picked at random: an index of the stored ones in natural order."""

    def __post_init__(self) -> None:
        """Raise InvalidArgument for what is no whole number, or no switch; ranges depend on what is stored."""
        for name in ("amount", "variation", "from_episode_number"):
            as_whole(getattr(self, name), name, InvalidArgument)
        for name in ("image_paths", "random_selection"):
            as_flag(getattr(self, name), name, InvalidArgument)


def read_stored_demos(
    dataset_root: str, task_name: str, wanted: StoredSelection, config: ObservationConfig, rng: np.random.Generator
) -> list[Demo]:
    """Read stored demonstrations of one task.

    The root may hold our episode files or RLBench-style folders.

    Args:
        dataset_root: Folder of the dataset.
        task_name: Name of the task.
        wanted: Which of them.
        config: Which fields are wanted, and how pictures are.
        rng: Draws the episodes.

    Raises:
        DatasetError: No dataset root was given, something is missing or broken, or more are wanted than stored.
    """
    root = _checked_root(dataset_root, "demonstrations", ", or ask for `live_demos=True`")
    read = folder_demos if _holds_folders(root, task_name) else stored_demos
    demos = read(
        root, task_name, wanted.amount, wanted.variation,
        image_paths=wanted.image_paths, random_selection=wanted.random_selection,
        from_episode_number=wanted.from_episode_number, rng=rng, fields=wanted_fields(config),
    )  # fmt: skip
    for observation in () if wanted.image_paths else chain.from_iterable(demos):
        fit(observation, config)
    return demos


def read_stored_descriptions(dataset_root: str, task_name: str, episode: int) -> list[str]:
    """Return the sentences of one stored episode, counted through all variations in natural order.

    Raises:
        DatasetError: There is no dataset root, or no such episode.
    """
    root, episode = _checked_root(dataset_root, "sentences"), as_whole(episode, "episode", InvalidArgument)
    folders = _holds_folders(root, task_name)
    paths = folder_episodes(root, task_name) if folders else list(counted_files(root, task_name))
    if not 0 <= episode < len(paths):
        raise DatasetError(f"'{root}' holds {len(paths)} episodes of '{task_name}', so there is no episode {episode}.")
    if folders:
        return list(folder_descriptions(paths[episode]))
    check_there(paths[episode])
    with Episode(paths[episode]) as stored:
        return list(stored.instructions)


def _checked_root(dataset_root: str, what: str, otherwise: str = "") -> Path:
    if not dataset_root:
        raise DatasetError(
            f"No dataset root was given, so there are no stored {what}. Pass `Environment(dataset_root=...)`{otherwise}."
        )
    return Path(dataset_root)


def _holds_folders(root: Path, task: str) -> bool:
    """Whether a task is stored as RLBench-style folders."""
    return not (root / checked_task_name(task) / "manifest.json").exists() and bool(folder_episodes(root, task))
