"""What `rlbench-pin list` takes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ListTasks:
    """List the tasks, each with a line about it.

    Those of other packages come last, with the package that brings them.
    """

    json: bool = False
    """Print JSON for programs."""
