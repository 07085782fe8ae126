"""`rlbench-pin evaluate POLICY`: play episodes in worker processes, write a results file, and record videos of failures."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from rlbench_pin.cli.interrupts import INTERRUPTED
from rlbench_pin.cli.list_tasks import split_names
from rlbench_pin.cli.options import (
    EngineName,
    MaybeInt,
    MaybeProtocol,
    MaybeText,
    RobotName,
    TaskNames,
    check_at_least,
    check_file,
    check_folder,
    checked_names,
    make_engine,
    with_defaults,
)
from rlbench_pin.cli.pages import PageOptions, check_port, live_module, live_page
from rlbench_pin.errors import TaskEnvironmentError

if TYPE_CHECKING:
    from rlbench_pin.environment.task_environment import TaskEnvironment
    from rlbench_pin.evaluation.protocols import Protocol
    from rlbench_pin.evaluation.results.records import EpisodeRecord, Results
    from rlbench_pin.evaluation.run import EpisodeItem, EpisodeRunner, EvaluationConfig
    from rlbench_pin.processes import Engine

TASKS = (
    "reach_target", "push_button", "pick_and_lift", "take_lid_off_saucepan", "open_drawer",
    "close_microwave", "slide_block_to_target", "stack_blocks", "put_rubbish_in_bin", "meat_off_grill",
)  # fmt: skip
"""Tasks by default."""
MaybePolicy = Annotated[str, tyro.conf.arg(metavar="[POLICY]", help_behavior_hint="")]
"""A policy as an optional argument."""
Factors = Annotated[tuple[str, ...], tyro.conf.arg(metavar="FACTOR...", help_behavior_hint="(default: none)")]
"""Factors of generalisation."""
TrainedOn = Annotated[str, tyro.conf.arg(metavar="FACTOR:LEVEL+...", help_behavior_hint="(default: not stated)")]
MaybeLevel = Annotated[str | None, tyro.conf.arg(metavar="1|2|3|colosseum", help_behavior_hint="")]
EPISODES = 25
"""Episodes of each task by default."""


@dataclass(frozen=True)
class Evaluate:
    """Evaluate a policy on tasks: success with its interval, collisions, limits. `--resume` continues after an interruption.

    With the same `--policy-seed-key`, results files are byte-identical for any number of workers. `rlbench-pin results FILE...`
    shows and compares them.
    """

    policy: tyro.conf.Positional[MaybePolicy] = ""
    """`noop`, `random`, `expert` (the planner of demonstrations), `classical`, `cloning?folder=FOLDER`,
    `key_frames?folder=FOLDER`, `ppo:FOLDER`, `sac:FOLDER`, `sb3:FILE`, `lerobot:FOLDER`, `module:factory`,
    `file.py:factory`, or the address of a policy server: `tcp://HOST:PORT`, `unix:PATH`, or
    `openpi://HOST:PORT?mapping=NAME` and `vla-eval://HOST:PORT?mapping=NAME`. See docs/policies.md."""
    tasks: TaskNames = TASKS
    """Task names, task files, sets of tasks such as FS10_V1, or `all`, separated by spaces or commas."""
    protocol: MaybeProtocol = None
    """Protocol, such as peract18 or gembench:L1, or a TOML file: fixes tasks, episodes, limits, arm, cameras and action mode.
    `rlbench-pin list --protocols` lists them."""
    episodes: MaybeInt = None
    """Episodes of each task, spread evenly over its variations; default 25."""
    variations: int = -1
    """Maximum number of variations of a task; -1 is all."""
    seed: int = 0
    """Seed of the evaluation: episode i has the seed 2^53 + 2 (seed + i). No demonstration has such a seed."""
    max_steps: MaybeInt = None
    """Maximum number of actions of an episode. Default: the number that the policy suggests; otherwise 25 if each action plans a
    motion, else as many as fit into `--max-seconds`."""
    max_seconds: float = 120.0
    """Maximum simulated time of an episode with the Panda [s]. Arms with slower joints have a longer limit: jaco 3.5 times."""
    time_limit: float = 30.0
    """Wall-clock time limit of the policy for one action [s]. If the policy takes longer, the episode fails."""
    start_limit: float = 300.0
    """Time limit for the start of the policy [s]."""
    robot: RobotName = "panda"
    """Name of the arm, or path of its TOML file."""
    tell_task: bool = True
    """Pass the name of the task to the policy, in addition to the instruction."""
    policy_seed_key: MaybeText = None
    """Key of the seeds of the policy. The key in a results file repeats that run. Default: a random key."""
    factors: Factors = ()
    """Factors of generalisation: `light_color:2` is a level, `light_color` all levels, `light_color:2+friction:1` both at once,
    `all` every factor alone. The same episodes are also played without factors. `rlbench-pin factors` lists them."""
    level: MaybeLevel = None
    """Level of the factors that are named without one: 1, 2, 3, or colosseum."""
    trained_on: TrainedOn = ""
    """Factors in the training data of the policy, for the results file, such as `light_color:1` or `none`."""
    workers: int = 1
    """Number of worker processes, each with its own policy; 0 runs all in this process."""
    engine: EngineName = "processes"
    """Engine: processes of this machine, or a Ray cluster."""
    out: Path = Path("out/results.json")
    """Path of the results file. A second file next to it contains the action times. A journal keeps finished episodes until the
    run is complete."""
    resume: bool = False
    """Continue an interrupted evaluation."""
    videos: int = 0
    """Number of failures of each task to replay as videos after the evaluation, in a folder next to the results."""
    page: tyro.conf.OmitArgPrefixes[PageOptions] = field(default_factory=PageOptions)
    """Show the episodes as they are played, one after the other in this process; the results are the same."""

    def run(self) -> int:
        """Evaluate a policy; 130 when it was stopped."""
        if not self.policy:
            raise TaskEnvironmentError("No policy was named. Use `rlbench-pin evaluate POLICY`, for example `expert`.")
        from rlbench_pin.cli.progress import EvaluationBar, stopping_gently
        from rlbench_pin.evaluation.policies.references import EXPERT, find_policy
        from rlbench_pin.evaluation.results.profile import factor_profile, profile_table
        from rlbench_pin.evaluation.run import EvaluationStopped, evaluate

        check_at_least(self, workers=0, videos=0)
        config = self.config()
        if self.policy != EXPERT:
            find_policy(self.policy)
        check_file(self.out)
        engine, page = self._engine(), watched(self.page, self.policy)
        with page as make, stopping_gently() as stop, closing(EvaluationBar(self.policy)) as bar:
            try:
                results = evaluate(
                    config, self.out, engine=engine, resume=self.resume, on_progress=bar, stop=stop, make_runner=make
                )
            except EvaluationStopped as stopped:
                bar.close()
                print(f"{stopped.done} of {stopped.wanted} episodes are played. Continue with:  {self.go_on()}", file=sys.stderr)
                return INTERRUPTED
        print(profile_table(factor_profile(results)).text() if results.factors else summary(results))
        print(f"Results in {self.out}; `rlbench-pin results {shlex.quote(str(self.out))}` shows all of them.")
        if self.videos:
            folder = self.out.with_name(f"{self.out.stem}_videos")
            repeated = replace(config, policy_seed_key=results.policy_seed_key)
            for video in record_failures(repeated, results, self.videos, folder):
                print(f"  video  {video}")
        return 0

    def _engine(self) -> Engine:
        from rlbench_pin.processes import SerialEngine

        if not self.page.live:
            return make_engine(self.engine, self.workers)
        if self.workers > 1 or self.engine != "processes":
            raise TaskEnvironmentError(
                f"--live plays all episodes in one process, but --workers is {self.workers} and --engine is {self.engine}. Leave "
                "both out."
            )
        return SerialEngine()

    def config(self) -> EvaluationConfig:
        """Return the settings of the evaluation.

        Raises:
            UnknownName: There is no such task or set.
        """
        from rlbench_pin.environment.factors import expand_settings
        from rlbench_pin.evaluation.run import EvaluationConfig
        from rlbench_pin.evaluation.sets import resolve_tasks

        words = checked_names(self.tasks, split_names, "rlbench-pin evaluate POLICY --tasks TASK...")
        tasks, task_set, protocol = resolve_tasks(words), " ".join(words), self._protocol()
        if protocol is not None:
            protocol.check_tasks_exist()
            task_set = protocol.label
            tasks = protocol.task_names if set(tasks) == set(protocol.task_names) else tasks
        return EvaluationConfig(
            policy=self.policy,
            tasks=tasks,
            task_set=task_set,
            protocol=protocol,
            episodes=EPISODES if self.episodes is None else self.episodes,
            seed=self.seed,
            max_steps=self.max_steps,
            max_seconds=self.max_seconds,
            variations=self.variations,
            time_limit=self.time_limit,
            start_limit=self.start_limit,
            robot=self.robot,
            tell_task=self.tell_task,
            policy_seed_key=self.policy_seed_key,
            factors=expand_settings(self.factors, self.level),
            trained_on=self.trained_on,
        )

    def _protocol(self) -> Protocol | None:
        from rlbench_pin.evaluation.protocols import load_protocol

        return None if self.protocol is None else load_protocol(self.protocol)

    def with_protocol_defaults(self) -> type[Evaluate]:
        """Return this command with what its protocol fixes as defaults: other values are then those that the user gave.

        Raises:
            UnknownName: There is no such protocol.
            ProtocolError: It cannot be used.
        """
        from rlbench_pin.evaluation.protocols import ProtocolFileError
        from rlbench_pin.evaluation.run.config import protocol_settings

        try:
            protocol = self._protocol()
        except ProtocolFileError:  # `config` raises it
            protocol = None
        if protocol is None:
            return type(self)
        protocol.check_tasks_exist()
        fixed = {name: value for name, value in protocol_settings(protocol).items() if name != "task_set"}
        return with_defaults(Evaluate, fixed)

    def go_on(self) -> str:
        """Return the command that continues this evaluation."""
        words = sys.argv[1:]
        if words[:1] != ["evaluate"]:  # called from a program
            words = ["evaluate", self.policy, "--out", str(self.out), "--tasks", *self.tasks]
            words += [] if self.protocol is None else ["--protocol", self.protocol]
        return shlex.join(["rlbench-pin", *words, *([] if "--resume" in words else ["--resume"])])


def summary(results: Results) -> str:
    """Return a line for each task with its rate of success and its faults, the mean of the tasks, and the first faults."""
    import numpy as np

    from rlbench_pin.evaluation.results.statistics import summarise
    from rlbench_pin.evaluation.results.tables import fault_notes
    from rlbench_pin.rates import Rate

    width = max(len(task) for task in (*results.tasks, "mean"))
    lines = [f"{'task':<{width}}  success        95 %       stable  refused  collisions  faults"]
    lines += [_line(task, width, results.of_task(task)) for task in results.tasks]
    means = [Rate(sum(e.success for e in some), len(some)).value for some in map(results.of_task, results.tasks)]
    mean = f"{'mean':<{width}}  {100.0 * math.fsum(means) / len(means):5.1f} %"
    return "\n".join([*lines, mean, *fault_notes(summarise(results, np.random.default_rng(0)))])


def _line(task: str, width: int, episodes: tuple[EpisodeRecord, ...]) -> str:
    from rlbench_pin.rates import Rate

    rate = Rate(sum(e.success for e in episodes), len(episodes))
    low, high = (100.0 * bound for bound in rate.interval)
    refused, touched = sum(sum(e.refused.values()) for e in episodes), sum(e.collisions for e in episodes)
    return (
        f"{task:<{width}}  {100.0 * rate.value:5.1f} %  {low:5.1f} to {high:5.1f} %  {sum(e.lasts for e in episodes):>6}"
        f"  {refused:>7}  {touched:>10}  {sum(bool(e.fault) for e in episodes):>6}"
    )


def record_failures(config: EvaluationConfig, results: Results, count: int, folder: Path) -> Iterator[Path]:
    """Replay the first failures of each task, and yield a video of each as it is made.

    Args:
        config: Settings of the evaluation.
        results: Its results.
        count: Number of failures of each task.
        folder: Folder of the videos, `<task>_<seed>_<end of the episode>.mp4`.
    """
    from rlbench_pin.cli.bars import progress_bar
    from rlbench_pin.evaluation.run import EpisodeRunner, plan_episodes

    check_folder(folder)
    records = {record.key: record for record in results.episodes}
    items = plan_episodes(config)
    chosen: list[tuple[EpisodeItem, EpisodeRecord]] = []
    for task in results.tasks:
        of_task = [(item, records[item.key]) for item in items if item.name == task]
        chosen += [(item, record) for item, record in of_task if not record.success][:count]
    with EpisodeRunner(config) as runner, progress_bar(total=len(chosen), unit="video", desc="videos") as bar:
        for item, record in chosen:
            path = folder / f"{item.name}_{item.seed}{item.factors and '_'}{item.factors}_{record.end}.mp4"
            runner.play(item, lambda task, path=path: _recorded(task, path))  # type: ignore[misc]
            bar.update()
            if path.exists():
                yield path


@contextmanager
def _recorded(task: TaskEnvironment, path: Path) -> Iterator[None]:
    """Record a video of the block, also when a fault ends it."""
    from rlbench_pin.recording import VideoRecorder

    with VideoRecorder(task, path.parent) as recorder:
        try:
            yield
        finally:
            recorder.keep(path)


@contextmanager
def watched(wanted: PageOptions, title: str) -> Iterator[Callable[[EvaluationConfig], EpisodeRunner]]:
    """Yield the factory of the runners of an evaluation; with `--live`, a page is served for the duration of the block.

    Args:
        wanted: The arguments of the command.
        title: Title of the page.
    """
    from rlbench_pin.evaluation.run import EpisodeRunner

    check_port(wanted)
    if not wanted.live:
        yield EpisodeRunner
        return
    live = live_module()
    with live_page(live.EvaluationView, title, wanted) as view:
        yield partial(live.LiveRunner, view=view)
