"""What `rlbench-pin new NAME` takes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True)
class New:
    """Write a commented pair of files, NAME.py and NAME.toml: a reach that passes `rlbench-pin check --task-file NAME.py`."""

    name: tyro.conf.Positional[Annotated[str, tyro.conf.arg(metavar="NAME")]]
    """Name of the task in snake case."""
    out: Path = Path()
    """Folder to write to; `rlbench_pin/tasks/library` makes it a task of the package."""
