"""What `rlbench-pin train cloning|key-frames DATA...` takes, and `rlbench-pin train` as a whole."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from rlbench_pin.cli.arguments.evaluation.train_by_trial import Ppo, Sac
from rlbench_pin.cli.process.words import Device, MaybeInt, OnlyCameras, OnlyTasks, SomeFolders


@dataclass(frozen=True)
class Cloning:
    """Learn joint commands from recorded demonstrations, from state or pictures."""

    data: tyro.conf.Positional[SomeFolders] = ()
    """Folders of datasets."""
    out: Path = Path("out/model")
    """Folder of the models, one for each task."""
    tasks: OnlyTasks = ()
    """Tasks to train; all of the datasets when none is named."""
    demos: int = -1
    """Demonstrations of each task, spread over its variations; -1 is all."""
    cameras: OnlyCameras = ()
    """Cameras to learn from in place of the state of the task."""
    steps: MaybeInt = None
    """Batches of 128 ticks for each task; 3000 when not given."""
    seed: int = 0
    """Seed of first weights, batches and augmentation. On the CPU the same seed gives the same files."""
    device: Device = "cpu"
    """Where torch computes: `cpu`, `cuda`, `cuda:1`."""
    resume: bool = False
    """Go on with what the folder holds."""


@dataclass(frozen=True)
class KeyFrames:
    """Learn tip poses from recorded demonstrations, from point clouds of five cameras."""

    data: tyro.conf.Positional[SomeFolders] = ()
    """Folders of datasets; stored pictures are not needed: the demonstrations are played again."""
    out: Path = Path("out/model")
    """Folder of the models, one for each task."""
    tasks: OnlyTasks = ()
    """Tasks to train; all of the datasets when none is named."""
    demos: int = -1
    """Demonstrations of each task, spread over its variations; -1 is all."""
    steps: MaybeInt = None
    """Batches of 8 clouds for each task; 1500 when not given."""
    seed: int = 0
    """Seed of first weights, batches and augmentation. On the CPU the same seed gives the same files."""
    device: Device = "cpu"
    """Where torch computes: `cpu`, `cuda`, `cuda:1`."""
    resume: bool = False
    """Go on with what the folder holds."""


@dataclass(frozen=True)
class Train:
    """Train a baseline, on demonstrations or by trial. Whatever kills it, `--resume` goes on."""

    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[Cloning, tyro.conf.subcommand("cloning")]
        | Annotated[KeyFrames, tyro.conf.subcommand("key-frames")]
        | Annotated[Ppo, tyro.conf.subcommand("ppo")]
        | Annotated[Sac, tyro.conf.subcommand("sac")]
    ] = field()
    """Which baseline."""
