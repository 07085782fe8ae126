"""What `rlbench-pin check TASK...` takes."""

from __future__ import annotations

from dataclasses import dataclass

import tyro

from rlbench_pin.cli.process.words import AnyTasks, Files, MaybePath


@dataclass(frozen=True)
class Check:
    """Judge tasks: demonstrations succeed and replay, resets repeat and rest, doing nothing and random actions solve nothing."""

    tasks: tyro.conf.Positional[AnyTasks] = ()
    """Task names, as `rlbench-pin list` prints them, or task files, with spaces or commas between; all when none is given."""
    task_file: Files = ()
    """Task files outside the package, each with its scene file beside it."""
    episodes: int = 30
    """Demonstrations of each task, spread over its variations."""
    variations: int = 20
    """Number of variations of a task to test, at most."""
    replays: int = 50
    """Demonstrations whose recorded actions are played again, the first ones of a task."""
    key_frames: int = 10
    """Demonstrations whose key frames alone (where the arm rests or the fingers move) are executed through planning."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    unseen: int = 0
    """Further demonstrations of each task on other seeds, which count apart."""
    unseen_seed: int = 5000
    """First of those seeds."""
    contract: bool = True
    """Also judge instructions, resets, doing nothing, random actions, and what the arm reaches."""
    contract_seeds: int = 5
    """Seeds of the episodes that do nothing, and of those with random actions."""
    placements: int = 100
    """Places of the task from which to try every waypoint."""
    max_attempts: int = 10
    """Tries for each demonstration."""
    workers: int = 1
    """Processes; the result does not depend on their number."""
    explain: bool = False
    """Play the first try of each cause of failure again: print its evidence and draw the world into `explain` below `--out`
    (`out/explain` without it)."""
    json: MaybePath = None
    """File to write the whole report to."""
    out: MaybePath = None
    """Folder for the whole report: report.md with its pictures, report.json, and trials.jsonl, with which the same command
    continues where it was stopped."""
    pictures: bool = True
    """With `--out`: draw a contact sheet and a reach map of each task into it."""
