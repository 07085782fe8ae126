"""Planning of single segments: every plan of the expert in all tasks, by method and by task. Run: `make bench`."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from harness import Result, main, summary, velocity_environment

from rlbench_pin.environment import SegmentReport
from rlbench_pin.environment.runtime import Listener
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.plan import Plan, PlanRequest
from rlbench_pin.tasks import task_names

SEEDS = 10


def benchmark(tasks: Sequence[str] = (), seeds: int = SEEDS) -> list[Result]:
    """Demonstrate each task and gather its segments and plans."""
    segments: dict[str, list[SegmentReport]] = {}
    recorder = PlanRecorder()
    for name in tasks or task_names():
        with velocity_environment() as environment:
            task = environment.get_task(name)
            with task.runtime.listening(recorder):
                outcomes = [task.try_demo(seed=s, variation=s % task.variation_count(), record=False) for s in range(seeds)]
            segments[name] = [segment for outcome in outcomes for segment in outcome.segments]
    return [*_by_task(segments), *_by_stage(recorder.plans)]


class PlanRecorder(Listener):
    """Keeps every plan to poses or along curves."""

    def __init__(self) -> None:
        self.plans: list[Plan] = []

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        """Keep a plan; one to a configuration only replaces one to its pose."""
        if isinstance(outcome, Plan) and request.kind != "configuration":
            self.plans.append(outcome)


def _by_task(segments: dict[str, list[SegmentReport]]) -> list[Result]:
    """Times of whole segments: all, by method, by task."""
    everything = [segment for of_task in segments.values() for segment in of_task]
    groups: dict[str, list[float]] = defaultdict(list)
    for segment in everything:
        groups[segment.method].append(segment.planning_time)
    rows = [("plan a segment, all tasks", [segment.planning_time for segment in everything])]
    rows += [(f"plan a segment, {method}", times) for method, times in sorted(groups.items())]
    rows += [(f"plan a segment, {name}", [segment.planning_time for segment in of_task]) for name, of_task in segments.items()]
    return [summary(name, times, f"{len(times)} segments") for name, times in rows if times]


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
