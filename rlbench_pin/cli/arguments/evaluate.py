"""What `rlbench-pin evaluate --controllers` takes."""

from __future__ import annotations

from dataclasses import dataclass

from rlbench_pin.cli.process.words import Controllers, MaybeInt, MaybePath, TaskNames

TASKS = (
    "reach_target", "push_button", "pick_and_lift", "take_lid_off_saucepan", "open_drawer",
    "close_microwave", "slide_block_to_target", "stack_blocks", "put_rubbish_in_bin", "meat_off_grill",
)  # fmt: skip
"""What is evaluated when no task is named."""


@dataclass(frozen=True)
class Evaluate:
    """Compare controllers on the motions of demonstrations: errors, limits, clearance, time."""

    controllers: bool = False
    """Evaluate the controllers of `rlbench_pin.control`."""
    tasks: TaskNames = TASKS
    """Task names, as `rlbench-pin list` prints them, with spaces or commas between them, `all`, or task files."""
    episodes: int = 1
    """Demonstrations of each task."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    legs: MaybeInt = None
    """Number of legs of each demonstration, from the first on; all when not given."""
    only: Controllers = ()
    """Controllers to compare; all when none is given."""
    json: MaybePath = None
    """File to write everything to."""
