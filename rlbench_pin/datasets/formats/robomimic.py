"""Export to one HDF5 file as robomimic reads it: `data/demo_<i>/{actions, rewards, dones, states, obs, next_obs}` and `mask`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np

from rlbench_pin.datasets.episode import Episode
from rlbench_pin.datasets.formats.common import (
    OnEpisode,
    StoredEpisode,
    actions,
    new_folder,
    opened,
    rgb_cameras,
    stored_episodes,
)
from rlbench_pin.datasets.storage import DeferredErrorFile
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import CAMERAS, LOW_DIM
from rlbench_pin.values import as_function, as_path

_FILE = "data.hdf5"
ENV_TYPE = 2
"""Robomimic's type of a gym environment."""


def export_robomimic(
    root: Path, out: Path, *, tasks: Sequence[str] = (), cameras: Sequence[str] = (), on_episode: OnEpisode | None = None
) -> Path:
    """Write the episodes of one task to an HDF5 file.

    Actions are absolute joint positions and the gripper, scaled to -1..1 by the minimum and maximum over the file; `data` has
    both as attributes `action_low` and `action_high`, so that action = low + (scaled + 1) / 2 * (high - low).

    Args:
        root: Folder of the dataset.
        out: The file, which must not exist.
        tasks: The task; may be empty if only one is stored.
        cameras: Cameras whose images are exported; all stored ones if empty.
        on_episode: Called after each episode.

    Raises:
        DatasetError: There is more than one task, or something is missing or damaged.
    """
    as_function(on_episode, "on_episode")
    out = as_path(out, "out")
    episodes = stored_episodes(root, tasks)
    if len({e.task for e in episodes}) > 1:
        raise DatasetError(f"A robomimic file has one task. Name one of {sorted({e.task for e in episodes})} with `--tasks`.")
    shapes = rgb_cameras(episodes, cameras)
    low, high = _action_range(episodes)
    with new_folder(out, _FILE) as folder, DeferredErrorFile(folder / _FILE) as raw, h5py.File(raw, "w") as file:
        data = file.create_group("data")
        total = 0
        for index, (stored, episode) in enumerate(opened(episodes, on_episode)):
            total += _write(data.create_group(f"demo_{index}"), stored, episode, list(shapes), low, high)
            file.flush()
            raw.check()
        data.attrs["total"] = total
        data.attrs["action_low"], data.attrs["action_high"] = low, high
        data.attrs["env_args"] = json.dumps(_env_args(episodes[0].task, episode.task_version, episode.robot))
        _write_masks(file, len(episodes))
    return out


def _action_range(episodes: Sequence[StoredEpisode]) -> tuple[np.ndarray, np.ndarray]:
    lows, highs = [], []
    for stored in episodes:
        with stored.open() as episode:
            rows = actions(episode)
        lows.append(rows.min(0))
        highs.append(rows.max(0))
    return np.min(lows, axis=0), np.max(highs, axis=0)


def _write(
    group: h5py.Group, stored: StoredEpisode, episode: Episode, cameras: list[str], low: np.ndarray, high: np.ndarray
) -> int:
    rows = actions(episode)
    span = np.where(high > low, high - low, 1.0)
    last = np.arange(len(rows)) == len(rows) - 1
    group.attrs["num_samples"] = len(rows)
    group.attrs["instructions"] = json.dumps(list(episode.instructions))
    group.attrs["seed"], group.attrs["variation"] = stored.entry.random_seed or 0, episode.variation
    group["actions"] = 2.0 * (rows - low) / span - 1.0
    group["actions_abs"] = rows
    group["rewards"] = last.astype(np.float64)
    group["dones"] = last.astype(np.int64)
    observations = _observations(episode, cameras)
    group["states"] = np.column_stack([v[:-1] for v in observations.values() if v.ndim == 2])
    for name, values in observations.items():
        options = {"compression": "gzip", "chunks": (1, *values.shape[1:])} if values.ndim > 2 else {}
        group.create_dataset(f"obs/{name}", data=values[:-1], **options)
        group.create_dataset(f"next_obs/{name}", data=values[1:], **options)
    return len(rows)


def _observations(episode: Episode, cameras: list[str]) -> dict[str, np.ndarray]:
    """Return name -> values of all frames, at least two-dimensional."""
    found = {name: episode.array(name) for name in LOW_DIM if name in episode.fields}
    result = {name: values[:, None] if values.ndim == 1 else values for name, values in found.items() if values.shape[1:] != (0,)}
    for camera in CAMERAS:
        if camera in cameras:
            result[f"{camera}_image"] = episode.array(f"{camera}_rgb")
            if f"{camera}_depth" in episode.fields:
                result[f"{camera}_depth"] = episode.array(f"{camera}_depth")[..., None]
    return result


def _env_args(task: str, version: int, robot: str) -> dict[str, object]:
    """Return the environment by its id in gymnasium; see `rlbench_pin.gym.gym_id`."""
    return {"env_name": f"rlbench_pin/{task}-state-v{version - 1}", "type": ENV_TYPE, "env_kwargs": {"robot": robot}}


def _write_masks(file: h5py.File, count: int) -> None:
    """Write the masks: every tenth demonstration is for validation, the others are for training."""
    names = np.array([f"demo_{i}".encode() for i in range(count)])
    held_out = np.arange(count) % 10 == 9
    file["mask/train"], file["mask/valid"] = names[~held_out], names[held_out]
