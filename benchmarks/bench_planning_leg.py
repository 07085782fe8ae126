"""How long planning one leg of a demonstration takes, by method and task, and how the time divides; TOPPRA per path among it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from harness import Result, main, summary, velocity_environment

from rlbench_pin.environment import LegReport
from rlbench_pin.environment.runtime import Listener
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.listener import PlanRequest
from rlbench_pin.planning.plan import Plan
from rlbench_pin.tasks import task_names

SEEDS = 10


def benchmark(tasks: Sequence[str] = (), seeds: int = SEEDS) -> list[Result]:
    """Demonstrate each task and gather its legs and plans."""
    legs: dict[str, list[LegReport]] = {}
    recorder = PlanRecorder()
    for name in tasks or task_names():
        with velocity_environment() as environment:
            task = environment.get_task(name)
            with task.runtime.listening(recorder):
                outcomes = [task.try_demo(seed=s, variation=s % task.variation_count(), record=False) for s in range(seeds)]
            legs[name] = [leg for outcome in outcomes for leg in outcome.legs]
    return [*_by_task(legs), *_by_stage(recorder.plans)]


class PlanRecorder(Listener):
    """Keeps every plan to poses or along curves."""

    def __init__(self) -> None:
        self.plans: list[Plan] = []

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        """Keep a plan; one to a configuration only replaces one to its pose."""
        if isinstance(outcome, Plan) and request.kind != "configuration":
            self.plans.append(outcome)


def _by_task(legs: dict[str, list[LegReport]]) -> list[Result]:
    """Times of whole legs: all, by method, by task."""
    everything = [leg for of_task in legs.values() for leg in of_task]
    groups: dict[str, list[float]] = defaultdict(list)
    for leg in everything:
        groups[leg.method].append(leg.planning_time)
    rows = [("plan a leg, all tasks", [leg.planning_time for leg in everything])]
    rows += [(f"plan a leg, {method}", times) for method, times in sorted(groups.items())]
    rows += [(f"plan a leg, {name}", [leg.planning_time for leg in of_task]) for name, of_task in legs.items()]
    return [summary(name, times, f"{len(times)} legs") for name, times in rows if times]


def _by_stage(plans: Sequence[Plan]) -> list[Result]:
    """Times of the stages of a plan; `retime` is TOPPRA."""
    stages: dict[str, list[float]] = defaultdict(list)
    for plan in plans:
        for stage, seconds in plan.report.seconds.items():
            stages[stage].append(seconds)
    total = sum(map(sum, stages.values()))
    return [summary(f"  stage {s}", times, f"{sum(times) / total:.0%} of all planning") for s, times in stages.items()]


if __name__ == "__main__":
    main(__doc__, benchmark)
