"""A run of the challenge: meta-training, demonstrations, tests with each number of demonstrations, and the learning curve.

Each finished part is kept on disk.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing, nullcontext
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from rlbench_pin.datasets.storage import hold, write_whole
from rlbench_pin.environment.demos import library_versions
from rlbench_pin.errors import DatasetConflict, storing
from rlbench_pin.evaluation.challenge.client import LearnerClient
from rlbench_pin.evaluation.challenge.config import ChallengeConfig, ChallengeConflict, ChallengeStopped, refuse_links
from rlbench_pin.evaluation.challenge.demonstrations import ShownDemonstrations, ShownItem
from rlbench_pin.evaluation.challenge.learner import ImageFrames, read_learned, write_learned
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.results.records import Results
from rlbench_pin.evaluation.results.statistics import Estimate, Summary, summarise
from rlbench_pin.evaluation.results.tables import Table
from rlbench_pin.evaluation.run.config import EpisodeItem, EvaluationConfig
from rlbench_pin.evaluation.run.episode import EpisodeOutcome
from rlbench_pin.evaluation.run.evaluate import EvaluationProgress, EvaluationStopped, evaluate, journal_path
from rlbench_pin.evaluation.run.provenance import checkout_commit
from rlbench_pin.evaluation.run.runner import Around, EpisodeRunner
from rlbench_pin.processes import Engine, ProcessEngine
from rlbench_pin.rates import Rate
from rlbench_pin.values import as_flag, as_function, as_path, as_record, as_text

HEAD, SUMMARY = "challenge.json", "summary.json"
"""Files with the settings and the results of a run."""
_LATER = ("shots", "time_limit", "start_limit", "adapt_limit", "train_limit")
"""Settings that may differ when a run is resumed."""
DEMONSTRATIONS, LEARNED = "demonstrations", "learned.msgpack"
"""Folder of the demonstrations of test tasks, and file with the result of `meta_train`."""
FORMAT = 1
"""Number of the format of the learning curve."""


@dataclass(frozen=True)
class ChallengeProgress:
    """Progress of a run."""

    stage: str
    """Current stage: `practising`, `demonstrations`, or `5 shots`."""
    wanted: int
    """Number of jobs of this stage."""
    done: int
    """Number of finished jobs."""
    successes: int = 0
    """Number of finished episodes with success."""
    latest: str = ""
    """Task of the last finished job."""


OnProgress = Callable[[ChallengeProgress], None]
"""Called with the progress of the run."""


def run_challenge(
    config: ChallengeConfig,
    out: Path | str,
    *,
    engine: Engine | None = None,
    resume: bool = False,
    on_progress: OnProgress | None = None,
    stop: threading.Event | None = None,
) -> LearningCurve:
    """Run the challenge with a learner. Write a results file for each number of demonstrations, and return the learning curve.

    Args:
        config: Settings of the run.
        out: Folder of the run: `shots_1.json`, ..., `summary.json`, and demonstrations with their seeds.
            Only this process writes there; links are refused.
        engine: Runs the jobs; None uses one process. Meta-training always uses one process.
        resume: Continue an interrupted run.
        on_progress: Called with the progress.
        stop: When set, no further job begins; running jobs are finished and kept.

    Raises:
        ChallengeConflict: The folder contains another run, or it contains this run and `resume` is False.
        ChallengeStopped: `stop` was set before the end.
        NoDemonstrations: The planner could not demonstrate a test task.
        PolicyOfAnotherArm: The learner was made for the joints of another arm.
        PolicySettingsError: The learner requests withheld data.
        PolicyFault: The learner does not start, or fails in its meta-training.
        StorageError: The disk cannot be written to.
    """
    as_function(on_progress, "on_progress")
    run = _Run(
        as_record(config, ChallengeConfig, "config"),
        as_path(out, "out"),
        ProcessEngine() if engine is None else as_record(engine, Engine, "engine"),  # type: ignore[type-abstract]
        on_progress or (lambda progress: None),
        threading.Event() if stop is None else as_record(stop, threading.Event, "stop"),
    )
    return run.done(as_flag(resume, "resume"))


@dataclass(frozen=True)
class _Run:
    """A run in progress."""

    config: ChallengeConfig
    folder: Path
    engine: Engine
    watch: OnProgress
    stop: threading.Event

    def done(self, resume: bool) -> LearningCurve:
        """Do all remaining work, and return the learning curve."""
        config = self.config
        with ExitStack() as held:
            refuse_links(self.folder)
            try:
                held.enter_context(hold(self.folder))
            except DatasetConflict as error:
                problem = f"Another run uses the folder '{self.folder}'. Wait until it ends, or choose another folder."
                raise ChallengeConflict(problem) from error
            self.begin(resume)
            settings, image_frames = self.practise()
            self.demonstrate(settings, image_frames)
            results = {shots: self.test(shots, settings) for shots in config.shots}
            refuse_links(self.folder)
            curve = learning_curve(config.learner, config.split, results, config.secret_sha256)
            curve.write(self.folder / SUMMARY)
        return curve

    def begin(self, resume: bool) -> None:
        """Write the settings of the run, or compare them with those in the folder."""
        path, head = self.folder / HEAD, json.loads(json.dumps(self._head()))
        if path.is_file():
            if not resume:
                raise ChallengeConflict(
                    f"'{self.folder}' contains a run of the challenge. Continue with `--resume`, or choose another folder."
                )
            with storing(path):
                then = json.loads(path.read_text(encoding="utf-8"))
            for name in sorted({*then, *head} - set(_LATER)):
                if then.get(name) != head.get(name):
                    raise ChallengeConflict.between(path, name, then.get(name), head.get(name))
            return
        write_whole(path, (json.dumps(head, indent=1) + "\n").encode())

    def practise(self) -> tuple[PolicySettings, ImageFrames]:
        """Run the meta-training unless it is done; return the learner's settings and the frames that need images."""
        path, tasks = self.folder / LEARNED, self.config.tasks().train
        with closing(open_learner(self.config)) as learner:
            wanted = learner.settings, learner.image_frames()
            wanted[0].check_robot(self.config.robot)
            if not path.is_file():
                self.watch(ChallengeProgress("practising", 1, 0))
                write_learned(path, learner.meta_train(tasks, self.config.robot, self.config.train_limit))
                self.watch(ChallengeProgress("practising", 1, 1))
        return wanted

    def demonstrate(self, settings: PolicySettings, image_frames: ImageFrames) -> None:
        """Make the demonstrations that are missing."""
        refuse_links(self.folder)
        shown = ShownDemonstrations(self.folder / DEMONSTRATIONS)
        wanted = max(self.config.shots) * len(self.config.tasks().test)
        done = wanted - len(shown.missing(self.config))
        self.watch(ChallengeProgress("demonstrations", wanted, done))

        def one_more(item: ShownItem) -> None:
            nonlocal done
            done += 1
            self.watch(ChallengeProgress("demonstrations", wanted, done, latest=item.task))

        if shown.make(self.config, (settings, image_frames), self.engine, one_more, self.stop):
            raise ChallengeStopped("demonstrations", done, wanted, self.folder)

    def test(self, shots: int, settings: PolicySettings) -> Results:
        """Evaluate with `shots` demonstrations."""
        refuse_links(self.folder)
        out, stage = self.folder / f"shots_{shots}.json", f"{shots} shot{'s' if shots > 1 else ''}"

        def on_progress(p: EvaluationProgress) -> None:
            latest = "" if p.latest is None else p.latest.item.name
            self.watch(ChallengeProgress(stage, p.wanted, p.found + p.done, p.successes, latest))

        begun = out.exists() or journal_path(out).exists()
        try:
            return evaluate(
                self.config.evaluation(shots), out, engine=self.engine, resume=begun, on_progress=on_progress, stop=self.stop,
                make_runner=partial(ShotsRunner, self.config, self.folder, shots, settings),
            )  # fmt: skip
        except EvaluationStopped as stopped:
            raise ChallengeStopped(stage, stopped.done, stopped.wanted, self.folder) from stopped

    def _head(self) -> dict[str, Any]:
        tasks = self.config.tasks()
        versions = {"versions": library_versions(), "commit": checkout_commit()}
        settings = {name: value for name, value in asdict(self.config).items() if name != "secret"}
        if self.config.secret:
            settings["secret_sha256"] = self.config.secret_sha256
        return {"format": 1, **settings, "train": tasks.train, "test": tasks.test, **versions}


