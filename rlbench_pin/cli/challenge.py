"""`rlbench-pin challenge run|splits`: evaluate few-shot learners on unseen tasks."""

from __future__ import annotations

import json
import shlex
import sys
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from rlbench_pin.cli.interrupts import INTERRUPTED
from rlbench_pin.cli.list_tasks import split_names
from rlbench_pin.cli.options import (
    EngineName,
    MaybeInt,
    MaybePath,
    OnlyTasks,
    RobotName,
    check_at_least,
    check_folder,
    make_engine,
)
from rlbench_pin.errors import TaskEnvironmentError

if TYPE_CHECKING:
    from tqdm import tqdm

    from rlbench_pin.evaluation.challenge import ChallengeConfig, ChallengeProgress

LearnerName = Annotated[str, tyro.conf.arg(metavar="LEARNER", help_behavior_hint="(required)")]
"""A learner as the argument of a command; the command reports a missing one."""
Shots = Annotated[tuple[int, ...], tyro.conf.arg(metavar="INT...")]
"""Numbers of demonstrations."""
SplitName = Annotated[str, tyro.conf.arg(metavar="SPLIT")]
"""A split of the challenge."""


@dataclass(frozen=True)
class Run:
    """Run the few-shot challenge with a learner. Use `--resume` to continue after an interruption.

    The folder contains a results file for each number of demonstrations, such as `shots_5.json`, the learning curve
    `summary.json`, and the demonstrations with their seeds. `rlbench-pin results` shows and compares results files.
    """

    learner: tyro.conf.Positional[LearnerName] = ""
    """`nearest`, `module:factory` or `file.py:factory`. docs/challenge.md shows how to write one."""
    shots: Shots = (1, 5, 20)
    """Numbers of demonstrations of each test task."""
    split: SplitName = "V1"
    """Split of the tasks into training and test: V1, FS10_V1, FS25_V1, FS50_V1 or FS95_V1."""
    tasks: OnlyTasks = ()
    """Only these test tasks, separated by spaces or commas."""
    episodes: int = 25
    """Episodes of each test task, spread evenly over its variations; the same for each number of demonstrations."""
    seed: int = 0
    """Seed of the episodes, as for `evaluate`, and of the demonstrations."""
    secret: MaybePath = None
    """File with a secret of at least 16 bytes, mixed into the seeds of episodes and demonstrations.
    Results record its SHA-256. Publish the file when the challenge is over."""
    max_steps: MaybeInt = None
    """Maximum number of actions of an episode. Default: the number that the learner suggests; otherwise as in `evaluate`."""
    max_seconds: float = 120.0
    """Maximum simulated time of an episode with the Panda [s]. Arms with slower joints have a longer limit: jaco 3.5 times."""
    time_limit: float = 30.0
    """Wall-clock time limit of the policy for one action [s]."""
    start_limit: float = 300.0
    """Time limit for the start of the learner [s]."""
    adapt_limit: float = 3600.0
    """Time limit for the adaptation of the learner to one task [s]."""
    train_limit: float = 1e6
    """Time limit for the training of the learner on the training tasks [s]."""
    robot: RobotName = "panda"
    """Name of the arm, or path of its TOML file."""
    workers: int = 1
    """Number of worker processes, each with its own learner; 0 runs all in this process."""
    engine: EngineName = "processes"
    """Engine: processes of this machine, or a Ray cluster."""
    out: Path = Path("out/challenge")
    """Folder of the run."""
    resume: bool = False
    """Continue an interrupted run."""

    def run(self) -> int:
        """Run the challenge, and print the learning curve; 130 when it was stopped."""
        from rlbench_pin.cli.progress import stopping_gently
        from rlbench_pin.evaluation.challenge import ChallengeStopped, run_challenge

        if not self.learner:
            raise TaskEnvironmentError(
                "No learner was named. Use `rlbench-pin challenge run LEARNER`, for example `nearest` or `my_learner.py:make`."
            )
        check_at_least(self, workers=0, episodes=1, seed=0, shots=1)
        config = self.config()
        check_folder(self.out)
        engine = make_engine(self.engine, self.workers)
        with stopping_gently() as stop, closing(ChallengeBar(self.learner)) as bar:
            try:
                curve = run_challenge(config, self.out, engine=engine, resume=self.resume, on_progress=bar, stop=stop)
            except ChallengeStopped as stopped:
                bar.close()
                print(f"{stopped.stage}: {stopped.done} of {stopped.wanted}. Continue with:  {self.go_on()}", file=sys.stderr)
                return INTERRUPTED
        print(curve.table().text())
        files = " ".join(shlex.quote(str(self.out / f"shots_{point.shots}.json")) for point in curve.points)
        print(f"Results in {self.out}; `rlbench-pin results {files}` shows all of them.")
        return 0

    def config(self) -> ChallengeConfig:
        """Return the settings of the run.

        Raises:
            UnknownName: There is no such learner, split or test task.
        """
        from rlbench_pin.evaluation.challenge import ChallengeConfig, read_secret

        return ChallengeConfig(
            learner=self.learner,
            split=self.split,
            shots=self.shots,
            only=split_names(self.tasks),
            episodes=self.episodes,
            seed=self.seed,
            max_steps=self.max_steps,
            max_seconds=self.max_seconds,
            time_limit=self.time_limit,
            start_limit=self.start_limit,
            adapt_limit=self.adapt_limit,
            train_limit=self.train_limit,
            robot=self.robot,
            secret=b"" if self.secret is None else read_secret(self.secret),
        )

    def go_on(self) -> str:
        """Return the command that continues this run."""
        words = sys.argv[1:]
        if words[:1] != ["challenge"]:  # called from a program
            words = ["challenge", "run", self.learner, "--out", str(self.out)]
        return shlex.join(["rlbench-pin", *words, *([] if "--resume" in words else ["--resume"])])


