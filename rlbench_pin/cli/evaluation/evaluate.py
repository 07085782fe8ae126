"""`rlbench-pin evaluate POLICY`: episodes by as many processes as there are cores, a results file, films of failures."""

from __future__ import annotations

import math
import shlex
import sys
from contextlib import closing

from rlbench_pin.cli.arguments.evaluation import evaluate as arguments
from rlbench_pin.cli.arguments.evaluation.evaluate import Comparison
from rlbench_pin.cli.evaluation.bar import EvaluationBar
from rlbench_pin.cli.evaluation.controllers import ControllerComparison
from rlbench_pin.cli.evaluation.failure_films import film_failures
from rlbench_pin.cli.evaluation.watching import watched
from rlbench_pin.cli.list_tasks import split_names
from rlbench_pin.cli.process.engines import make_engine
from rlbench_pin.cli.process.files import check_file
from rlbench_pin.cli.process.interrupts import INTERRUPTED
from rlbench_pin.cli.process.words import check_at_least, checked_names
from rlbench_pin.cli.progress import stopping_gently
from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.evaluation.results.records import EpisodeRecord, Results
from rlbench_pin.evaluation.run import EvaluationConfig, EvaluationStopped, evaluate
from rlbench_pin.evaluation.sets import resolve_tasks
from rlbench_pin.processes import Engine, SerialEngine
from rlbench_pin.rates import Rate

EPISODES = 25
"""Episodes of each task, when not said otherwise."""


class Evaluate(arguments.Evaluate):
    """The work of `rlbench-pin evaluate`."""

    def run(self) -> int:
        """Evaluate a policy, or compare controllers; 130 when it was stopped."""
        comparison = self.comparison
        if self.policy and comparison.controllers:
            print("rlbench-pin evaluate: name a policy, or `--controllers`, not both.", file=sys.stderr)
            return 2
        if comparison.controllers:
            episodes = 1 if self.episodes is None else self.episodes
            legs, only, json = comparison.legs, comparison.only, comparison.json
            return ControllerComparison(self.tasks, episodes, self.seed, legs, only, json).run()
        if not self.policy:
            hint = "such as `rlbench-pin evaluate expert`, or `--controllers`"
            print(f"rlbench-pin evaluate: say what to evaluate, a policy, {hint}.", file=sys.stderr)
            return 2
        return self._evaluate()

    def _evaluate(self) -> int:
        check_at_least(self, workers=0, films=0)
        config = self.config()
        check_file(self.out)
        engine, page = self._engine(), watched(self.page, self.policy)
        with page as make, stopping_gently() as stop, closing(EvaluationBar(self.policy)) as bar:
            try:
                results = evaluate(
                    config, self.out, engine=engine, resume=self.resume, on_progress=bar, stop=stop, make_runner=make
                )
            except EvaluationStopped as stopped:
                bar.close()
                print(f"{stopped.done} of {stopped.wanted} episodes are played. Go on with:  {self.go_on()}", file=sys.stderr)
                return INTERRUPTED
        print(summary(results))
        print(f"Results in {self.out}; `rlbench-pin results {shlex.quote(str(self.out))}` shows all of them.")
        if self.films:
            folder = self.out.with_name(f"{self.out.stem}_films")
            for film in film_failures(config, results, self.films, folder):
                print(f"  film  {film}")
        return 0

    def _engine(self) -> Engine:
        if not self.page.live:
            return make_engine(self.engine, self.workers)
        if self.workers > 1 or self.engine != "processes":
            raise TaskEnvironmentError("--live shows the episodes that one process plays. Leave out --workers and --engine.")
        return SerialEngine()

    def config(self) -> EvaluationConfig:
        """Return what is to be evaluated.

        Raises:
            MissingTasks: A set has tasks that are not built.
            UnknownName: There is no such task or set.
        """
        words = checked_names(self.tasks, split_names, "rlbench-pin evaluate POLICY --tasks TASK...")
        return EvaluationConfig(
            policy=self.policy,
            tasks=resolve_tasks(words, self.available),
            task_set=" ".join(words),
            episodes=EPISODES if self.episodes is None else self.episodes,
            seed=self.seed,
            max_steps=self.max_steps,
            max_seconds=self.max_seconds,
            variations=self.variations,
            time_limit=self.time_limit,
            start_limit=self.start_limit,
            robot=self.robot,
            tell_task=self.tell_task,
        )

    def go_on(self) -> str:
        """Return the command that goes on where this one was stopped."""
        words = sys.argv[1:]
        if words[:1] != ["evaluate"]:  # called from a program
            words = ["evaluate", self.policy, "--out", str(self.out), "--tasks", *self.tasks]
        return shlex.join(["rlbench-pin", *words, *([] if "--resume" in words else ["--resume"])])


def summary(results: Results) -> str:
    """Return a line for each task: rate of success with its interval, held successes, faults; and the mean of the tasks."""
    width = max(len(task) for task in (*results.tasks, "mean"))
    lines = [f"{'task':<{width}}  success        95 %         held  refused  collisions  faults"]
    lines += [_line(task, width, results.of_task(task)) for task in results.tasks]
    means = [Rate(sum(e.success for e in some), len(some)).value for some in map(results.of_task, results.tasks)]
    return "\n".join([*lines, f"{'mean':<{width}}  {100.0 * math.fsum(means) / len(means):5.1f} %"])


def _line(task: str, width: int, episodes: tuple[EpisodeRecord, ...]) -> str:
    rate = Rate(sum(e.success for e in episodes), len(episodes))
    low, high = (100.0 * bound for bound in rate.interval)
    refused, touched = sum(sum(e.refused.values()) for e in episodes), sum(e.collisions for e in episodes)
    return (
        f"{task:<{width}}  {100.0 * rate.value:5.1f} %  {low:5.1f} to {high:5.1f} %  {sum(e.lasts for e in episodes):>6}"
        f"  {refused:>7}  {touched:>10}  {sum(bool(e.fault) for e in episodes):>6}"
    )


__all__ = ["Comparison", "Evaluate", "summary"]
