"""`rlbench-pin train ppo|sac TASK...`: baselines that learn by trial."""

from __future__ import annotations

import importlib
import importlib.util
import threading
from collections.abc import Callable
from typing import Any

from tqdm import tqdm

from rlbench_pin.cli.arguments.evaluation import train_by_trial as arguments
from rlbench_pin.cli.list_tasks import named_tasks, split_names
from rlbench_pin.cli.process.files import check_file
from rlbench_pin.cli.process.interrupts import INTERRUPTED, say
from rlbench_pin.cli.process.words import check_at_least, checked_names
from rlbench_pin.cli.progress import stopping_gently
from rlbench_pin.errors import MissingExtra, TaskEnvironmentError

MODULE = "rlbench_pin.baselines.reinforcement"
PLOTS = "rlbench_pin.evaluation.results.plots"


def train_by_trial(command: arguments.ByTrial, algorithm: str) -> int:
    """Train one model after the other; 130 when it was interrupted.

    Args:
        command: What the user typed.
        algorithm: `ppo` or `sac`.
    """
    usage = f"rlbench-pin train {algorithm} TASK..."
    tasks = named_tasks(checked_names(command.tasks, split_names, usage))
    check_at_least(command, steps=1, demonstrations=0, seed=0, workers=1, episode_steps=1, leg=8)
    if not command.resume and (held := [task for task in tasks if (command.out / task).exists()]):
        raise TaskEnvironmentError(f"'{command.out / held[0]}' exists. Go on with --resume, or name another --out.")
    if importlib.util.find_spec("stable_baselines3") is None:
        raise MissingExtra(f"`rlbench-pin train {algorithm}`", "stable_baselines3", "rl")
    if command.plot is not None:
        importlib.import_module(PLOTS).check_plot(command.plot, len(tasks))
        check_file(command.plot)
    learning = importlib.import_module(MODULE)
    with stopping_gently() as stop:
        for task in tasks:
            if not _train(learning, command, algorithm, task, stop):
                say("The same command with --resume goes on.")
                return INTERRUPTED
    if command.plot is not None:
        curves = {f"{algorithm} {task}": learning.read_curve(command.out / task) for task in tasks}
        print(f"Learning curves in {learning.draw_curves(command.plot, curves)}")
    print(f"{len(tasks)} models in {command.out}; the policy is {algorithm}:{command.out}")
    return 0


def _train(learning: Any, command: arguments.ByTrial, algorithm: str, task: str, stop: threading.Event) -> bool:
    """Train one task and return whether it is finished."""
    config = learning.ReinforcementConfig(
        algorithm, task, steps=command.steps, shaped=command.shaped, demonstrations=command.demonstrations, seed=command.seed,
        workers=command.workers, device=command.device, episode_steps=command.episode_steps,
        leg_steps=command.leg,
    )  # fmt: skip
    with tqdm(total=config.legs * config.leg, unit="step", desc=f"{algorithm} {task}", dynamic_ncols=True) as bar:
        return bool(learning.train_reinforcement(config, command.out, _shows(bar), stop))


def _shows(bar: tqdm) -> Callable[[Any], None]:
    """Return what shows the steps, and of the last leg how often it succeeded."""

    def show(progress: Any) -> None:
        point = progress.point
        if progress.note:
            bar.set_postfix_str(progress.note)
        elif point is not None and point.success is not None:
            looked = "" if point.validation is None else f", {100.0 * point.validation:.0f} % without exploring"
            bar.set_postfix_str(f"success {100.0 * point.success:.0f} %{looked}", refresh=False)
        bar.update(progress.steps - bar.n)

    return show


class Ppo(arguments.Ppo):
    """The work of `rlbench-pin train ppo`."""

    def run(self) -> int:
        """Train."""
        return train_by_trial(self, "ppo")


class Sac(arguments.Sac):
    """The work of `rlbench-pin train sac`."""

    def run(self) -> int:
        """Train."""
        return train_by_trial(self, "sac")
