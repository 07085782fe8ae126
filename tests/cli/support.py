"""What the tests of commands share."""

from __future__ import annotations

from rlbench_pin.cli.main import main

TASK = "reach_target"
RECORD = ("record", TASK, "--workers", "0", "--products")
"""Records episodes of `TASK` without images, in this process."""


def exit_code(*arguments: str) -> int:
    """Run a command as a user types it and return its exit code."""
    try:
        return main(arguments)
    except SystemExit as stop:
        return int(stop.code or 0)
