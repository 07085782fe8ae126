"""What `rlbench-pin evaluate POLICY` and `rlbench-pin evaluate --controllers` take."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from rlbench_pin.cli.process.pages import PageOptions
from rlbench_pin.cli.process.words import Controllers, EngineName, MaybeInt, MaybePath, RobotName, TaskNames

TASKS = (
    "reach_target", "push_button", "pick_and_lift", "take_lid_off_saucepan", "open_drawer",
    "close_microwave", "slide_block_to_target", "stack_blocks", "put_rubbish_in_bin", "meat_off_grill",
)  # fmt: skip
"""What is evaluated when no task is named."""
MaybePolicy = Annotated[str, tyro.conf.arg(metavar="[POLICY]", help_behavior_hint="")]
"""A policy behind a command that can do without."""


@dataclass(frozen=True)
class Comparison:
    """Instead of a policy: the controllers of `rlbench_pin.control` on the motions of demonstrations."""

    controllers: bool = False
    """Compare the controllers: errors, limits, clearance, time; with `--tasks`, `--episodes` (1) and `--seed` (first seed)."""
    legs: MaybeInt = None
    """Number of legs of each demonstration, from the first on; all when not given."""
    only: Controllers = ()
    """Controllers to compare; all when none is given."""
    json: MaybePath = None
    """File to write the comparison to."""


@dataclass(frozen=True)
class Evaluate:
    """Evaluate a policy on tasks: success with its interval, collisions, limits. Whatever kills it, `--resume` goes on.

    The results file is the same to the byte, however many workers there are; `rlbench-pin results FILE...` shows and compares
    what is in it. The arguments that belong to controllers stand at the end.
    """

    policy: tyro.conf.Positional[MaybePolicy] = ""
    """`noop`, `random`, `expert` (the planner of demonstrations), `classical`, `cloning?folder=FOLDER`,
    `key_frames?folder=FOLDER`, `ppo:FOLDER`, `sac:FOLDER`, `sb3:FILE`, `lerobot:FOLDER`, `module:factory`,
    `file.py:factory`, or where one is served: `tcp://HOST:PORT`, `unix:PATH`. docs/policies.md says how to write one."""
    tasks: TaskNames = TASKS
    """Task names, task files, sets of tasks such as FS10_V1, or `all`, with spaces or commas between them."""
    available: bool = False
    """Leave out the tasks of a set that are not built."""
    episodes: MaybeInt = None
    """Episodes of each task, spread evenly over its variations; 25 when not given."""
    variations: int = -1
    """Number of variations of a task, at most; -1 is all."""
    seed: int = 0
    """Which stretch of the published seeds: episode i begins from 2^53 + 2 (seed + i), where no demonstration does."""
    max_steps: MaybeInt = None
    """Actions of an episode at most; when not given, what the policy suggests, else 25 where each plans a motion to a pose, else
    as many as the seconds hold."""
    max_seconds: float = 120.0
    """Simulated time of an episode at most [s]."""
    time_limit: float = 30.0
    """Time that the policy has for one action [s], by the clock on the wall. Taking longer costs the episode."""
    start_limit: float = 300.0
    """Time that the policy has to start [s]."""
    robot: RobotName = "panda"
    """Name of the arm."""
    tell_task: bool = True
    """Tell the policy the name of the task, beside the instruction."""
    workers: int = 1
    """Worker processes, each with a policy of its own; with 0 this process does the work."""
    engine: EngineName = "processes"
    """What does the work: processes of this machine, or a Ray cluster."""
    out: Path = Path("out/results.json")
    """The results file. Times go to a file beside it, and finished episodes to a journal until the last one is played."""
    resume: bool = False
    """Go on with an evaluation that did not end."""
    films: int = 0
    """Films of the first failures of each task, so many, played again after the evaluation, in a folder beside the results."""
    page: tyro.conf.OmitArgPrefixes[PageOptions] = field(default_factory=PageOptions)
    """Episodes as they are played, by this process, one after the other; the results are the same."""
    comparison: tyro.conf.OmitArgPrefixes[Comparison] = field(default_factory=Comparison)
    """Controllers instead of a policy."""