class ShotsRunner(EpisodeRunner):
    """Plays episodes of test tasks. Before the first episode of a task, a new process of the learner adapts to the task.

    Args:
        challenge: Settings of the run.
        folder: Folder of the run, with the demonstrations and the result of `meta_train`.
        shots: Number of demonstrations of each task.
        settings: Settings of the learner.
        config: Settings of the evaluation.
    """

    def __init__(
        self, challenge: ChallengeConfig, folder: Path, shots: int, settings: PolicySettings, config: EvaluationConfig
    ) -> None:
        self._learner, self._folder = open_learner(challenge, settings), folder
        super().__init__(config, self._learner)
        self._demonstrations, self._shots = ShownDemonstrations(folder / DEMONSTRATIONS), shots
        self._learned, self._shown = read_learned(folder / LEARNED), ""

    def play(self, item: EpisodeItem, around: Around = lambda task: nullcontext()) -> EpisodeOutcome:
        """Play an episode.

        Args:
            item: The episode.
            around: Makes a context around the episode, from its start to its end.
        """
        if self._shown != item.name:
            refuse_links(self._folder)
            self._learner.show(partial(self._demonstrations.read, item.name, self._shots), self._learned)
            self._shown = item.name
        return super().play(item, around)


def open_learner(config: ChallengeConfig, known: PolicySettings | None = None) -> LearnerClient:
    """Return the learner of a run; it starts when it is first asked for something."""
    return LearnerClient(config.learner, config.seed, config.time_limit, config.start_limit, config.adapt_limit, known)


