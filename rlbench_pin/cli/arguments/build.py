"""What `rlbench-pin build [NAME]` takes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from rlbench_pin.cli.process.words import MaybePath

MaybeName = Annotated[str, tyro.conf.arg(metavar="[NAME]", help_behavior_hint="")]
"""A task that may be left out."""


@dataclass(frozen=True)
class Build:
    """Make or change a task in the browser: its scene, its behaviour, demonstration and check. Writes NAME.toml and NAME.py."""

    name: tyro.conf.Positional[MaybeName] = ""
    """A task of `--out` or of the library, to change it, or the name of a new one in snake case; a new task when left out."""
    task_file: MaybePath = None
    """Instead of a name: one of the two files of a task."""
    out: Path = Path()
    """Folder of the task; one of the library stays in its own. Nothing outside of it is written."""
    port: int = 0
    """Port of 127.0.0.1 to serve the page at; 0 takes one that is free."""
    browser: bool = True
    """Open the page where there is a browser on a screen; its address is printed in any case."""
    trust: bool = False
    """Run the Python of the task from the start. Otherwise the page asks first."""
