"""What `rlbench-pin replay FILE...` takes."""

from __future__ import annotations

from dataclasses import dataclass

import tyro

from rlbench_pin.cli.process.words import Files, SomeFiles


@dataclass(frozen=True)
class Replay:
    """Restore the start of stored episodes, repeat their joint-position actions, and say whether they succeed again."""

    files: tyro.conf.Positional[SomeFiles] = ()
    """Episode files, or folders of datasets, of which the episodes in the manifests are replayed."""

    task_file: Files = ()
    """Your own files of tasks that are not installed; they are used instead of those that the dataset keeps."""
    trust_task_files: bool = False
    """Run the task files that the dataset keeps, where tasks are not installed. Read them first."""
