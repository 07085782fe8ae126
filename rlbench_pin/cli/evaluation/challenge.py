"""`rlbench-pin challenge run|splits`: few-shot learners on tasks that they have never seen."""

from __future__ import annotations

import json
import shlex
import sys
from contextlib import closing

from tqdm import tqdm

from rlbench_pin.cli.arguments.evaluation import challenge as arguments
from rlbench_pin.cli.list_tasks import split_names
from rlbench_pin.cli.process.commands import Subcommand
from rlbench_pin.cli.process.engines import make_engine
from rlbench_pin.cli.process.files import check_folder
from rlbench_pin.cli.process.interrupts import INTERRUPTED
from rlbench_pin.cli.process.words import check_at_least
from rlbench_pin.cli.progress import stopping_gently
from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.evaluation.challenge import (
    ChallengeConfig,
    ChallengeProgress,
    ChallengeStopped,
    meta_split,
    meta_splits,
    read_secret,
    run_challenge,
)


class Run(arguments.Run):
    """The work of `rlbench-pin challenge run`."""

    def run(self) -> int:
        """Let a learner take the challenge, and print its learning curve; 130 when it was stopped."""
        if not self.learner:
            raise TaskEnvironmentError(
                "No learner was named. Use `rlbench-pin challenge run LEARNER`, for example `nearest` or `my_learner.py:make`."
            )
        check_at_least(self, workers=0, episodes=1, seed=0, shots=1)
        config = self.config()
        config.tasks()
        check_folder(self.out)
        engine = make_engine(self.engine, self.workers)
        with stopping_gently() as stop, closing(ChallengeBar(self.learner)) as bar:
            try:
                curve = run_challenge(config, self.out, engine=engine, resume=self.resume, on_progress=bar, stop=stop)
            except ChallengeStopped as stopped:
                bar.close()
                print(f"{stopped.stage}: {stopped.done} of {stopped.wanted}. Go on with:  {self.go_on()}", file=sys.stderr)
                return INTERRUPTED
        print(curve.table().text())
        files = " ".join(shlex.quote(str(self.out / f"shots_{point.shots}.json")) for point in curve.points)
        print(f"Results in {self.out}; `rlbench-pin results {files}` shows all of them.")
        return 0

    def config(self) -> ChallengeConfig:
        """Return the run.

        Raises:
            UnknownName: There is no such learner, split or test task.
        """
        return ChallengeConfig(
            learner=self.learner,
            split=self.split,
            shots=self.shots,
            only=split_names(self.tasks),
            available=self.available,
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
        """Return the command that goes on where this one was stopped."""
        words = sys.argv[1:]
        if words[:1] != ["challenge"]:  # called from a program
            words = ["challenge", "run", self.learner, "--out", str(self.out)]
        return shlex.join(["rlbench-pin", *words, *([] if "--resume" in words else ["--resume"])])


class Splits(arguments.Splits):
    """The work of `rlbench-pin challenge splits`."""

    def run(self) -> int:
        """Print one line per split; as JSON, all that is known of each."""
        splits = [meta_split(name) for name in meta_splits()]
        if self.json:
            content = {s.name: {"about": s.about, "train": s.train, "test": s.test, "missing": s.missing} for s in splits}
            print(json.dumps(content, indent=1))
            return 0
        for s in splits:
            built = [sum(name not in s.missing for name in names) for names in (s.train, s.test)]
            train, test = (f"{n:>2} of {len(names):>2} built" for n, names in zip(built, (s.train, s.test)))
            print(f"{s.name:<7}  train {train}  test {test}  {s.about}")
        print("`--json` names the tasks, and those that are missing.")
        return 0


class Challenge(arguments.Challenge):
    """The work of `rlbench-pin challenge`."""

    def run(self) -> int:
        """Do it."""
        assert isinstance(self.action, Subcommand)
        return self.action.run()


class ChallengeBar:
    """A bar on stderr for each part of a run.

    Args:
        learner: What takes the challenge.
    """

    def __init__(self, learner: str) -> None:
        self._learner, self._stage = learner, ""
        self._bar: tqdm | None = None

    def __call__(self, progress: ChallengeProgress) -> None:
        """Show how far it is."""
        if progress.stage != self._stage:
            self.close()
            self._stage, name = progress.stage, f"{self._learner}, {progress.stage}"
            self._bar = tqdm(total=progress.wanted, initial=progress.done, desc=name, dynamic_ncols=True)
        assert self._bar is not None
        self._bar.update(progress.done - self._bar.n)
        notes = [f"success {100.0 * progress.successes / progress.done:.0f} %"] if "shot" in self._stage and progress.done else []
        self._bar.set_postfix_str(", ".join([*notes, *([progress.latest] if progress.latest else [])]))

    def close(self) -> None:
        """Leave the line as it is."""
        if self._bar is not None:
            self._bar.close()
        self._bar = None
