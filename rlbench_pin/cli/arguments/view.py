"""What `rlbench-pin view TASK` takes."""

from __future__ import annotations

from dataclasses import dataclass

import tyro

from rlbench_pin.cli.process.words import MaybePath, TaskName


@dataclass(frozen=True)
class View:
    """Draw a contact sheet: seven cameras at the reset and at four moments of a demonstration."""

    task: tyro.conf.Positional[TaskName]
    """Task name, as `rlbench-pin list` prints it, or a task file."""
    variation: int = 0
    """Variation of the task."""
    seed: int = 0
    """Seed of the episode."""
    out: MaybePath = None
    """PNG or JPEG to write; `out/view/<task>.png` by default."""
    size: int = 256
    """Side of each picture [px]."""
