"""What `rlbench-pin view TASK` takes."""

from __future__ import annotations

from dataclasses import dataclass, field

import tyro

from rlbench_pin.cli.process.pages import PageOptions
from rlbench_pin.cli.process.words import Files, MaybePath, Viewed


@dataclass(frozen=True)
class View:
    """Draw a contact sheet: seven cameras at the reset and at four moments of a demonstration. With `--live`, a page instead:
    episodes of a task, or the stored demonstrations of a dataset.
    """

    task: tyro.conf.Positional[Viewed]
    """Task name, as `rlbench-pin list` prints it, or a task file; with `--live` also the folder of a dataset."""
    variation: int = 0
    """Variation of the task."""
    seed: int = 0
    """Seed of the episode."""
    out: MaybePath = None
    """PNG or JPEG to write; `out/view/<task>.png` by default."""
    size: int = 256
    """Side of each picture [px]."""
    page: tyro.conf.OmitArgPrefixes[PageOptions] = field(default_factory=PageOptions)
    """A page instead of a picture."""
    task_file: Files = ()
    """With a dataset, your own files of tasks that are not installed; they are used instead of those that it keeps."""
    trust_task_files: bool = False
    """Run the task files that the dataset keeps, where tasks are not installed. Read them first."""
