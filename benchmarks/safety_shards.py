"""A long run in pieces: every piece that is finished is a file, and a run that was stopped goes on with the others."""

from __future__ import annotations

import json
import multiprocessing
import os
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from safety_scene import CONFIG, EPISODE, GRIPPER_CHANGES, Figures, measure_scene
from tqdm import tqdm

from rlbench_pin.environment.actions.safe_arm import ACCELERATION_SHARE, SHARE

EPISODES = 10
"""Episodes of a piece."""
SHARES = {1: 0.95, 6: 0.034, 12: 0.017}
"""Ticks for which an action is kept -> share of the actions. Those kept take about 200,000 ticks each in a million actions."""
SETTINGS = {
    "episode_actions": EPISODE,
    "gripper_changes": GRIPPER_CHANGES,
    "episodes": EPISODES,
    "shares": [SHARE, ACCELERATION_SHARE],
    **asdict(CONFIG),
}
"""Settings that all shards of one run share."""


@dataclass(frozen=True)
class Shard:
    """One piece: some episodes in one scene, with actions kept for the same number of ticks."""

    task: str
    hold: int
    number: int

    def path(self, folder: Path) -> Path:
        """Return where its figures are kept."""
        return folder / f"{self.task}-{self.hold:02d}-{self.number:04d}.json"

    def measure(self) -> Figures:
        """Play it; a shard comes out alike wherever and whenever it is played."""
        rng = np.random.default_rng([zlib.crc32(self.task.encode()), self.hold, self.number])
        return measure_scene(self.task, EPISODES * EPISODE, self.hold, rng, first=1000 + self.number * EPISODES)


def plan(actions: int, tasks: Sequence[str]) -> list[Shard]:
    """Return the pieces of a run of at least so many actions: every task, and every holding by its share; one of each first."""
    pieces = {hold: int(np.ceil(actions * share * hold / len(tasks) / (EPISODES * EPISODE))) for hold, share in SHARES.items()}
    numbers = range(max(pieces.values()))
    return [Shard(task, hold, n) for n in numbers for hold, count in pieces.items() if n < count for task in tasks]


def read(shard: Shard, folder: Path) -> Figures | None:
    """Return what a finished piece found; None where there is none, or of other settings."""
    path = shard.path(folder)
    if not path.is_file():
        return None
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return Figures(**content["figures"]) if content["settings"] == SETTINGS else None


def run(shards: Sequence[Shard], folder: Path, workers: int) -> Iterator[tuple[Shard, Figures]]:
    """Play the pieces that are missing in `folder`, and yield each when it is done; a bar on stderr shows how far it is."""
    folder.mkdir(parents=True, exist_ok=True)
    missing = [shard for shard in shards if read(shard, folder) is None]
    pieces = {"total": len(shards), "initial": len(shards) - len(missing), "unit": "shard"}
    with multiprocessing.get_context("spawn").Pool(workers, maxtasksperchild=8) as pool, tqdm(**pieces) as bar:
        for shard, figures in pool.imap_unordered(_play, [(shard, folder) for shard in missing]):
            bar.set_postfix_str(f"{shard.task}, {figures.violations()} violations", refresh=False)
            bar.update()
            yield shard, figures


def _play(job: tuple[Shard, Path]) -> tuple[Shard, Figures]:
    """Play one piece and keep it: written beside, then renamed, so that a file is whole."""
    shard, folder = job
    figures = shard.measure()
    path = shard.path(folder)
    temporary = path.with_suffix(f".{os.getpid()}")
    temporary.write_text(json.dumps({"settings": SETTINGS, "figures": asdict(figures)}, indent=1) + "\n", encoding="utf-8")
    temporary.replace(path)
    return shard, figures
