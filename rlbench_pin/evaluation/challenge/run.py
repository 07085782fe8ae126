"""A run of the challenge: practise, make the demonstrations, test with each number of them; each part is kept when it is done."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rlbench_pin.datasets.storage import hold, storing, write_whole
from rlbench_pin.environment.demos import library_versions
from rlbench_pin.errors import DatasetConflict
from rlbench_pin.evaluation.challenge.config import ChallengeConfig
from rlbench_pin.evaluation.challenge.demonstrations import ShownDemonstrations, ShownItem
from rlbench_pin.evaluation.challenge.faults import ChallengeConflict, ChallengeStopped
from rlbench_pin.evaluation.challenge.learned import write_learned
from rlbench_pin.evaluation.challenge.learner import Pictures
from rlbench_pin.evaluation.challenge.runner import DEMONSTRATIONS, LEARNED, ShotsRunner, open_learner
from rlbench_pin.evaluation.challenge.summary import LearningCurve, learning_curve
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.results.records import Results
from rlbench_pin.evaluation.run.evaluate import EvaluationProgress, EvaluationStopped, evaluate, journal_path
from rlbench_pin.evaluation.run.provenance import checkout_commit
from rlbench_pin.processes import Engine, ProcessEngine
from rlbench_pin.values import as_flag, as_function, as_path, as_record

HEAD, SUMMARY = "challenge.json", "summary.json"
"""What a run is, and what came of it."""
_LATER = ("shots", "time_limit", "start_limit", "adapt_limit", "train_limit")
"""Settings that may be others when a run goes on."""


@dataclass(frozen=True)
class ChallengeProgress:
    """How far a run is."""

    stage: str
    """What is under way: `practising`, `demonstrations`, or `5 shots`."""
    wanted: int
    """Pieces of that."""
    done: int
    """Of these, done."""
    successes: int = 0
    """Of the episodes done, with success."""
    latest: str = ""
    """Task of the piece that was finished last."""


OnProgress = Callable[[ChallengeProgress], None]
"""Called with how far the run is."""


def run_challenge(
    config: ChallengeConfig,
    out: Path | str,
    *,
    engine: Engine | None = None,
    resume: bool = False,
    on_progress: OnProgress | None = None,
    stop: threading.Event | None = None,
) -> LearningCurve:
    """Let a learner take the challenge; write a results file for each number of demonstrations, and the learning curve.

    Args:
        config: The run.
        out: Its folder: `shots_1.json`, ..., `summary.json`, and demonstrations with their seeds. The learner is not told of it.
        engine: Who does the work; one process when None. The meta-training tasks are practised in one process.
        resume: Go on with a run that did not end.
        on_progress: Called with how far it is.
        stop: When set, nothing more is begun; what is under way is finished and kept.

    Raises:
        ChallengeConflict: There is another run in the folder, or this one, without `resume`.
        ChallengeStopped: `stop` was set before all was done.
        MissingTasks: Tasks of the split are not built, and are not to be left out.
        NoDemonstrations: A task of the test could not be demonstrated.
        PolicySettingsError: The learner asks for what is withheld; PolicyFault: it does not start, or fails while it practises.
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
    """A run under way."""

    config: ChallengeConfig
    folder: Path
    engine: Engine
    watch: OnProgress
    stop: threading.Event

    def done(self, resume: bool) -> LearningCurve:
        """Do all that is not done yet, and return what came of it."""
        self.config.tasks()
        with ExitStack() as held:
            self.hold(held)
            self.begin(resume)
            self.demonstrate(*(wanted := self.practise()))
            results = {shots: self.test(shots, wanted[0]) for shots in self.config.shots}
            curve = learning_curve(self.config.learner, self.config.split, results)
            curve.write(self.folder / SUMMARY)
        return curve

    def hold(self, held: ExitStack) -> None:
        """Hold the folder against a second run, as long as `held` is open."""
        try:
            held.enter_context(hold(self.folder))
        except DatasetConflict as error:
            raise ChallengeConflict(
                f"Another run in '{self.folder}' is under way. Wait for it, or choose another one."
            ) from error

    def begin(self, resume: bool) -> None:
        """Write what the run is, or compare it with what is there."""
        path, head = self.folder / HEAD, json.loads(json.dumps(self._head()))
        if path.is_file():
            if not resume:
                raise ChallengeConflict(
                    f"'{self.folder}' holds a run of the challenge. Go on with `--resume`, or choose another folder."
                )
            with storing(path):
                then = json.loads(path.read_text(encoding="utf-8"))
            for name in sorted({*then, *head} - set(_LATER)):
                if then.get(name) != head.get(name):
                    raise ChallengeConflict.between(path, name, then.get(name), head.get(name))
            return
        write_whole(path, (json.dumps(head, indent=1) + "\n").encode())

    def practise(self) -> tuple[PolicySettings, Pictures]:
        """Let the learner practise, unless it has; return what it asks for, and which frames of demonstrations need pictures."""
        path, tasks = self.folder / LEARNED, self.config.tasks().train
        with closing(open_learner(self.config, self.folder)) as learner:
            wanted = learner.settings, learner.wanted_pictures()
            if not path.is_file():
                self.watch(ChallengeProgress("practising", 1, 0))
                write_learned(path, learner.meta_train(tasks, self.config.robot, self.config.train_limit))
                self.watch(ChallengeProgress("practising", 1, 1))
        return wanted

    def demonstrate(self, settings: PolicySettings, pictures: Pictures) -> None:
        """Make the demonstrations that are missing."""
        shown = ShownDemonstrations(self.folder / DEMONSTRATIONS)
        wanted = max(self.config.shots) * len(self.config.tasks().test)
        done = wanted - len(shown.missing(self.config))
        self.watch(ChallengeProgress("demonstrations", wanted, done))

        def one_more(item: ShownItem) -> None:
            nonlocal done
            done += 1
            self.watch(ChallengeProgress("demonstrations", wanted, done, latest=item.task))

        if shown.make(self.config, (settings, pictures), self.engine, one_more, self.stop):
            raise ChallengeStopped("demonstrations", done, wanted, self.folder)

    def test(self, shots: int, settings: PolicySettings) -> Results:
        """Test with so many demonstrations."""
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
        return {"format": 1, **asdict(self.config), "train": tasks.train, "test": tasks.test, **versions}
