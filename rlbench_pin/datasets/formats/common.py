"""Common parts of all exporters: selection of episodes, and states and actions of every frame."""

from __future__ import annotations

import fcntl
import glob
import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rlbench_pin.datasets.episode import Episode
from rlbench_pin.datasets.layout import check_inside, chosen_tasks, manifest_path, stored_tasks
from rlbench_pin.datasets.manifest import EpisodeEntry, read_manifest
from rlbench_pin.errors import DatasetConflict, DatasetError, storing
from rlbench_pin.observation import CAMERAS
from rlbench_pin.values import as_names, as_path

FPS = 20
"""Frames of a demonstration in a second of simulated time [1/s]."""
OnEpisode = Callable[[int], None]
"""Called with the number of episodes written so far."""


@dataclass(frozen=True)
class StoredEpisode:
    """One episode to be exported."""

    task: str
    entry: EpisodeEntry
    path: Path

    def open(self) -> Episode:
        """Check path and SHA-256, and open the episode."""
        check_inside(self.path.parents[3], self.path)
        return Episode(self.path, self.entry.sha256)


def stored_episodes(root: Path, tasks: Sequence[str] = ()) -> list[StoredEpisode]:
    """Return the episodes of a dataset, task by task, in the order of the manifests.

    Raises:
        DatasetError: A task is not stored, or the dataset is empty.
    """
    episodes = [
        StoredEpisode(task, entry, manifest_path(root, task).parent / entry.file)
        for task in chosen_tasks(root, stored_tasks(root), tasks)
        for entry in read_manifest(root, task)
    ]
    if not episodes:
        raise DatasetError(f"'{root}' lists no episodes. Record some with `rlbench-pin record TASK --out {root}`.")
    return episodes


def opened(episodes: Iterable[StoredEpisode], on_episode: OnEpisode | None) -> Iterator[tuple[StoredEpisode, Episode]]:
    """Yield open episodes, one at a time; call `on_episode` after each.

    Raises:
        DatasetError: The episodes are of different arms.
    """
    robot = ""
    for index, stored in enumerate(episodes):
        with stored.open() as episode:
            if robot not in ("", episode.robot):
                raise DatasetError(
                    f"'{stored.path}' was recorded with the arm '{episode.robot}', those before it with '{robot}'. "
                    "Name tasks of one arm with `--tasks`, and export the others to another folder."
                )
            robot = episode.robot
            yield stored, episode
        if on_episode is not None:
            on_episode(index + 1)


def actions(episode: Episode) -> np.ndarray:
    """Return the commands of an episode, shape (frames - 1, n + 1): row t leads from frame t to frame t + 1.

    The first n numbers are absolute joint positions [rad], the last is the gripper: 1 open, 0 closed.
    """
    commands = episode.misc("joint_position_action")[1:]
    if not commands or any(c is None for c in commands):
        raise DatasetError(f"'{episode.path}' does not have `joint_position_action` in every frame. Record it live.")
    return np.array(commands, dtype=np.float64)


def joint_state(episode: Episode) -> np.ndarray:
    """Return joint positions [rad] and the gripper (1 open) of every frame, shape (frames, n + 1)."""
    return np.column_stack([episode.array("joint_positions"), episode.array("gripper_open")])


def joint_names(episode: Episode) -> list[str]:
    """Return names for the numbers of states and actions."""
    return [*episode.joint_names, "gripper"]


def rgb_cameras(episodes: Sequence[StoredEpisode], wanted: Sequence[str] = ()) -> dict[str, tuple[int, int, int]]:
    """Return the cameras whose colour images are stored, and the shapes of the images.

    Raises:
        DatasetError: A requested camera has no images, or images of one camera differ in size.
    """
    wanted = as_names(wanted, "cameras")
    shapes: dict[str, tuple[int, int, int]] | None = None
    for stored in episodes:
        with stored.open() as episode:
            fields = frozenset(episode.fields)
            names = [c for c in CAMERAS if f"{c}_rgb" in episode.fields and (not wanted or c in wanted)]
            found = {name: _image_shape(episode, f"{name}_rgb") for name in names}
        if missing := sorted(set(wanted) - set(found)):
            held = [camera for camera in CAMERAS if f"{camera}_rgb" in fields]
            raise DatasetError(
                f"'{stored.path}' has no colour images of {missing}, only of {held}. Name others."
                if held
                else f"'{stored.path}' has no colour images. Render some with `rlbench-pin dataset rerender`."
            )
        if shapes is not None and shapes != found:
            raise DatasetConflict(
                f"'{stored.path}' has images {found}, episodes before it {shapes}. "
                "Rerender them with `rlbench-pin dataset rerender` first."
            )
        shapes = found
    return shapes or {}


def _image_shape(episode: Episode, field: str) -> tuple[int, int, int]:
    shape = episode.shape(field)
    if len(shape) != 3 or shape[2] != 3:
        raise DatasetError(f"'{episode.path}' has {field} of shape {shape} per frame, which is not an image. Record it again.")
    return shape[0], shape[1], 3


@contextmanager
def new_folder(out: Path, file: str = "") -> Iterator[Path]:
    """Yield a temporary folder next to `out`; it is renamed to `out` at the end of the block, or deleted after an error.

    Leftovers of killed exports to the same place are deleted.

    Args:
        out: The new folder, or the new file.
        file: A file that the block writes; if given, it alone is renamed to `out`.

    Raises:
        DatasetConflict: `out` exists.
        StorageError: The disk cannot be written to.
    """
    out = as_path(out, "out")
    if out.exists():
        raise DatasetConflict(f"'{out}' exists. Delete it, or choose a new folder or file for the export.")
    temporary = out.with_name(f".{out.name}.{os.getpid()}.part")
    with storing(out):
        temporary.parent.mkdir(parents=True, exist_ok=True)
        _remove_abandoned(out)
        with _held(temporary):
            try:
                yield temporary
                os.replace(temporary / file if file else temporary, out)
            finally:
                shutil.rmtree(temporary, ignore_errors=True)


@contextmanager
def _held(folder: Path) -> Iterator[None]:
    """Create a folder and lock it during the block; the system unlocks it if this process is killed."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    lock = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)


def _remove_abandoned(out: Path) -> None:
    """Delete the temporary folders of exports to `out` that no process has locked."""
    for folder in out.parent.glob(f".{glob.escape(out.name)}.*.part"):
        if folder.is_symlink() or not folder.is_dir():
            continue
        lock = os.open(folder, os.O_RDONLY)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(folder, ignore_errors=True)
        except BlockingIOError:
            continue  # it is being written
        finally:
            os.close(lock)


def column_statistics(values: np.ndarray) -> dict[str, list[float]]:
    """Return minimum, maximum, mean, standard deviation, quantiles and count of the rows of an array (n, k)."""
    rows = np.asarray(values, dtype=np.float64).reshape(len(values), -1)
    quantiles = np.quantile(rows, [0.01, 0.10, 0.50, 0.90, 0.99], axis=0)
    named = dict(zip(("q01", "q10", "q50", "q90", "q99"), quantiles, strict=True))
    table = {"min": rows.min(0), "max": rows.max(0), "mean": rows.mean(0), "std": rows.std(0), **named}
    return {**{name: value.tolist() for name, value in table.items()}, "count": [len(rows)]}
