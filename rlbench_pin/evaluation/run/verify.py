"""Verification of a results file: play a sample of its episodes again, and compare them with the file."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial

import numpy as np

from rlbench_pin.errors import RlbenchPinError, shown
from rlbench_pin.evaluation.policies.references import IN_PROCESS
from rlbench_pin.evaluation.protocols.plan import check_policy
from rlbench_pin.evaluation.results.comparison import provenance_remarks
from rlbench_pin.evaluation.results.records import EpisodeRecord, Results, canonical
from rlbench_pin.evaluation.run.config import EXPERT, LIMITS, EpisodeItem, EvaluationConfig, plan_episodes
from rlbench_pin.evaluation.run.episode import EpisodeOutcome
from rlbench_pin.evaluation.run.evaluate import EvaluationProgress, empty_results, lost_outcome
from rlbench_pin.evaluation.run.runner import EpisodeRunner
from rlbench_pin.processes import Engine, ProcessEngine, run_jobs
from rlbench_pin.tasks import find_task, task_scene
from rlbench_pin.values import as_function, as_number, as_record, as_text

REPEATED = (*IN_PROCESS, EXPERT)
"""Policies that may run without being named by the user. Any other policy is code, which runs only if the user names it."""
_NO_KEY = "The file has no key of the policy's seeds, so a policy with random numbers acts differently."


class VerificationRefused(RlbenchPinError):
    """The episodes of a results file cannot be played again on this machine, or are not the episodes of its settings."""

    def __init__(self, policy: str, problem: str, advice: str) -> None:
        self.policy, self.problem = policy, problem
        super().__init__(f"The results of '{policy}' cannot be verified: {problem}. {advice}")


@dataclass(frozen=True)
class EpisodeDifference:
    """An episode whose new record differs from the file."""

    recorded: EpisodeRecord
    """Record in the file."""
    played: EpisodeRecord
    """Record of the repeated episode."""

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the fields that differ."""
        recorded, played = asdict(self.recorded), asdict(self.played)
        return tuple(name for name, value in recorded.items() if value != played[name])


@dataclass(frozen=True)
class Verification:
    """Result of a verification."""

    played: int
    """Number of episodes that were played again."""
    episodes: int
    """Number of episodes of the file."""
    differences: tuple[EpisodeDifference, ...]
    """Played episodes that differ, in the order of the file."""
    remarks: tuple[str, ...]
    """Different versions and commits of the file and of this run, which may explain the differences."""


def verify_results(
    results: Results,
    share: float,
    rng: np.random.Generator,
    *,
    policy: str = "",
    engine: Engine | None = None,
    on_progress: Callable[[EvaluationProgress], None] | None = None,
) -> Verification:
    """Play a random sample of the episodes of results again, and compare their records byte by byte.

    The number of workers that died is not compared: it depends on the machine.

    Args:
        results: The results, from `read_results`.
        share: Share of the episodes to play, 0 < share <= 1; at least one episode.
        rng: Random generator of the sample.
        policy: Reference of the policy. When empty, the policy of the results, which has to be `noop`, `random` or `expert`.
        engine: Runs the episodes; None uses one process.
        on_progress: Called with the progress, first before the first episode.

    Raises:
        VerificationRefused: The policy must be named or has other settings, the installed version of a task differs, or the
            episodes are not the episodes of the settings.
        UnknownName: A task is not installed.
        PolicyFault: The policy does not start.
    """
    results, share = as_record(results, Results, "results"), as_number(share, "share", above=0.0, most=1.0)
    as_record(rng, np.random.Generator, "rng")
    engine = ProcessEngine() if engine is None else as_record(engine, Engine, "engine")  # type: ignore[type-abstract]
    as_function(on_progress, "on_progress")
    _check_versions(results)
    config = _config(results, as_text(policy, "policy"))
    with EpisodeRunner(config) as runner:
        settings = runner.settings()
    _check_settings(results, settings.plain())
    if config.protocol is not None:
        check_policy(config.protocol, config.policy, settings)
    items, recorded = plan_episodes(config), {record.key: record for record in results.episodes}
    _check_episodes(results, items)
    count = math.ceil(share * len(items))
    sample = [items[i] for i in sorted(rng.choice(len(items), size=count, replace=False))]
    watch = on_progress or (lambda progress: None)
    progress = EvaluationProgress(count, 0)
    watch(progress)
    played: dict[EpisodeItem, EpisodeRecord] = {}
    worker = partial(EpisodeRunner, config)
    for event in run_jobs(sample, worker, store=lambda outcome: None, lost=lost_outcome, engine=engine):
        if isinstance(event, EpisodeOutcome):
            before = recorded[event.item.key]
            played[event.item] = replace(event.record, worker_deaths=before.worker_deaths)
            progress = progress.with_outcome(event)
            watch(progress)
    pairs = [(recorded[item.key], played[item]) for item in sample]
    differences = tuple(EpisodeDifference(before, now) for before, now in pairs if _bytes(before) != _bytes(now))
    remarks = provenance_remarks(results, empty_results(config, settings, items))
    return Verification(count, len(items), differences, (*remarks, *(() if results.policy_seed_key else (_NO_KEY,))))


def _config(results: Results, policy: str) -> EvaluationConfig:
    """Return the settings of the results, with the policy of the user if there is one."""
    if not policy and results.policy not in REPEATED:
        problem = f"their policy is code, and only {', '.join(REPEATED)} run without being named"
        raise VerificationRefused(results.policy, problem, "Check the policy, then name it with `--policy`.")
    if missing := [name for name in LIMITS if name not in results.limits]:
        advice = "Verify a file that `rlbench-pin evaluate` wrote."
        raise VerificationRefused(results.policy, f"their limits lack {', '.join(missing)}", advice)
    limits: dict[str, object] = {name: results.limits[name] for name in LIMITS}
    return EvaluationConfig(
        policy=policy or results.policy,
        tasks=results.tasks,
        task_set=results.task_set,
        policy_seed_key=results.policy_seed_key,
        protocol=results.protocol,
        factors=results.factors,
        trained_on=results.trained_on,
        **limits,  # type: ignore[arg-type]
    )


def _check_versions(results: Results) -> None:
    for task in results.tasks:
        here, there = task_scene(find_task(task)).version, results.version_of(task)
        if here != there:
            problem = f"task '{task}' has version {there} in the file, but version {here} is installed"
            raise VerificationRefused(results.policy, problem, "Verify them with the release that made them.")


def _check_settings(results: Results, settings: dict[str, object]) -> None:
    for name in dict.fromkeys((*results.settings, *settings)):
        if (there := results.settings.get(name)) != (here := settings.get(name)):
            problem = f"the policy has {name} = {shown(here)}, but the policy of the results has {shown(there)}"
            raise VerificationRefused(results.policy, problem, "Name the policy that was evaluated with `--policy`.")


def _check_episodes(results: Results, items: list[EpisodeItem]) -> None:
    planned, found = {item.key for item in items}, {record.key for record in results.episodes}
    for what, keys in (("lack", planned - found), ("have", found - planned)):
        if keys:
            first = ", ".join(str(part) for part in min(keys) if part != "")
            but = "of their settings" if what == "lack" else "that are not in their settings"
            advice = "Do not use the file; evaluate the policy again."
            raise VerificationRefused(results.policy, f"they {what} {len(keys)} episodes {but}, such as {first}", advice)


def _bytes(record: EpisodeRecord) -> bytes:
    return canonical(asdict(record))