@dataclass(frozen=True)
class Splits:
    """List the splits of the challenge."""

    json: bool = False
    """Print JSON for programs, with the names of all tasks."""

    def run(self) -> int:
        """Print one line per split; as JSON, all data of each."""
        from rlbench_pin.evaluation.challenge import meta_split, meta_splits

        splits = [meta_split(name) for name in meta_splits()]
        if self.json:
            content = {s.name: {"about": s.about, "train": s.train, "test": s.test} for s in splits}
            print(json.dumps(content, indent=1))
            return 0
        for s in splits:
            print(f"{s.name:<7}  train {len(s.train):>2}  test {len(s.test):>2}  {s.about}")
        print("`--json` names the tasks.")
        return 0


@dataclass(frozen=True)
class Challenge:
    """The few-shot challenge: a learner gets 1, 5 and 20 demonstrations of each unseen task."""

    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[Run, tyro.conf.subcommand("run")] | Annotated[Splits, tyro.conf.subcommand("splits")]
    ] = field()
    """Subcommand."""

    def run(self) -> int:
        """Run the subcommand."""
        return self.action.run()


class ChallengeBar:
    """A bar on stderr for each part of a run.

    Args:
        learner: The learner.
    """

    def __init__(self, learner: str) -> None:
        self._learner, self._stage = learner, ""
        self._bar: tqdm | None = None

    def __call__(self, progress: ChallengeProgress) -> None:
        """Show the progress."""
        from rlbench_pin.cli.bars import progress_bar

        if progress.stage != self._stage:
            self.close()
            self._stage, name = progress.stage, f"{self._learner}, {progress.stage}"
            self._bar = progress_bar(total=progress.wanted, initial=progress.done, desc=name)
        assert self._bar is not None
        self._bar.update(progress.done - self._bar.n)
        notes = [f"success {100.0 * progress.successes / progress.done:.0f} %"] if "shot" in self._stage and progress.done else []
        self._bar.set_postfix_str(", ".join([*notes, *([progress.latest] if progress.latest else [])]))

    def close(self) -> None:
        """Close the bar; its last line stays."""
        if self._bar is not None:
            self._bar.close()
        self._bar = None
