"""What `rlbench-pin demo TASK` takes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import tyro

from rlbench_pin.cli.process.words import Cameras, Size, TaskName
from rlbench_pin.observation import CAMERAS


@dataclass(frozen=True)
class RecordDemos:
    """Plan demonstrations of one task, write each to an HDF5 episode, and film it."""

    task: tyro.conf.Positional[TaskName]
    """Task name, as `rlbench-pin list` prints it, or a task file."""
    variation: int = 0
    """Variation of the task; -1 draws one for each episode."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    episodes: int = 1
    """Successful episodes to write."""
    out: Path = Path("out/demo")
    """Folder of the dataset."""
    video: bool = True
    """Film each episode from the side as an MP4 beside it."""
    image_size: Size = (128, 128)
    """Width and height of the cameras' pictures [px]."""
    cameras: Cameras = CAMERAS
    """Cameras whose pictures are stored."""
    max_attempts: int = 10
    """Tries for each episode."""
    json: bool = False
    """Print JSON for programs."""
