"""`rlbench-pin train`: baselines that learn, here those from recorded demonstrations."""

from __future__ import annotations

import importlib
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tqdm import tqdm

from rlbench_pin.cli.arguments.evaluation import train as arguments
from rlbench_pin.cli.list_tasks import named_tasks
from rlbench_pin.cli.process.commands import Subcommand
from rlbench_pin.cli.process.interrupts import INTERRUPTED, say
from rlbench_pin.cli.process.words import check_at_least
from rlbench_pin.cli.progress import stopping_gently
from rlbench_pin.datasets import chosen_tasks, stored_tasks
from rlbench_pin.errors import TaskEnvironmentError

BASELINES = "rlbench_pin.baselines"
STEPS = {"cloning": (3000, 128, 1e-3), "key-frames": (1500, 8, 2e-3)}
"""Steps, examples in a batch, and learning rate of each baseline."""
FromDemonstrations = arguments.Cloning | arguments.KeyFrames
"""Commands that learn from recorded demonstrations."""


class Train(arguments.Train):
    """The work of `rlbench-pin train`."""

    def run(self) -> int:
        """Do it."""
        assert isinstance(self.action, Subcommand)
        return self.action.run()


class Cloning(arguments.Cloning):
    """The work of `rlbench-pin train cloning`."""

    def run(self) -> int:
        """Train."""
        return train_on_demonstrations(self, "cloning", cameras=self.cameras)


class KeyFrames(arguments.KeyFrames):
    """The work of `rlbench-pin train key-frames`."""

    def run(self) -> int:
        """Train."""
        return train_on_demonstrations(self, "key-frames")


def train_on_demonstrations(command: FromDemonstrations, baseline: str, **options: Any) -> int:
    """Train one model after the other; 130 when it was interrupted.

    Args:
        command: What the user typed.
        baseline: A key of `STEPS`.
        options: Further arguments of what trains.
    """
    if not command.data:
        raise TaskEnvironmentError(f"No dataset was named. Use `rlbench-pin train {baseline} DATA...`.")
    check_at_least(command, demos=-1, seed=0, steps=1)
    if command.demos == 0:
        raise TaskEnvironmentError("--demos is 0; it must be at least 1, or -1 for all.")
    stored = {task: root for root in reversed(command.data) for task in stored_tasks(root, at_least_one=True)}
    tasks = chosen_tasks(command.data[0], tuple(sorted(stored)), named_tasks(command.tasks) if command.tasks else ())
    if not command.resume and any((command.out / task).exists() for task in tasks):
        raise TaskEnvironmentError(f"'{command.out}' holds models already. Go on with --resume, or name another --out.")
    with stopping_gently() as stop:
        for task in tasks:
            if not _train(command, baseline, task, stop, options):
                say("The same command with --resume goes on.")
                return INTERRUPTED
    name = baseline.replace("-", "_")
    print(f"{len(tasks)} models in {command.out}; the policy is {BASELINES}.{name}:policy?folder={command.out}")
    return 0


def _train(command: FromDemonstrations, baseline: str, task: str, stop: threading.Event, options: dict[str, Any]) -> bool:
    """Train one task and return whether it is finished."""
    steps, batch, rate = STEPS[baseline]
    cloning = importlib.import_module(f"{BASELINES}.cloning")
    config = cloning.TrainConfig(steps=command.steps or steps, batch=batch, rate=rate, seed=command.seed, device=command.device)
    with tqdm(total=config.steps, unit="step", desc=task, dynamic_ncols=True) as bar:
        options = {"demos": command.demos, "on_step": _shows(bar), "stop": stop, **options}
        roots: list[Path] = list(command.data)
        if baseline == "cloning":
            return bool(cloning.train_cloning(roots, task, command.out, config, **options))
        options["on_demo"] = lambda done, total: bar.set_postfix_str(f"demonstration {done} of {total}")
        module = importlib.import_module(f"{BASELINES}.key_frames")
        return bool(module.train_key_frames(roots, task, command.out, config, **options))


def _shows(bar: tqdm) -> Callable[[int, float], None]:
    def show(step: int, loss: float) -> None:
        bar.set_postfix_str(f"loss {loss:.3f}", refresh=False)
        bar.update(step - bar.n)

    return show
