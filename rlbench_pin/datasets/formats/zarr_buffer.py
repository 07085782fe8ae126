"""Export to a Zarr group in the format of diffusion policies: all frames in sequence, and the end of each episode."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import zarr
from zarr.core.buffer import Buffer
from zarr.storage import LocalStore

from rlbench_pin.datasets.episode import Episode
from rlbench_pin.datasets.formats.common import (
    FPS,
    OnEpisode,
    actions,
    joint_names,
    joint_state,
    new_folder,
    opened,
    rgb_cameras,
    stored_episodes,
)


def export_zarr(
    root: Path, out: Path, *, tasks: Sequence[str] = (), cameras: Sequence[str] = (), on_episode: OnEpisode | None = None
) -> Path:
    """Write the episodes of a dataset to a Zarr group.

    `data` has `state` (joint positions [rad] and gripper), `tip_pose`, `action` (absolute joint positions and gripper, the last
    of an episode repeated) and one `<camera>_rgb` per camera. `meta` has `episode_ends`, `task_index` and the instructions.

    Args:
        root: Folder of the dataset.
        out: The new folder, conventionally `<name>.zarr`.
        tasks: Only these tasks; all if empty.
        cameras: Cameras whose images are exported; all stored ones if empty.
        on_episode: Called after each episode.
    """
    episodes = stored_episodes(root, tasks)
    shapes = rgb_cameras(episodes, cameras)
    with new_folder(out) as folder, _deferred_error_store(folder) as store:
        group = zarr.open_group(store, mode="w", zarr_format=2)
        data, meta = group.create_group("data"), group.create_group("meta")
        ends: list[int] = []
        numbers: list[int] = []
        sentences: dict[str, int] = {}
        for stored, episode in opened(episodes, on_episode):
            columns, names = _columns(episode, list(shapes)), joint_names(episode)
            text = episode.instructions[0] if episode.instructions else stored.task
            _append(data, columns)
            store.check()
            ends.append((ends[-1] if ends else 0) + len(columns["action"]))
            numbers.append(sentences.setdefault(text, len(sentences)))
        meta.create_array("episode_ends", data=np.array(ends, dtype=np.int64))
        meta.create_array("task_index", data=np.array(numbers, dtype=np.int64))
        meta.attrs.update({"tasks": list(sentences), "fps": FPS, "robot": episode.robot, "names": names})
    return out


def _append(data: zarr.Group, columns: Mapping[str, np.ndarray]) -> None:
    """Append the rows of an episode to the arrays of a group; the first episode creates them."""
    for name, values in columns.items():
        if name not in data:
            chunks = (1 if values.ndim > 2 else 1024, *values.shape[1:])
            data.create_array(name, shape=(0, *values.shape[1:]), chunks=chunks, dtype=values.dtype)
        array = data[name]
        assert isinstance(array, zarr.Array)
        array.append(values)


class DeferredErrorStore(LocalStore):
    """A folder that raises an error of the disk only when `check` is called.

    Zarr writes several chunks in parallel. After an error it would still write the others while the folder is removed.
    """

    refused: OSError | None = None
    """The first error of the disk."""

    def check(self) -> None:
        """Raise the first error of the disk, if there was one."""
        if self.refused is not None:
            raise self.refused

    async def set(self, key: str, value: Buffer) -> None:
        """Write all of a chunk, or keep the error."""
        if self.refused is None:
            try:
                await super().set(key, value)
            except OSError as error:
                self.refused = self.refused or error


@contextmanager
def _deferred_error_store(folder: Path) -> Iterator[DeferredErrorStore]:
    """Yield a store in a folder; at the end, raise the first error of the disk in place of the errors that it caused."""
    store = DeferredErrorStore(folder)
    try:
        yield store
    finally:
        store.check()


def _columns(episode: Episode, cameras: list[str]) -> dict[str, np.ndarray]:
    commands = actions(episode)
    return {
        "state": joint_state(episode).astype(np.float32),
        "tip_pose": episode.array("gripper_pose").astype(np.float32),
        "action": np.concatenate([commands, commands[-1:]]).astype(np.float32),
        **{f"{camera}_rgb": episode.array(f"{camera}_rgb") for camera in cameras},
    }