# The learning curve -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ShotsResult:
    """Results with one number of demonstrations."""

    shots: int
    summary: Summary
    sha256: str
    """Checksum of the results file."""


@dataclass(frozen=True)
class LearningCurve:
    """Results of a run of the challenge."""

    learner: str
    split: str
    points: tuple[ShotsResult, ...]
    """In ascending order of the number of demonstrations."""
    secret_sha256: str = ""
    """SHA-256 of the secret of the run; "" without a secret."""

    def table(self) -> Table:
        """Return a table with a row per task and one for the mean."""
        head = ("task", *(f"{p.shots} shot{'s' if p.shots > 1 else ''}" for p in self.points))
        rates = [{task.task: task.success for task in point.summary.tasks} for point in self.points]
        rows = [(name, *(_cell(_estimate(of_point[name])) for of_point in rates)) for name in rates[0]] if rates else []
        rows.append(("mean over tasks", *(_cell(point.summary.success) for point in self.points)))
        title = f"{self.learner} on the challenge {self.split}: success, with its 95 % interval"
        return Table(title, head, tuple(rows))

    def content(self) -> dict[str, Any]:
        """Return the results as plain data."""
        points = [{"shots": p.shots, "results_sha256": p.sha256, **_content(p.summary)} for p in self.points]
        secret = {"secret_sha256": self.secret_sha256} if self.secret_sha256 else {}
        return {"format": FORMAT, "learner": self.learner, "split": self.split, **secret, "points": points}

    def write(self, path: Path) -> Path:
        """Write the results as JSON, and return the path.

        Raises:
            StorageError: The disk cannot be written to.
        """
        return write_whole(path, (json.dumps(self.content(), indent=1) + "\n").encode())


def learning_curve(learner: str, split: str, results: Mapping[int, Results], secret_sha256: str = "") -> LearningCurve:
    """Return the learning curve of a run.

    Args:
        learner: Reference of the learner.
        split: Name of the split.
        results: Number of demonstrations -> results of the evaluation.
        secret_sha256: SHA-256 of the secret of the run; "" without a secret.
    """
    learner, split = as_text(learner, "learner"), as_text(split, "split")
    as_record(results, Mapping, "results")  # type: ignore[type-abstract]
    rng = np.random.default_rng(0)
    points = [ShotsResult(k, summarise(results[k], rng), results[k].sha256) for k in sorted(results)]
    return LearningCurve(learner, split, tuple(points), as_text(secret_sha256, "secret_sha256"))


def _content(summary: Summary) -> dict[str, Any]:
    tasks = {task.task: _estimate(task.success).as_dict() for task in summary.tasks}
    return {"episodes": summary.episodes, "mean": summary.success.as_dict(), "tasks": tasks}


def _estimate(rate: Rate) -> Estimate:
    return Estimate(rate.value, *rate.interval)


def _cell(value: Estimate) -> str:
    return f"{100 * value.value:.0f} % ({100 * value.low:.0f} to {100 * value.high:.0f})"
