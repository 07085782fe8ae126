"""Demonstrations as examples of behaviour cloning: what was observed at a tick, and the commands of the ticks after it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rlbench_pin.datasets import stored_demos
from rlbench_pin.environment.stored import resize
from rlbench_pin.errors import DatasetError
from rlbench_pin.evaluation.baselines.cloning.sentences import encode_sentence
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.spatial import FloatArray

CHUNK = 20
"""Ticks ahead that commands are predicted for."""
SECONDS = 0.05
"""A tick [s]."""
PICTURE = 64
"""Width and height of the pictures that a network sees [px]."""


@dataclass(frozen=True)
class Examples:
    """All ticks of some demonstrations of one task, one after the other."""

    joints: FloatArray
    """Joint positions at each tick, (n, 7) [rad]."""
    opening: FloatArray
    """Whether the hand is open, (n, 1)."""
    task_state: FloatArray
    """What the task says about its objects, (n, m); m = 0 where pictures are to say it."""
    time: FloatArray
    """Time since the start, (n, 1) [s]."""
    episode: np.ndarray
    """Number of its demonstration, (n,)."""
    sentences: tuple[FloatArray, ...]
    """Encoded instructions of each demonstration, (k, size)."""
    targets: FloatArray
    """Commanded joint positions of the next `CHUNK` ticks, (n, CHUNK, 7) [rad]; the last command is held."""
    hand: FloatArray
    """Commanded opening of the same ticks, (n, CHUNK)."""
    pictures: np.ndarray
    """uint8 (n, cameras, PICTURE, PICTURE, 3); no cameras where the task state says where things are."""
    instructions: tuple[str, ...]
    """Every sentence that occurs."""


def read_examples(root: Path, task: str, demos: int = -1, cameras: Sequence[str] = ()) -> Examples:
    """Read the first demonstrations of a task, spread over its variations, as examples.

    Args:
        root: Folder of a dataset.
        task: Name of the task.
        demos: How many; -1 is all.
        cameras: Cameras whose colours are read in place of the task state.

    Raises:
        DatasetError: Too few are stored, or they lack what is needed.
    """
    fields = ["joint_positions", "gripper_open", *([f"{c}_rgb" for c in cameras] or ["task_low_dim_state"])]
    rng = np.random.default_rng(0)
    return make_examples(stored_demos(root, task, demos, -1, rng=rng, fields=fields), cameras)


def make_examples(demos: Sequence[Demo], cameras: Sequence[str] = ()) -> Examples:
    """Return the examples of demonstrations.

    Raises:
        DatasetError: They lack actions, the task state or a camera.
    """
    parts = [_columns(demo, index, cameras) for index, demo in enumerate(demos)]
    if not parts:
        raise DatasetError("There are no demonstrations to learn from. `rlbench-pin record` makes some.")
    stacked = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    said = [tuple(str(s) for s in demo[0].misc.get("descriptions", ())) or ("",) for demo in demos]
    sentences = tuple(np.stack([encode_sentence(s) for s in each]) for each in said)
    return Examples(**stacked, sentences=sentences, instructions=tuple(dict.fromkeys(s for each in said for s in each)))


def pictures_of(observation: Observation, cameras: Sequence[str]) -> np.ndarray:
    """Return the colours of some cameras, uint8 (cameras, PICTURE, PICTURE, 3).

    Raises:
        DatasetError: One of them is missing.
    """
    found = [getattr(observation, f"{camera}_rgb", None) for camera in cameras]
    if any(picture is None for picture in found):
        raise DatasetError(f"An observation lacks the colours of one of {list(cameras)}. Record them with `--products rgb`.")
    return np.stack([resize(np.asarray(p), (PICTURE, PICTURE)) for p in found]) if found else _no_pictures()


def _no_pictures() -> np.ndarray:
    return np.zeros((0, PICTURE, PICTURE, 3), np.uint8)


def _columns(demo: Demo, index: int, cameras: Sequence[str]) -> dict[str, np.ndarray]:
    """Return the columns of one demonstration; its last frame has no action, so it is no example."""
    frames = list(demo)[:-1]
    commands = [o.misc.get("joint_position_action") for o in list(demo)[1:]]
    if not frames or any(c is None for c in commands):
        raise DatasetError("A demonstration lacks `joint_position_action`, so there is nothing to imitate. Record it live.")
    if not cameras and any(o.task_low_dim_state is None for o in frames):
        raise DatasetError("A demonstration lacks `task_low_dim_state`. Record it, or name cameras to learn from.")
    ahead = np.minimum(np.arange(len(frames))[:, None] + np.arange(CHUNK), len(commands) - 1)
    chunks = np.asarray(commands)[ahead]
    state = [np.zeros(0) if cameras else np.asarray(o.task_low_dim_state) for o in frames]
    return {
        "joints": np.stack([np.asarray(o.joint_positions) for o in frames]),
        "opening": np.array([[float(o.gripper_open or 0.0)] for o in frames]),
        "task_state": np.stack(state),
        "time": np.arange(len(frames))[:, None] * SECONDS,
        "episode": np.full(len(frames), index),
        "targets": chunks[..., :-1],
        "hand": chunks[..., -1],
        "pictures": np.stack([pictures_of(o, cameras) for o in frames]),
    }
