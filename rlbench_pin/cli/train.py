"""`rlbench-pin train`: train a baseline on recorded demonstrations or by reinforcement learning."""

from __future__ import annotations

import importlib
import importlib.util
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from rlbench_pin.cli.interrupts import INTERRUPTED, say
from rlbench_pin.cli.list_tasks import named_tasks, split_names
from rlbench_pin.cli.options import (
    Device,
    MaybeInt,
    MaybePath,
    OnlyCameras,
    OnlyTasks,
    SomeFolders,
    SomeTasks,
    check_at_least,
    check_file,
    checked_names,
)
from rlbench_pin.errors import MissingExtra, TaskEnvironmentError

if TYPE_CHECKING:
    from tqdm import tqdm

BASELINES = "rlbench_pin.baselines"
STEPS = {"cloning": (3000, 128, 1e-3), "key-frames": (1500, 8, 2e-3)}
"""Steps, examples in a batch, and learning rate of each baseline."""
MODULE = "rlbench_pin.baselines.reinforcement"
PLOTS = "rlbench_pin.evaluation.results.plots"


@dataclass(frozen=True)
class ReinforcementLearning:
    """Arguments of both algorithms."""

    tasks: tyro.conf.Positional[SomeTasks] = ()
    """Tasks to train, one after the other, each with its own model."""
    steps: int = 20_000
    """Number of training decisions for each task, 0.15 s each, rounded up to a multiple of `--checkpoint-steps`. A larger number
    continues a finished training."""
    out: Path = Path("out/model")
    """Folder of the models, one for each task."""
    shaped: bool = False
    """Use the shaped reward of the task, if it has one; otherwise the reward is 1 at success."""
    demonstrations: int = 0
    """Number of demonstrations that the planner makes first. The initial policy imitates them; SAC keeps them in its buffer."""
    seed: int = 0
    """Seed of initial weights, episodes, exploration and batches. On the CPU the same seed gives the same weights."""
    workers: int = 1
    """Number of parallel environments, each in its own process if there are several. The result depends on this number."""
    device: Device = "cpu"
    """Device of torch: `cpu`, `cuda`, `cuda:1`."""
    episode_steps: MaybeInt = None
    """Maximum number of decisions of a training episode; default 30 for `reach_target` and 50 for other tasks."""
    checkpoint_steps: int = 2048
    """Number of decisions between two checkpoints; PPO updates once per checkpoint. The result depends on this number."""
    plot: MaybePath = None
    """PNG or SVG file for the learning curves of all tasks; each task also has its own in its folder."""
    resume: bool = False
    """Continue the training in the folder."""


@dataclass(frozen=True)
class Ppo(ReinforcementLearning):
    """Reinforcement learning from state with PPO of Stable-Baselines3, starting from an imitation of demonstrations, if any."""

    def run(self) -> int:
        """Train."""
        return train_rl(self, "ppo")


@dataclass(frozen=True)
class Sac(ReinforcementLearning):
    """Reinforcement learning from state with SAC of Stable-Baselines3; half of each batch comes from demonstrations, if any."""

    def run(self) -> int:
        """Train."""
        return train_rl(self, "sac")


@dataclass(frozen=True)
class FromDemonstrations:
    """Arguments of the baselines that learn from recorded demonstrations."""

    data: tyro.conf.Positional[SomeFolders] = ()
    """Folders of datasets. `key-frames` needs no stored images, because it replays the demonstrations."""
    out: Path = Path("out/model")
    """Folder of the models, one for each task."""
    tasks: OnlyTasks = ()
    """Tasks to train; default: all tasks of the datasets."""
    demos: int = -1
    """Number of demonstrations of each task, spread over its variations; -1 is all."""
    steps: MaybeInt = None
    """Number of batches for each task. Default: 3000 of 128 ticks (cloning), or 1500 of 8 point clouds (key-frames)."""
    seed: int = 0
    """Seed of initial weights, batches and augmentation. On the CPU the same seed gives the same files."""
    device: Device = "cpu"
    """Device of torch: `cpu`, `cuda`, `cuda:1`."""
    resume: bool = False
    """Continue the training in the folder."""


@dataclass(frozen=True)
class Cloning(FromDemonstrations):
    """Learn joint commands from recorded demonstrations, from state or images."""

    cameras: OnlyCameras = ()
    """Cameras whose images replace the state of the task as input."""

    def run(self) -> int:
        """Train."""
        return train_on_demonstrations(self, "cloning", cameras=self.cameras)


@dataclass(frozen=True)
class KeyFrames(FromDemonstrations):
    """Learn tip poses from recorded demonstrations, from point clouds of four cameras."""

    def run(self) -> int:
        """Train."""
        return train_on_demonstrations(self, "key-frames")


@dataclass(frozen=True)
class Train:
    """Train a baseline, on demonstrations or by reinforcement learning. Use `--resume` to continue after an interruption."""

    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[Cloning, tyro.conf.subcommand("cloning")]
        | Annotated[KeyFrames, tyro.conf.subcommand("key-frames")]
        | Annotated[Ppo, tyro.conf.subcommand("ppo")]
        | Annotated[Sac, tyro.conf.subcommand("sac")]
    ] = field()
    """The baseline."""

    def run(self) -> int:
        """Run the subcommand."""
        return self.action.run()


