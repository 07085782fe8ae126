"""Evaluation of a policy: plan the episodes, run them by an engine, keep records in a journal, and write the results file.

Workers write nothing. The process that calls `evaluate` writes every finished episode to a journal, so that `resume` continues
after any interruption. Results files are byte-identical for any number of workers.
"""

from __future__ import annotations

import json
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from rlbench_pin.environment.demos import library_versions
from rlbench_pin.errors import InvalidValue, RlbenchPinError, shown
from rlbench_pin.evaluation.policies.references import IN_PROCESS
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.protocols.plan import check_policy
from rlbench_pin.evaluation.results.records import WORKER_DIED, EpisodeRecord, Results, read_results, write_results
from rlbench_pin.evaluation.run.config import EXPERT, LIMITS, EpisodeItem, EvaluationConfig, plan_episodes
from rlbench_pin.evaluation.run.episode import EpisodeOutcome
from rlbench_pin.evaluation.run.provenance import checkout_commit, policy_digests, times_path, write_times
from rlbench_pin.evaluation.run.runner import EpisodeRunner, not_played
from rlbench_pin.processes import Engine, GivenUp, Journal, JournalInUse, ProcessEngine, WorkerDeath, exclusive, run_jobs
from rlbench_pin.processes.jobs import MAX_DEATHS, first_line
from rlbench_pin.tasks import find_task, task_scene
from rlbench_pin.values import as_flag, as_function, as_path, as_record

_JOURNAL_FORMAT = 2


@dataclass(frozen=True)
class EvaluationProgress:
    """Progress of an evaluation."""

    wanted: int
    """Number of episodes of the whole evaluation."""
    found: int
    """Number of episodes that were played before this run."""
    done: int = 0
    """Number of episodes that this run has played."""
    successes: int = 0
    """Number of played episodes with success."""
    faults: int = 0
    """Number of played episodes that a fault ended."""
    deaths: int = 0
    """Number of workers that died and were replaced."""
    latest: EpisodeOutcome | None = None
    """The last finished episode; None at the start."""

    def with_outcome(self, outcome: EpisodeOutcome) -> EvaluationProgress:
        """Return the progress after one more episode."""
        successes, faults = self.successes + outcome.record.success, self.faults + bool(outcome.record.fault)
        return replace(self, done=self.done + 1, successes=successes, faults=faults, latest=outcome)


OnProgress = Callable[[EvaluationProgress], None]
"""Called with the progress of the evaluation."""


class EvaluationConflict(RlbenchPinError):
    """The results file or the journal belongs to another evaluation, or exists already."""


