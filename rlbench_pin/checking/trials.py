"""Run the items of a check, and return their trials."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from rlbench_pin.checking.plan import Item, Part
from rlbench_pin.checking.reach import reach_of
from rlbench_pin.checking.records import (
    RECORDS,
    Cost,
    DemoTrial,
    FailedAttempt,
    FrictionTrial,
    KeyFramesTrial,
    NoopTrial,
    RandomTrial,
    ReachTrial,
    RepeatTrial,
    SolvedDemo,
    Trial,
    UnseenTrial,
    WordsTrial,
)
from rlbench_pin.checking.validate import (
    demo_repeats,
    left_over,
    noop_episode,
    random_succeeds,
    reset_repeats,
    solved_by_other_plans,
)
from rlbench_pin.datasets import key_frame_actions
from rlbench_pin.environment import DemoOutcome, Environment, TaskEnvironment
from rlbench_pin.environment.episode import drawn_variations
from rlbench_pin.environment.presets import joint_position_mode, key_frame_mode, low_dim_config
from rlbench_pin.environment.replay import reaches_goal, replay_succeeds
from rlbench_pin.environment.runtime import Listener, Runtime
from rlbench_pin.errors import BoundaryError, InvalidActionError, PlanningError, ResetError
from rlbench_pin.planning.plan import Plan, PlanRequest
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.tasks import find_task

KEY_FRAME_TRIES = 3
"""Maximum number of attempts at a demonstration whose key frames are executed."""


class Stopwatch(Listener):
    """Adds up process time [s] by kind of work, while `watching` a runtime.

    Attributes:
        spent: Kind of work (`planning`, `physics`, `observing`) -> process time [s].
        total: Process time between entering and leaving `watching` [s].
        ticks: Control ticks simulated.
    """

    def __init__(self) -> None:
        self.spent = {"planning": 0.0, "physics": 0.0, "observing": 0.0}
        self.total = 0.0
        self.ticks = 0

    @contextmanager
    def watching(self, runtime: Runtime) -> Iterator[None]:
        with runtime.listening(self):
            began = time.process_time()
            try:
                yield
            finally:
                self.total += time.process_time() - began

    def on_update(self, snapshot: WorldSnapshot, seconds: float) -> None:
        self.spent["planning"] += seconds

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        self.spent["planning"] += seconds

    def on_reach(self, seconds: float) -> None:
        self.spent["planning"] += seconds

    def on_tick(self, seconds: float) -> None:
        self.spent["physics"] += seconds
        self.ticks += 1

    def on_observe(self, seconds: float) -> None:
        self.spent["observing"] += seconds


def work(item: Item) -> list[Trial]:
    """Run one item in a new environment, and return its trials."""
    name = find_task(item.task).get_name()
    try:
        with _environment(item.part, item.robot) as environment:
            task = environment.get_task(find_task(item.task))
            return list(_trials(task, item))
    except Exception as error:  # a user's task may raise anything; the report says what
        return [RECORDS[item.part](task=name, seed=seed, variation=0, error=_text(error)) for seed in item.seeds]


def _environment(part: Part, robot: str) -> Environment:
    """Return the environment of a part: actions are tip poses for key frames, joint positions for all others."""
    mode = key_frame_mode() if part == "key_frames" else joint_position_mode()
    attach = part != "friction_only"
    return Environment(mode, obs_config=low_dim_config(), robot_setup=robot, attach_grasped_objects=attach, seed=0)


def _trials(task: TaskEnvironment, item: Item) -> Iterator[Trial]:
    """Yield one trial for each seed of an item; for each variation of the task when the part is `words`."""
    if item.part == "words":
        for variation in range(task.variation_count()):
            yield _guarded(item.part, words_trial, task, variation, variation)
        return
    variations = drawn_variations(task.variation_count(), item.max_variations)
    for seed in item.seeds:
        index = seed - item.first_seed
        trial: Callable[[TaskEnvironment, int, int], Trial]
        if item.part in ("demos", "unseen"):
            kind = DemoTrial if item.part == "demos" else UnseenTrial
            trial = partial(demo_trial, max_attempts=item.max_attempts, replay=index < item.replays, kind=kind)
        else:
            trial = _TRIALS[item.part]
        yield _guarded(item.part, trial, task, seed, variations[index % len(variations)])


def _guarded(
    part: Part, trial: Callable[[TaskEnvironment, int, int], Trial], task: TaskEnvironment, seed: int, variation: int
) -> Trial:
    """Run a trial; errors of the task become part of its record."""
    record, name = RECORDS[part], task.get_name()
    try:
        return trial(task, seed, variation)
    except (ResetError, BoundaryError) as error:
        return record.without_start(name, seed, variation, f"reset: {error}")
    except Exception as error:  # a user's task may raise anything; the report says what
        return record(task=name, seed=seed, variation=variation, error=_text(error))


def _text(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def words_trial(task: TaskEnvironment, seed: int, variation: int) -> WordsTrial:
    instructions, _ = task.reset(seed=seed, variation=variation)
    return WordsTrial(task=task.get_name(), seed=seed, variation=variation, instructions=tuple(instructions))


def demo_trial(
    task: TaskEnvironment,
    seed: int,
    variation: int,
    max_attempts: int,
    replay: bool = True,
    kind: type[DemoTrial] = DemoTrial,
) -> DemoTrial:
    """Demonstrate one seed, check the next episode for differences, and with `replay` replay the recorded actions."""
    failed: list[FailedAttempt] = []
    demo = None
    for attempt in range(max_attempts):
        watch, began = Stopwatch(), time.perf_counter()
        with watch.watching(task.runtime):
            outcome = task.try_demo(seed=seed, variation=variation, attempt=attempt)
        wall = time.perf_counter() - began
        if outcome.demo is not None:
            demo = _solved(task, outcome, _cost(watch, wall), replay)
            break
        failed.append(FailedAttempt(outcome.cause, outcome.waypoint))
    again = solved_by_other_plans(task, seed, variation, max_attempts - 1) if failed else None
    return kind(task=task.get_name(), seed=seed, variation=variation, failed=tuple(failed), demo=demo, other_plans=again)


def _solved(task: TaskEnvironment, outcome: DemoOutcome, cost: Cost, replay: bool) -> SolvedDemo:
    demo = outcome.demo
    assert demo is not None
    stable = task.success_is_stable()
    remains = left_over(task, demo)
    return SolvedDemo(
        frames=len(demo),
        simulated=outcome.duration,
        replayed=replay_succeeds(task, demo) if replay else None,
        stable=stable,
        left_over=remains,
        segments=outcome.segments,
        cost=cost,
    )


def _cost(watch: Stopwatch, wall: float) -> Cost:
    return Cost(
        wall=wall,
        process=watch.total,
        planning=watch.spent["planning"],
        physics=watch.spent["physics"],
        observing=watch.spent["observing"],
        ticks=watch.ticks,
    )


def repeat_trial(task: TaskEnvironment, seed: int, variation: int) -> RepeatTrial:
    """Reset and demonstrate twice, and compare the bytes."""
    same = [("reset", reset_repeats), ("demonstration", demo_repeats)]
    differing = tuple(what for what, repeats in same if not repeats(task, seed, variation))
    return RepeatTrial(task=task.get_name(), seed=seed, variation=variation, differing=differing)


def noop_trial(task: TaskEnvironment, seed: int, variation: int) -> NoopTrial:
    return NoopTrial(task=task.get_name(), seed=seed, variation=variation, episode=noop_episode(task, seed, variation))


def random_trial(task: TaskEnvironment, seed: int, variation: int) -> RandomTrial:
    reached = random_succeeds(task, seed, variation)
    return RandomTrial(task=task.get_name(), seed=seed, variation=variation, reached_goal=reached)


def key_frames_trial(task: TaskEnvironment, seed: int, variation: int) -> KeyFramesTrial:
    """Demonstrate, restore the start, and execute the key frames alone, as key-frame agents do."""
    demo = None
    for attempt in range(KEY_FRAME_TRIES):
        if demo is None:
            demo = task.try_demo(seed=seed, variation=variation, attempt=attempt).demo
    if demo is None:
        return KeyFramesTrial(task=task.get_name(), seed=seed, variation=variation)
    task.reset_to_demo(demo)
    reached, refused = False, ""
    try:
        reached = reaches_goal(task, key_frame_actions(demo))
    except InvalidActionError as error:
        refused = _text(error)
    return KeyFramesTrial(task=task.get_name(), seed=seed, variation=variation, reached_goal=reached, refused=refused)


def friction_trial(task: TaskEnvironment, seed: int, variation: int) -> FrictionTrial:
    """Attempt one demonstration of a seed in an environment that does not attach grasped objects to the gripper."""
    task.reset(seed=seed, variation=variation)
    if not task.task.get_graspable_objects():
        return FrictionTrial(task=task.get_name(), seed=seed, variation=variation)
    outcome = task.try_demo(seed=seed, variation=variation)
    failed = () if outcome.success else (FailedAttempt(outcome.cause, outcome.waypoint),)
    return FrictionTrial(task=task.get_name(), seed=seed, variation=variation, reached_goal=outcome.success, failed=failed)


def reach_trial(task: TaskEnvironment, seed: int, variation: int) -> ReachTrial:
    reach = reach_of(task.runtime, seed, variation)
    return ReachTrial(task=task.get_name(), seed=seed, variation=variation, reach=reach)


_TRIALS: dict[Part, Callable[[TaskEnvironment, int, int], Trial]] = {
    "repeat": repeat_trial,
    "noop": noop_trial,
    "random": random_trial,
    "reach": reach_trial,
    "key_frames": key_frames_trial,
    "friction_only": friction_trial,
}
