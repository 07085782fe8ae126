"""`rlbench-pin train cloning|key-frames DATA...`: baselines that learn from demonstrations."""

from __future__ import annotations

import importlib
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tqdm import tqdm

from rlbench_pin.cli.arguments.evaluation import train as arguments
from rlbench_pin.cli.list_tasks import named_tasks
from rlbench_pin.cli.process.interrupts import INTERRUPTED, say
from rlbench_pin.cli.process.words import check_at_least
from rlbench_pin.cli.progress import stopping_gently
from rlbench_pin.datasets import chosen_tasks, stored_tasks
from rlbench_pin.errors import TaskEnvironmentError

BASELINES = "rlbench_pin.evaluation.baselines"
STEPS = {"cloning": (3000, 128, 1e-3), "key-frames": (1500, 8, 2e-3)}
"""Steps, examples in a batch, and learning rate of each baseline."""


class Train(arguments.Train):
    """The work of `rlbench-pin train`."""

    def run(self) -> int:
        """Train one model after the other; 130 when it was interrupted."""
        if not self.data:
            raise TaskEnvironmentError("No dataset was named. Use `rlbench-pin train cloning DATA...`.")
        if self.cameras and self.baseline != "cloning":
            raise TaskEnvironmentError("--cameras goes with `cloning`; `key-frames` looks with all five.")
        check_at_least(self, demos=-1, seed=0, steps=1)
        if self.demos == 0:
            raise TaskEnvironmentError("--demos is 0; it must be at least 1, or -1 for all.")
        tasks = self._tasks()
        if not self.resume and any((self.out / task).exists() for task in tasks):
            raise TaskEnvironmentError(f"'{self.out}' holds models already. Go on with --resume, or name another --out.")
        with stopping_gently() as stop:
            for task in tasks:
                if not self._train(task, stop):
                    say("The same command with --resume goes on.")
                    return INTERRUPTED
        name = self.baseline.replace("-", "_")
        print(f"{len(tasks)} models in {self.out}; the policy is {BASELINES}.{name}:policy?folder={self.out}")
        return 0

    def _tasks(self) -> tuple[str, ...]:
        stored = {task: root for root in reversed(self.data) for task in stored_tasks(root, at_least_one=True)}
        return chosen_tasks(self.data[0], tuple(sorted(stored)), named_tasks(self.tasks) if self.tasks else ())

    def _train(self, task: str, stop: threading.Event) -> bool:
        """Train one task and return whether it is finished."""
        steps, batch, rate = STEPS[self.baseline]
        cloning = importlib.import_module(f"{BASELINES}.cloning")
        config = cloning.TrainConfig(steps=self.steps or steps, batch=batch, rate=rate, seed=self.seed, device=self.device)
        with tqdm(total=config.steps, unit="step", desc=task, dynamic_ncols=True) as bar:
            options: dict[str, Any] = {"demos": self.demos, "on_step": _shows(bar), "stop": stop}
            roots: list[Path] = list(self.data)
            if self.baseline == "cloning":
                return bool(cloning.train_cloning(roots, task, self.out, config, cameras=self.cameras, **options))
            options["on_demo"] = lambda done, total: bar.set_postfix_str(f"demonstration {done} of {total}")
            module = importlib.import_module(f"{BASELINES}.key_frames")
            return bool(module.train_key_frames(roots, task, self.out, config, **options))


def _shows(bar: tqdm) -> Callable[[int, float], None]:
    def show(step: int, loss: float) -> None:
        bar.set_postfix_str(f"loss {loss:.3f}", refresh=False)
        bar.update(step - bar.n)

    return show
