"""What `rlbench-pin train BASELINE DATA...` takes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from rlbench_pin.cli.process.words import Device, MaybeInt, OnlyCameras, OnlyTasks, SomeFolders

Baseline = Annotated[Literal["cloning", "key-frames"], tyro.conf.arg(help_behavior_hint="(required)")]


@dataclass(frozen=True)
class Train:
    """Train a baseline on recorded demonstrations. Whatever kills it, `--resume` goes on."""

    baseline: tyro.conf.Positional[Baseline]
    """`cloning`: joint commands from state or pictures; `key-frames`: tip poses from point clouds."""
    data: tyro.conf.Positional[SomeFolders] = ()
    """Folders of datasets. `key-frames` needs no stored pictures: it plays the demonstrations again."""

    out: Path = Path("out/model")
    """Folder of the models, one for each task."""
    tasks: OnlyTasks = ()
    """Tasks to train; all of the datasets when none is named."""
    demos: int = -1
    """Demonstrations of each task, spread over its variations; -1 is all."""
    cameras: OnlyCameras = ()
    """With `cloning`: cameras to learn from in place of the state of the task."""
    steps: MaybeInt = None
    """Batches for each task; when not given, 3000 of 128 ticks, or 1500 of 8 clouds."""
    seed: int = 0
    """Seed of first weights, batches and augmentation. On the CPU the same seed gives the same files."""
    device: Device = "cpu"
    """Where torch computes: `cpu`, `cuda`, `cuda:1`."""
    resume: bool = False
    """Go on with what the folder holds."""
