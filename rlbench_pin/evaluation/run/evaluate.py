"""Evaluating a policy: plan the episodes, give them to an engine, keep what comes back, write it when all is there.

Workers write nothing. The one process that calls `evaluate` keeps every finished episode in a journal, so whatever is killed, and
whenever, `resume` goes on where it ended; the results file is the same to the byte whoever plays, in whatever order.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from rlbench_pin.environment.demos import library_versions
from rlbench_pin.errors import RlbenchPinError, shown
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.results.records import Results, read_results, write_results
from rlbench_pin.evaluation.run.config import EpisodeItem, EvaluationConfig, plan_episodes
from rlbench_pin.evaluation.run.episode import EpisodeOutcome
from rlbench_pin.evaluation.run.journal import EvaluationConflict, Journal, OpenJournal
from rlbench_pin.evaluation.run.origin import checkout_commit
from rlbench_pin.evaluation.run.policy_files import policy_digests
from rlbench_pin.evaluation.run.runner import NOT_PLAYED, EpisodeRunner, not_played
from rlbench_pin.evaluation.run.times import times_path, write_times
from rlbench_pin.processes import Engine, GivenUp, ProcessEngine, WorkerDeath
from rlbench_pin.values import as_flag, as_function, as_path, as_record


@dataclass(frozen=True)
class EvaluationProgress:
    """How far an evaluation is."""

    wanted: int
    """Episodes of the whole evaluation."""
    found: int
    """Of these, played before."""
    done: int = 0
    """Of these, played now."""
    successes: int = 0
    """Of those found and done, with success."""
    faults: int = 0
    """Of those found and done, ended by a fault."""
    deaths: int = 0
    """Workers that died and were replaced."""
    latest: EpisodeOutcome | None = None
    """The episode that was finished last; None at the start."""

    def with_outcome(self, outcome: EpisodeOutcome) -> EvaluationProgress:
        """Return the progress after one more episode."""
        successes, faults = self.successes + outcome.record.success, self.faults + bool(outcome.record.fault)
        return replace(self, done=self.done + 1, successes=successes, faults=faults, latest=outcome)


OnProgress = Callable[[EvaluationProgress], None]
"""Called with how far the evaluation is."""


class EvaluationStopped(RlbenchPinError):
    """An evaluation was stopped before its end; what it has played is kept."""

    def __init__(self, done: int, wanted: int, path: Path | str) -> None:
        self.done, self.wanted, self.path = done, wanted, Path(path)
        super().__init__(f"{done} of {wanted} episodes are played and kept in '{path}'. Go on with `--resume`.")


def evaluate(
    config: EvaluationConfig,
    out: Path | str,
    *,
    engine: Engine | None = None,
    resume: bool = False,
    on_progress: OnProgress | None = None,
    stop: threading.Event | None = None,
    make_runner: Callable[[EvaluationConfig], EpisodeRunner] = EpisodeRunner,
) -> Results:
    """Evaluate a policy, write the results file and, beside it, that of the times.

    Args:
        config: What to evaluate.
        out: The results file. Until all is played, a journal lies beside it.
        engine: Who does the work; one process when None.
        resume: Go on with an evaluation that did not end; one that did is read. Otherwise there must be neither.
        on_progress: Called with how far it is, first before anything was played.
        stop: When set, nothing more is begun; what is under way is finished and kept.
        make_runner: Makes what plays in a worker, from `config`; it can be pickled.

    Raises:
        EvaluationConflict: There are results or a journal of something else where these are to be written.
        EvaluationStopped: `stop` was set before all was played.
        PolicyFault: The policy does not start; PolicyReferenceError, UnknownName: there is none, or no such task.
        StorageError: The disk cannot be written to. What was played before is kept.
    """
    config, out = as_record(config, EvaluationConfig, "config"), as_path(out, "out")
    engine = ProcessEngine() if engine is None else as_record(engine, Engine, "engine")  # type: ignore[type-abstract]
    stop = threading.Event() if stop is None else as_record(stop, threading.Event, "stop")
    as_function(on_progress, "on_progress")
    as_function(make_runner, "make_runner")
    work = _Work(config, make_runner, engine, on_progress or (lambda progress: None), stop)
    _check_out(out, as_flag(resume, "resume"))
    return _evaluated(work, out, resume)


@dataclass(frozen=True)
class _Work:
    """What is to be played, by whom, and who watches and stops it."""

    config: EvaluationConfig
    make_runner: Callable[[EvaluationConfig], EpisodeRunner]
    engine: Engine
    watch: OnProgress
    stop: threading.Event


def _evaluated(work: _Work, out: Path, resume: bool) -> Results:
    """Do what `evaluate` promises, with arguments that are checked."""
    config = work.config
    with work.make_runner(config) as runner:
        settings = runner.settings()
    items = plan_episodes(config)
    empty = empty_results(config, settings, items)
    if out.exists():
        return _finished(out, empty)
    with Journal(journal_path(out), _head(empty, items)).opened(resume) as journal:
        outcomes = _play(work, items, journal)
        if len(outcomes) < len(items):
            raise EvaluationStopped(len(outcomes), len(items), journal.path)
        write_times(times_path(out), config, outcomes)
        results = replace(empty, episodes=tuple(outcome.record for outcome in outcomes))
        write_results(out, results)
        journal.path.unlink(missing_ok=True)
    return results


def journal_path(out: Path) -> Path:
    """Return where the journal of an evaluation under way lies: `x.journal.jsonl` beside `x.json`."""
    return out.with_name(f"{out.stem}.journal.jsonl")


def empty_results(config: EvaluationConfig, settings: PolicySettings, items: Sequence[EpisodeItem]) -> Results:
    """Return the results of an evaluation without its episodes."""
    names = tuple(dict.fromkeys(item.name for item in items))
    limits = ("episodes", "seed", "max_steps", "max_seconds", "variations", "time_limit", "robot", "tell_task")
    return Results(
        policy=config.policy,
        settings=asdict(settings),
        task_set=config.task_set or " ".join(names),
        tasks=names,
        seeds=config.seeds(),
        limits={name: getattr(config, name) for name in limits},
        versions=library_versions(),
        commit=checkout_commit(),
        episodes=(),
    )


def _head(empty: Results, items: Sequence[EpisodeItem]) -> dict[str, Any]:
    """Return what decides whether the episodes of a journal are of this evaluation."""
    content = {name: value for name, value in empty.content().items() if name not in ("format", "episodes", "seeds")}
    tasks = {item.name: item.task_digest for item in items if item.task_digest}
    return {**content, "task_files": tasks, "policy_files": policy_digests(empty.policy)}


def _check_out(out: Path, resume: bool) -> None:
    if out.is_dir() or not out.name:
        raise EvaluationConflict(f"'{out}' is a folder; results are one file. Name a file in it.")
    if out.exists() and not resume:
        raise EvaluationConflict(f"'{out}' is there already. Delete it, or choose another file for the results.")


def _finished(out: Path, empty: Results) -> Results:
    """Return the results that are there, when they are those of this evaluation."""
    results = read_results(out)
    for name, then in replace(results, episodes=()).content().items():
        if then != (now := empty.content()[name]):
            raise EvaluationConflict(
                f"'{out}' holds results of another evaluation: there {name} = {shown(then)}, here {name} = {shown(now)}. "
                "Choose another file."
            )
    return results


def _play(work: _Work, items: Sequence[EpisodeItem], journal: OpenJournal) -> list[EpisodeOutcome]:
    """Play what the journal does not hold, keep it there, and return all that is played, in order."""
    outcomes = {outcome.item: outcome for outcome in journal.found(items)}
    records = [outcome.record for outcome in outcomes.values()]
    successes, faults = sum(r.success for r in records), sum(bool(r.fault) for r in records)
    progress = EvaluationProgress(len(items), len(outcomes), successes=successes, faults=faults)
    work.watch(progress)
    todo = [item for item in items if item not in outcomes]
    with closing(work.engine.map(partial(work.make_runner, work.config), todo, work.stop)) as events:
        for event in events:
            if isinstance(event, WorkerDeath):
                progress = replace(progress, deaths=progress.deaths + 1)
            else:
                outcome = _lost(event) if isinstance(event, GivenUp) else event
                journal.add(outcome)
                outcomes[outcome.item] = outcome
                progress = progress.with_outcome(outcome)
            work.watch(progress)
    return [outcomes[item] for item in items if item in outcomes]


def _lost(given_up: GivenUp[EpisodeItem]) -> EpisodeOutcome:
    """Return what is known of an episode that ended worker after worker."""
    return EpisodeOutcome(given_up.item, not_played(given_up.item, NOT_PLAYED, given_up.cause))