class EvaluationStopped(RlbenchPinError):
    """An evaluation was stopped before its end; finished episodes are kept."""

    def __init__(self, done: int, wanted: int, path: Path | str) -> None:
        self.done, self.wanted, self.path = done, wanted, Path(path)
        super().__init__(f"{done} of {wanted} episodes are played and kept in '{path}'. Continue with `--resume`.")


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
    """Evaluate a policy, and write the results file and a file of action times next to it.

    If a worker dies in an episode of `noop`, `random` or `expert`, the episode is repeated, up to three times. Any other policy
    may have ended the worker itself, so its episode fails and is not repeated.

    Args:
        config: Policy, tasks, episodes and limits.
        out: Path of the results file, such as `x.json`. Until the end, the journal `x.journal.jsonl` is next to it.
        engine: Engine that runs the episodes; None takes one process.
        resume: True continues an evaluation that was interrupted; if `out` is complete, it is read and returned. False requires
            that neither `out` nor a journal with episodes exists.
        on_progress: Function that is called with the progress, once before the first episode and after every event.
        stop: When this event is set, no further episode starts; running episodes are finished and kept.
        make_runner: Picklable function that makes the runner of a worker process from `config`.

    Returns:
        The results, as they are in the file.

    Raises:
        EvaluationConflict: `out` or its journal exists and `resume` is False, or it belongs to another evaluation.
        EvaluationStopped: `stop` was set before all episodes were finished.
        PolicyOfAnotherArm: The policy was made for the joints of another arm.
        ProtocolConflict: The settings of the policy contradict the protocol.
        PolicyFault: The policy does not start.
        PolicyReferenceError: The reference names no policy.
        UnknownName: No policy or task has this name.
        StorageError: The disk cannot be written to. Finished episodes are kept.
    """
    config, out = as_record(config, EvaluationConfig, "config"), as_path(out, "out")
    engine = ProcessEngine() if engine is None else as_record(engine, Engine, "engine")  # type: ignore[type-abstract]
    stop = threading.Event() if stop is None else as_record(stop, threading.Event, "stop")
    as_function(on_progress, "on_progress")
    if not callable(make_runner):
        raise InvalidValue("make_runner", make_runner, "has to be a function that makes an EpisodeRunner")
    config = _with_key(config, out, as_flag(resume, "resume"))
    with make_runner(config) as runner:
        _check_out(out, resume)
        settings = runner.settings()
    if config.protocol is not None:
        check_policy(config.protocol, config.policy, settings)
    items = plan_episodes(config)
    empty = empty_results(config, settings, items)
    if out.exists():
        return _finished(out, empty)
    path = journal_path(out)
    with _exclusive(path):
        journal = EpisodeJournal(path, _head(empty, items), resume)
        outcomes = {outcome.item: outcome for outcome in journal.found(items)}
        watch = on_progress or (lambda progress: None)
        records = [outcome.record for outcome in outcomes.values()]
        successes, faults = sum(r.success for r in records), sum(bool(r.fault) for r in records)
        progress = EvaluationProgress(len(items), len(outcomes), successes=successes, faults=faults)
        watch(progress)
        todo = [item for item in items if item not in outcomes]
        worker, deaths = partial(make_runner, config), Counter[EpisodeItem]()
        max_deaths = MAX_DEATHS if config.policy.partition("?")[0] in (*IN_PROCESS, EXPERT) else 1

        def keep(outcome: EpisodeOutcome) -> None:
            record = replace(outcome.record, worker_deaths=deaths[outcome.item])
            outcomes[outcome.item] = replace(outcome, record=record)
            journal.add(outcomes[outcome.item])

        for event in run_jobs(todo, worker, store=keep, lost=lost_outcome, engine=engine, stop=stop, max_deaths=max_deaths):
            if isinstance(event, WorkerDeath):
                deaths[event.item] += 1
                progress = replace(progress, deaths=progress.deaths + 1)
            else:
                progress = progress.with_outcome(outcomes[event.item])
            watch(progress)
        if len(outcomes) < len(items):
            raise EvaluationStopped(len(outcomes), len(items), path)
        ordered = [outcomes[item] for item in items]
        write_times(times_path(out), config, ordered)
        results = replace(empty, episodes=tuple(outcome.record for outcome in ordered))
        write_results(out, results)
        path.unlink(missing_ok=True)
    return results


def journal_path(out: Path) -> Path:
    """Return the path of the journal of a running evaluation: `x.journal.jsonl` next to `x.json`."""
    return out.with_name(f"{out.stem}.journal.jsonl")


def empty_results(config: EvaluationConfig, settings: PolicySettings, items: Sequence[EpisodeItem]) -> Results:
    """Return the results of an evaluation without its episodes."""
    names = tuple(dict.fromkeys(item.name for item in items))
    found_by = {item.name: item.task for item in items}
    return Results(
        policy=config.policy,
        settings=settings.plain(),
        task_set=config.task_set or " ".join(names),
        tasks=names,
        seeds=config.seeds(),
        limits={name: getattr(config, name) for name in LIMITS},
        versions=library_versions(),
        commit=checkout_commit(),
        episodes=(),
        policy_seed_key=config.policy_seed_key or "",
        protocol=config.protocol,
        factors=config.factors,
        trained_on=config.trained_on,
        task_versions={name: task_scene(find_task(task)).version for name, task in found_by.items()},
    )


def _head(empty: Results, items: Sequence[EpisodeItem]) -> dict[str, Any]:
    """Return the data that identify the evaluation of a journal."""
    content = {name: value for name, value in empty.content().items() if name not in ("format", "episodes", "seeds")}
    tasks = {item.name: item.task_digest for item in items if item.task_digest}
    return {**content, "task_files": tasks, "policy_files": policy_digests(empty.policy)}


def _with_key(config: EvaluationConfig, out: Path, resume: bool) -> EvaluationConfig:
    """Return the settings with the key of the run to resume; otherwise a new key is drawn."""
    if config.policy_seed_key is None and resume:
        if out.is_file():
            return replace(config, policy_seed_key=read_results(out).policy_seed_key)
        key = (first_line(journal_path(out)) or {}).get("policy_seed_key")
        if isinstance(key, str):
            return replace(config, policy_seed_key=key)
    return config.with_key()


def _check_out(out: Path, resume: bool) -> None:
    if out.is_dir() or not out.name:
        raise EvaluationConflict(f"'{out}' is a folder, but results are one file. Name a file in it.")
    if out.exists() and not resume:
        raise EvaluationConflict(f"'{out}' exists already. Delete it, or choose another file for the results.")


