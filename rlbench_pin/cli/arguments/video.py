"""What `rlbench-pin video TASK...` takes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from rlbench_pin.cli.process.words import MaybePath, Size, SomeTasks


@dataclass(frozen=True)
class Video:
    """Film demonstrations of one or more tasks: one film per task, or one film of all of them in a grid."""

    tasks: tyro.conf.Positional[SomeTasks] = ()
    """Task names, as `rlbench-pin list` prints them, with spaces or commas between them, `all`, or task files."""
    grid: bool = False
    """All tasks side by side in one film instead of a film each."""
    variation: int = 0
    """Variation of the tasks."""
    seed: int = 0
    """Seed of the episodes."""
    size: Size = (1280, 720)
    """Width and height of a film of one task [px], even numbers."""
    speed: float = 0.005
    """Angle that the camera moves in a tick [rad]."""
    fps: int = 20
    """Control ticks per second; 20 is real time."""
    smooth: Literal[1, 2, 3] = 1
    """Pictures of each tick, taken between its physics steps: 3 makes a film with 60 pictures per second."""
    domain_randomization: bool = False
    """Change textures and lights every ten ticks."""
    textures_path: MaybePath = None
    """Folder of textures for `--domain-randomization`; None is the set that comes with the package."""
    renderer: Literal["cpu", "egl", "auto"] = "cpu"
    """What draws the pictures: `cpu`, `egl`, or `auto` for EGL where there is one."""
    max_attempts: int = 10
    """Tries for each demonstration."""
    out: Path = Path("out/video")
    """Folder of the films."""