def train_on_demonstrations(command: FromDemonstrations, baseline: str, **options: Any) -> int:
    """Train one model after the other; return 130 after an interruption.

    Args:
        command: The arguments of the command.
        baseline: A key of `STEPS`.
        options: Further arguments of the training.
    """
    from rlbench_pin.cli.progress import stopping_gently
    from rlbench_pin.datasets import chosen_tasks, stored_tasks

    if not command.data:
        raise TaskEnvironmentError(f"No dataset was named. Use `rlbench-pin train {baseline} DATA...`.")
    check_at_least(command, demos=-1, seed=0, steps=1)
    if command.demos == 0:
        raise TaskEnvironmentError("--demos is 0; it must be at least 1, or -1 for all.")
    stored = {task: root for root in reversed(command.data) for task in stored_tasks(root, at_least_one=True)}
    tasks = chosen_tasks(command.data[0], tuple(sorted(stored)), named_tasks(command.tasks) if command.tasks else ())
    if not command.resume and any((command.out / task).exists() for task in tasks):
        raise TaskEnvironmentError(f"'{command.out}' contains models already. Continue with --resume, or name another --out.")
    with stopping_gently() as stop:
        for task in tasks:
            if not _train_on_demonstrations(command, baseline, task, stop, options):
                say("Use the same command with --resume to continue.")
                return INTERRUPTED
    name = baseline.replace("-", "_")
    print(f"{len(tasks)} models in {command.out}; the policy is {BASELINES}.{name}:policy?folder={command.out}")
    return 0


def _train_on_demonstrations(
    command: FromDemonstrations, baseline: str, task: str, stop: threading.Event, options: dict[str, Any]
) -> bool:
    """Train one task and return whether it is finished."""
    from rlbench_pin.cli.bars import progress_bar

    steps, batch, rate = STEPS[baseline]
    cloning = importlib.import_module(f"{BASELINES}.cloning")
    config = cloning.TrainConfig(steps=command.steps or steps, batch=batch, rate=rate, seed=command.seed, device=command.device)
    with progress_bar(total=config.steps, unit="step", desc=task) as bar:
        options = {"demos": command.demos, "on_step": _show_loss(bar), "stop": stop, **options}
        roots: list[Path] = list(command.data)
        if baseline == "cloning":
            return bool(cloning.train_cloning(roots, task, command.out, config, **options))
        options["on_demo"] = lambda done, total: bar.set_postfix_str(f"demonstration {done} of {total}")
        module = importlib.import_module(f"{BASELINES}.key_frames")
        return bool(module.train_key_frames(roots, task, command.out, config, **options))


def _show_loss(bar: tqdm) -> Callable[[int, float], None]:
    def show(step: int, loss: float) -> None:
        bar.set_postfix_str(f"loss {loss:.3f}", refresh=False)
        bar.update(step - bar.n)

    return show


def train_rl(command: ReinforcementLearning, algorithm: str) -> int:
    """Train one model after the other; return 130 after an interruption.

    Args:
        command: The arguments of the command.
        algorithm: `ppo` or `sac`.
    """
    from rlbench_pin.cli.progress import stopping_gently

    usage = f"rlbench-pin train {algorithm} TASK..."
    tasks = named_tasks(checked_names(command.tasks, split_names, usage))
    check_at_least(command, steps=1, demonstrations=0, seed=0, workers=1, episode_steps=1, checkpoint_steps=8)
    if not command.resume and (held := [task for task in tasks if (command.out / task).exists()]):
        raise TaskEnvironmentError(f"'{command.out / held[0]}' exists already. Continue with --resume, or name another --out.")
    if importlib.util.find_spec("stable_baselines3") is None:
        raise MissingExtra(f"`rlbench-pin train {algorithm}`", "stable_baselines3", "rl")
    if command.plot is not None:
        importlib.import_module(PLOTS).check_plot(command.plot, len(tasks))
        check_file(command.plot)
    learning = importlib.import_module(MODULE)
    with stopping_gently() as stop:
        for task in tasks:
            if not _train_rl(learning, command, algorithm, task, stop):
                say("Use the same command with --resume to continue.")
                return INTERRUPTED
    if command.plot is not None:
        curves = {f"{algorithm} {task}": learning.read_curve(command.out / task) for task in tasks}
        print(f"Learning curves in {learning.draw_curves(command.plot, curves)}")
    print(f"{len(tasks)} models in {command.out}; the policy is {algorithm}:{command.out}")
    return 0


def _train_rl(learning: Any, command: ReinforcementLearning, algorithm: str, task: str, stop: threading.Event) -> bool:
    """Train one task and return whether it is finished."""
    from rlbench_pin.cli.bars import progress_bar

    config = learning.ReinforcementConfig(
        algorithm, task, steps=command.steps, shaped=command.shaped, demonstrations=command.demonstrations, seed=command.seed,
        workers=command.workers, device=command.device, episode_steps=command.episode_steps,
        checkpoint_steps=command.checkpoint_steps,
    )  # fmt: skip
    with progress_bar(total=config.segments * config.segment, unit="step", desc=f"{algorithm} {task}") as bar:
        return bool(learning.train_reinforcement(config, command.out, _show_success(bar), stop))


def _show_success(bar: tqdm) -> Callable[[Any], None]:
    """Return a callback that shows the steps, and the success rate since the last checkpoint."""

    def show(progress: Any) -> None:
        point = progress.point
        if progress.note:
            bar.set_postfix_str(progress.note)
        elif point is not None and point.success is not None:
            looked = "" if point.validation is None else f", {100.0 * point.validation:.0f} % without exploration"
            bar.set_postfix_str(f"success {100.0 * point.success:.0f} %{looked}", refresh=False)
        bar.update(progress.steps - bar.n)

    return show
