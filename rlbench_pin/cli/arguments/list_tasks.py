"""What `rlbench-pin list` takes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ListTasks:
    """List the tasks, each with a line about it.

    Those of other packages come last, with the package that brings them.
    """

    sets: bool = False
    """List the sets of tasks instead, each with how many of its tasks are built."""
    json: bool = False
    """Print JSON for programs."""