def _finished(out: Path, empty: Results) -> Results:
    """Return the existing results if they are those of this evaluation; otherwise raise EvaluationConflict."""
    results = read_results(out)
    before, here = (r.content() for r in (replace(results, episodes=()), empty))
    for name in dict.fromkeys((*here, *before)):
        if name != "format" and (then := before.get(name)) != (now := here.get(name)):
            raise EvaluationConflict(
                f"'{out}' contains results of another evaluation: it has {name} = {shown(then)}, but this one has "
                f"{name} = {shown(now)}. Choose another file."
            )
    return results


def lost_outcome(given_up: GivenUp[EpisodeItem]) -> EpisodeOutcome:
    """Return the outcome of an episode that is given up because too many workers died."""
    return EpisodeOutcome(given_up.item, not_played(given_up.item, WORKER_DIED, given_up.cause))


class EpisodeJournal:
    """The finished episodes of one evaluation: a first line that describes the evaluation, then a line per episode.

    Args:
        path: The file.
        head: Describes the evaluation, as plain data.
        resume: Use the episodes of the file; otherwise it must be empty.

    Raises:
        EvaluationConflict: The file contains episodes and `resume` is False, or episodes of another evaluation.
        StorageError: The file cannot be read or written.
    """

    def __init__(self, path: Path, head: Mapping[str, Any], resume: bool) -> None:
        self._journal = Journal(path)
        head = json.loads(json.dumps({"format": _JOURNAL_FORMAT, **head}))
        lines = self._journal.lines
        if lines and lines[0] is None:
            raise EvaluationConflict(f"'{path}' is not a journal of an evaluation. Delete it, or choose another file.")
        if len(lines) == 1 and not resume:  # no episode was played: start again
            self._journal.clear()
            lines = self._journal.lines
        if lines and not resume:
            raise EvaluationConflict(
                f"'{path}' contains {len(lines) - 1} episodes of an unfinished evaluation. Continue with `--resume`, "
                "delete the file, or choose another one for the results."
            )
        if lines:
            _check_head(path, lines[0] or {}, head)
        else:
            self._journal.append(head)
        self._lines = {_key(line): line for line in lines[1:] if line and _key(line) is not None}

    def found(self, items: Sequence[EpisodeItem]) -> list[EpisodeOutcome]:
        """Return the outcomes of the items that were played before."""
        outcomes = (self._outcome(item) for item in items)
        return [outcome for outcome in outcomes if outcome is not None]

    def _outcome(self, item: EpisodeItem) -> EpisodeOutcome | None:
        line = self._lines.get(item.key)
        if line is None:
            return None
        try:
            return EpisodeOutcome(item, EpisodeRecord(**line["record"]), tuple(float(t) for t in line["times"]))
        except (InvalidValue, RlbenchPinError, KeyError, TypeError, ValueError):  # damaged: it is played again
            return None

    def add(self, outcome: EpisodeOutcome) -> None:
        """Append an episode, with its times in microseconds.

        Raises:
            StorageError: The disk cannot be written. Episodes that were added before are complete.
        """
        self._journal.append({"record": asdict(outcome.record), "times": [round(t, 6) for t in outcome.action_times]})


def _check_head(path: Path, before: Mapping[str, Any], head: Mapping[str, Any]) -> None:
    """Raise EvaluationConflict unless the first line of a journal is this head."""
    for name in sorted({*head, *before}):
        then, now = before.get(name), head.get(name)
        if then == now:
            continue
        if isinstance(then, dict) and isinstance(now, dict):
            names = [key for key in sorted({*then, *now}) if then.get(key) != now.get(key)]
            then, now = ({key: entries.get(key) for key in names} for entries in (then, now))
        raise EvaluationConflict(
            f"'{path}' was started with {name} = {shown(then)}, but this evaluation has {name} = {shown(now)}. Use the same, "
            "or choose another file for the results."
        )


def _key(line: Mapping[str, Any]) -> tuple[str, int, int, str] | None:
    record = line.get("record")
    if not isinstance(record, dict):
        return None
    task, variation, seed, factors = (record.get(name) for name in ("task", "variation", "seed", "factors"))
    if not isinstance(task, str) or type(variation) is not int or type(seed) is not int:
        return None
    return task, variation, seed, str(factors or "")


@contextmanager
def _exclusive(path: Path) -> Iterator[None]:
    try:
        with exclusive(path):
            yield
    except JournalInUse as error:
        raise EvaluationConflict(
            f"Another evaluation writes to '{path}'. Wait until it ends, or choose another file for the results."
        ) from error
