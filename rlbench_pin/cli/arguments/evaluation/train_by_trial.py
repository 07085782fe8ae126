"""What `rlbench-pin train ppo|sac TASK...` takes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import tyro

from rlbench_pin.cli.process.words import Device, MaybeInt, MaybePath, SomeTasks


@dataclass(frozen=True)
class ByTrial:
    """Arguments that both algorithms take."""

    tasks: tyro.conf.Positional[SomeTasks] = ()
    """Tasks to learn, one after the other, each with a model of its own."""
    steps: int = 20_000
    """Decisions of training for each task, 0.15 s each, rounded up to whole legs of about 2000 between check points. More prolong
    a training that is finished."""
    out: Path = Path("out/model")
    """Folder of the models, one for each task."""
    shaped: bool = False
    """Pay the task's own reward at each step, where it has one; otherwise 1 for success alone."""
    demonstrations: int = 0
    """Demonstrations that the planner makes first, so many: a first policy imitates them, and SAC keeps them in its buffer."""
    seed: int = 0
    """Seed of first weights, episodes, exploration and batches. On the CPU the same seed gives the same weights."""
    workers: int = 1
    """Environments at once, each in a process of its own when there are several. Another number is another training."""
    device: Device = "cpu"
    """Where torch computes: `cpu`, `cuda`, `cuda:1`."""
    episode_steps: MaybeInt = None
    """Decisions of a training episode at most; when not given, 30 for `reach_target` and 50 for others."""
    leg: int = 2048
    """Decisions between two check points; PPO learns once in each leg. Another number is another training."""
    plot: MaybePath = None
    """PNG or SVG file for the learning curves of all tasks; that of each is in its folder in any case."""
    resume: bool = False
    """Go on with what the folder holds."""


@dataclass(frozen=True)
class Ppo(ByTrial):
    """Learn by trial with PPO of Stable-Baselines3, from state; with demonstrations it begins as a policy that imitates them."""


@dataclass(frozen=True)
class Sac(ByTrial):
    """Learn by trial with SAC of Stable-Baselines3, from state; half of each batch comes from demonstrations, if any."""
