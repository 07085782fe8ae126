"""Map-style dataset for PyTorch: frames of stored demonstrations with the actions that follow them."""

from __future__ import annotations

import os
from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np

from rlbench_pin.datasets.episode import Episode
from rlbench_pin.datasets.formats.common import StoredEpisode, actions, stored_episodes
from rlbench_pin.datasets.key_frames import key_frame_actions, key_frames
from rlbench_pin.datasets.reader import check_there
from rlbench_pin.errors import DatasetError
from rlbench_pin.values import as_flag, as_names, as_path, as_whole

_FOR_KEY_FRAMES = ("joint_velocities", "gripper_open", "gripper_pose", "ignore_collisions")
MAX_HORIZON = 10_000
"""Maximum number of actions of a sample; no demonstration is longer."""
_OPEN_FILES = 64
"""Files that stay open, in each process."""

Sample = dict[str, Any]


class FrameDataset:
    """Frames of the episodes that a dataset lists, each with the actions that follow it.

    `len(dataset)` samples, `dataset[i]` is one: a dict with an array for each field and

    * `action` (horizon, n): the actions that follow the frame, padded with the last action of the episode. Between frames an
      action is absolute joint positions [rad] and the gripper (1 open): n = 8 for the Panda. Between key frames it is a tip pose
      in the world, the gripper, and whether collisions are ignored: n = 9, the format of `EndEffectorPoseViaPlanning`.
    * `action_is_pad` (horizon,): True for the padding.
    * `instruction`: the first instruction.
    * `episode`, `frame`: the number of the episode in this dataset, and of the frame in the episode.

    The last frame of an episode is not a sample, because no action follows it. `torch.utils.data.DataLoader` accepts the dataset,
    also with worker processes: each process opens the files itself and keeps the 64 most recently used ones open.

    Args:
        root: Folder of the dataset.
        tasks: Only these tasks; all if empty.
        fields: Names of the `Observation` fields of a sample.
        horizon: Number of actions of a sample, at most `MAX_HORIZON`.
        key_frames_only: Only first frames and key frames, and one action from each to the next key frame.

    Raises:
        DatasetError: The dataset is empty, a task or a field is not stored, or episodes have no actions.
        InvalidValue: An argument has the wrong type or is out of range.
    """

    def __init__(
        self,
        root: Path | str,
        tasks: Sequence[str] = (),
        *,
        fields: Sequence[str] = ("front_rgb", "joint_positions", "gripper_open"),
        horizon: int = 1,
        key_frames_only: bool = False,
    ) -> None:
        self.fields = as_names(fields, "fields")
        self.horizon = as_whole(horizon, "horizon", least=1, most=MAX_HORIZON)
        self.key_frames_only = as_flag(key_frames_only, "key_frames_only")
        self.episodes: tuple[StoredEpisode, ...] = tuple(stored_episodes(as_path(root, "root"), tasks))
        self._moments = [self._moments_of(stored) for stored in self.episodes]
        self._ends = list(accumulate(len(moments) - 1 for moments in self._moments))
        self._opened, self._process = self._new_cache(), os.getpid()
        if len(self):
            self[0]  # what is missing is an error now

    def __len__(self) -> int:
        return self._ends[-1]

    def __getitem__(self, index: int) -> Sample:
        """Return a sample; a negative index counts from the end.

        Raises:
            IndexError: The index is out of range.
            DatasetError: The file is missing, was altered, or lacks a field at this frame.
        """
        number = as_whole(index, "index")
        if not -len(self) <= number < len(self):
            raise IndexError(f"There is no sample {index}: the dataset has {len(self)}. Choose an index up to {len(self) - 1}.")
        number %= len(self)
        place = bisect_right(self._ends, number)
        moments = self._moments[place]
        row = number - self._ends[place] + len(moments) - 1
        episode, commands = self._open(place)
        rows = np.minimum(np.arange(row, row + self.horizon), len(commands) - 1)
        return {
            **{name: self._value(episode, name, moments[row]) for name in self.fields},
            "action": commands[rows],
            "action_is_pad": np.arange(row, row + self.horizon) >= len(commands),
            "instruction": episode.instructions[0] if episode.instructions else "",
            "episode": place,
            "frame": moments[row],
        }

    def __getstate__(self) -> dict[str, Any]:
        """Leave out open files; another process opens them itself."""
        return {**vars(self), "_opened": None, "_process": None}

    def _moments_of(self, stored: StoredEpisode) -> Sequence[int]:
        """Return the frames between which the actions lead."""
        if not self.key_frames_only:
            return range(stored.entry.frames)
        with stored.open() as episode:
            return [0, *key_frames(episode.observations(fields=_FOR_KEY_FRAMES))]

    def _open(self, place: int) -> tuple[Episode, np.ndarray]:
        if self._process != os.getpid():  # a forked process must not share files with its parent
            self._opened, self._process = self._new_cache(), os.getpid()
        stored = self.episodes[place]
        return self._opened(stored.path, stored.entry.sha256)

    def _new_cache(self) -> Callable[[Path, str], tuple[Episode, np.ndarray]]:
        return lru_cache(_OPEN_FILES)(_open_with_key_frames if self.key_frames_only else _open_with_actions)

    def _value(self, episode: Episode, name: str, frame: int) -> np.ndarray:
        value = episode.series(name, range(frame, frame + 1))[0]
        if value is None:
            raise DatasetError(f"'{episode.path}' has no '{name}' in frame {frame}. Leave it out of `fields`.")
        return np.asarray(value)


def _open_with_actions(path: Path, sha256: str) -> tuple[Episode, np.ndarray]:
    check_there(path)
    episode = Episode(path, sha256)
    return episode, actions(episode)


def _open_with_key_frames(path: Path, sha256: str) -> tuple[Episode, np.ndarray]:
    check_there(path)
    episode = Episode(path, sha256)
    return episode, np.array(key_frame_actions(episode.observations(fields=_FOR_KEY_FRAMES)))
