"""What `rlbench-pin problems export TASK...` takes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from rlbench_pin.cli.process.words import SomeTasks


@dataclass(frozen=True)
class Problems:
    """Write motions of demonstrations as planning problems: arm, obstacles, held bodies, start and goal, as JSON.

    A problem is a leg that is planned to a pose among obstacles. Legs that may touch anything (`ignore_collisions`), or follow
    a curve, are none; the last line for each task counts them.
    """

    action: tyro.conf.Positional[Literal["export"]]
    """What to do."""
    tasks: tyro.conf.Positional[SomeTasks] = ()
    """Task names, as `rlbench-pin list` prints them, with spaces or commas between them, `all`, or task files."""
    episodes: int = 5
    """Demonstrations of each task."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    out: Path = Path("problems")
    """Folder for the files."""
