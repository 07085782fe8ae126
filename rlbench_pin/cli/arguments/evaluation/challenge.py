"""What `rlbench-pin challenge run|splits` takes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from rlbench_pin.cli.process.words import EngineName, MaybeInt, MaybePath, OnlyTasks, RobotName

LearnerName = Annotated[str, tyro.conf.arg(metavar="LEARNER", help_behavior_hint="(required)")]
"""A learner behind a command, which says in its own words that it needs one."""
Shots = Annotated[tuple[int, ...], tyro.conf.arg(metavar="INT...")]
"""Numbers of demonstrations."""
SplitName = Annotated[str, tyro.conf.arg(metavar="SPLIT")]
"""A split of the challenge."""


@dataclass(frozen=True)
class Run:
    """Let a few-shot learner take the challenge. Use `--resume` to continue after an interruption.

    The folder gets a results file for each number of demonstrations, `shots_5.json`, which `rlbench-pin results` shows and
    compares, the learning curve, `summary.json`, and the demonstrations with their seeds.
    """

    learner: tyro.conf.Positional[LearnerName] = ""
    """`nearest`, `module:factory` or `file.py:factory`. docs/challenge.md says how to write one."""
    shots: Shots = (1, 5, 20)
    """Numbers of demonstrations of each test task."""
    split: SplitName = "V1"
    """Which tasks are trained and tested on: V1, FS10_V1, FS25_V1, FS50_V1 or FS95_V1."""
    tasks: OnlyTasks = ()
    """Only these test tasks, with spaces or commas between them."""
    available: bool = False
    """Leave out the tasks that are not built."""
    episodes: int = 25
    """Episodes of each test task, spread evenly over its variations; the same for each number of demonstrations."""
    seed: int = 0
    """Seed of the episodes, as for `evaluate`, and of the demonstrations."""
    secret: MaybePath = None
    """File with a secret of at least 16 bytes, mixed into the seeds of episodes and demonstrations.
    Results record its SHA-256. Publish the file when the challenge is over."""
    max_steps: MaybeInt = None
    """Actions of an episode at most; when not given, what the learner suggests or `evaluate` would take."""
    max_seconds: float = 120.0
    """Simulated time of an episode at most [s]."""
    time_limit: float = 30.0
    """Time that the policy has for one action [s], by the clock on the wall."""
    start_limit: float = 300.0
    """Time that the learner has to start [s]."""
    adapt_limit: float = 3600.0
    """Time that the learner has to adapt to a task [s]."""
    train_limit: float = 1e6
    """Time that the learner has to practise the tasks of the training [s]."""
    robot: RobotName = "panda"
    """Name of the arm."""
    workers: int = 1
    """Worker processes, each with a learner of its own; with 0 this process does the work."""
    engine: EngineName = "processes"
    """What does the work: processes of this machine, or a Ray cluster."""
    out: Path = Path("out/challenge")
    """Folder of the run."""
    resume: bool = False
    """Go on with a run that did not end."""


@dataclass(frozen=True)
class Splits:
    """List the splits of the challenge, and how many of their tasks are built."""

    json: bool = False
    """Print JSON for programs, with the names of all tasks."""


@dataclass(frozen=True)
class Challenge:
    """The few-shot challenge: a learner meets unseen tasks with 1, 5 and 20 demonstrations of each, and nothing else."""

    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[Run, tyro.conf.subcommand("run")] | Annotated[Splits, tyro.conf.subcommand("splits")]
    ] = field()
    """What to do."""
