"""Results of the trials of a check: one class of records for each part of the check."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar, Self, TypeVar

from rlbench_pin.checking.plan import Part
from rlbench_pin.checking.reach import Reach
from rlbench_pin.checking.validate import NoopEpisode
from rlbench_pin.environment.demos import SegmentReport


@dataclass(frozen=True)
class Incident:
    """An error or a failure in a trial."""

    cause: str
    attempt: int = 0
    """Attempt of the seed, from 0."""
    waypoint: int | None = None
    """Waypoint at which it happened, where there is one."""
    group: str = ""
    """Incidents of one group are counted together. When empty, incidents whose causes differ only in numbers are."""


@dataclass(frozen=True, kw_only=True)
class Trial:
    """Fields that the records of all parts have."""

    part: ClassVar[Part]
    task: str
    seed: int
    variation: int
    error: str = ""
    """Unexpected error of the task; the trial then has no result."""

    @classmethod
    def without_start(cls, task: str, seed: int, variation: int, why: str) -> Self:
        """Return the record of a trial for which no start state was found."""
        return cls(task=task, seed=seed, variation=variation, error=why)

    def incidents(self) -> Iterator[Incident]:
        """Yield the errors and failures."""
        if self.error:
            yield Incident(self.error)


@dataclass(frozen=True, kw_only=True)
class WordsTrial(Trial):
    """The instructions of one variation."""

    part = "words"
    instructions: tuple[str, ...] = ()


@dataclass(frozen=True)
class FailedAttempt:
    """An attempt at a demonstration that failed."""

    cause: str
    waypoint: int | None
    """Waypoint at which it failed, None before the first."""


@dataclass(frozen=True)
class Cost:
    """Time that a reset and a demonstration took."""

    wall: float = 0.0
    """Wall time [s]."""
    process: float = 0.0
    """Process time [s]."""
    planning: float = 0.0
    """Process time of planning [s]."""
    physics: float = 0.0
    """Process time of simulation [s]."""
    observing: float = 0.0
    """Process time of observations [s]."""
    ticks: int = 0
    """Control ticks simulated."""


@dataclass(frozen=True, kw_only=True)
class SolvedDemo:
    """A demonstration that reached the goal."""

    frames: int
    simulated: float
    """Length [s]."""
    replayed: bool | None
    """Whether the recorded joint-position actions reach the goal again; None when they were not replayed."""
    stable: bool = False
    """Whether success still held after 1 s with the arm stationary and the gripper unchanged."""
    left_over: tuple[str, ...] = ()
    """Differences that this episode caused in the next one."""
    segments: tuple[SegmentReport, ...] = ()
    """Planning and length of each segment."""
    cost: Cost = Cost()

    def incidents(self, attempt: int) -> Iterator[Incident]:
        """Yield the failures after the demonstration, the successful `attempt` of its seed."""
        if self.replayed is False:
            yield Incident("replay: goal not reached", attempt)
        if self.left_over:
            yield Incident(f"left over: {', '.join(self.left_over)}", attempt, group="left over")


@dataclass(frozen=True, kw_only=True)
class DemoTrial(Trial):
    """A seed whose demonstration was attempted until one succeeded or the attempts were used up."""

    part: ClassVar[Part] = "demos"
    failed: tuple[FailedAttempt, ...] = ()
    """The attempts that failed, in order."""
    demo: SolvedDemo | None = None
    """The attempt after them, which succeeded; None when all failed."""
    other_plans: bool | None = None
    """Whether plans with other random draws solve the scene of the first attempt, which failed; None when not planned again."""

    @classmethod
    def without_start(cls, task: str, seed: int, variation: int, why: str) -> Self:
        """Return the record of a seed for which no start state was found: a failed attempt, not an error."""
        return cls(task=task, seed=seed, variation=variation, failed=(FailedAttempt(why, None),))

    @property
    def solved(self) -> bool:
        """Whether an attempt succeeded."""
        return self.demo is not None

    @property
    def solved_at_first(self) -> bool:
        """Whether the first attempt succeeded."""
        return self.solved and not self.failed

    @property
    def solved_in_first_scene(self) -> bool:
        """Whether the scene of the first attempt was solved, by its first plan or by another."""
        return self.solved_at_first or bool(self.other_plans)

    def incidents(self) -> Iterator[Incident]:
        """Yield the failed attempts, then the failures after the successful one."""
        for attempt, failed in enumerate(self.failed):
            yield Incident(failed.cause, attempt, failed.waypoint)
        yield from super().incidents()
        if self.demo is not None:
            yield from self.demo.incidents(len(self.failed))


@dataclass(frozen=True, kw_only=True)
class UnseenTrial(DemoTrial):
    """The same for a seed that was not used while the task was made; these are counted separately."""

    part = "unseen"


@dataclass(frozen=True, kw_only=True)
class RepeatTrial(Trial):
    """A reset and a demonstration, each done twice from the same seed."""

    part = "repeat"
    differing: tuple[str, ...] = ()
    """`reset` and `demonstration`, where the repetition was not byte-identical."""

    @property
    def repeats(self) -> bool:
        """Whether both were byte-identical."""
        return not self.differing and not self.error

    def incidents(self) -> Iterator[Incident]:
        """Yield what was not byte-identical."""
        yield from (Incident(f"{what}: not the same bytes twice") for what in self.differing)
        yield from super().incidents()


@dataclass(frozen=True, kw_only=True)
class NoopTrial(Trial):
    """An episode of the no-op policy."""

    part = "noop"
    episode: NoopEpisode | None = None

    @property
    def reached_goal(self) -> bool:
        """Whether it reached the goal, which is a fault."""
        return self.episode is not None and self.episode.success

    def incidents(self) -> Iterator[Incident]:
        """Yield the error, or that the goal was reached."""
        yield from super().incidents()
        if self.reached_goal:
            yield Incident("noop: goal reached")


@dataclass(frozen=True, kw_only=True)
class RandomTrial(Trial):
    """An episode of random actions."""

    part = "random"
    reached_goal: bool = False
    """Whether the actions reached the goal, which is a fault."""

    def incidents(self) -> Iterator[Incident]:
        """Yield the error, or that the goal was reached."""
        yield from super().incidents()
        if self.reached_goal:
            yield Incident("random: goal reached")


@dataclass(frozen=True, kw_only=True)
class ReachTrial(Trial):
    """One random layout of the task, and which waypoints the arm reaches in it."""

    part = "reach"
    reach: Reach | None = None
    no_place: str = ""
    """Why the layout failed; a reset would draw another layout. Empty otherwise."""

    @classmethod
    def without_start(cls, task: str, seed: int, variation: int, why: str) -> Self:
        """Return the record of a layout that failed, which is not an error."""
        return cls(task=task, seed=seed, variation=variation, no_place=why)

    @property
    def reachable(self) -> bool:
        """Whether every waypoint is in reach and the arm is free."""
        return self.reach is not None and self.reach.accepted

    def incidents(self) -> Iterator[Incident]:
        """Yield why the layout failed, or the error."""
        if self.no_place:
            yield Incident(self.no_place)
        yield from super().incidents()


@dataclass(frozen=True, kw_only=True)
class KeyFramesTrial(Trial):
    """The key frames of a demonstration, executed alone through planning."""

    part = "key_frames"
    reached_goal: bool | None = None
    """Whether they reached the goal; None without a demonstration."""
    refused: str = ""
    """Why a key frame was not executed."""

    def incidents(self) -> Iterator[Incident]:
        """Yield the error, or why the goal was missed."""
        yield from super().incidents()
        if self.reached_goal is False:
            yield Incident(f"key frames: {self.refused or 'goal not reached'}")


@dataclass(frozen=True, kw_only=True)
class FrictionTrial(Trial):
    """One attempt at a demonstration in which friction alone holds what is grasped."""

    part = "friction_only"
    reached_goal: bool | None = None
    """Whether it reached the goal; None in an episode without graspable objects, which is not attempted."""
    failed: tuple[FailedAttempt, ...] = ()
    """The attempt, when it failed."""

    @classmethod
    def without_start(cls, task: str, seed: int, variation: int, why: str) -> Self:
        """Return the record of a seed for which no start state was found: a failed attempt, not an error."""
        return cls(task=task, seed=seed, variation=variation, reached_goal=False, failed=(FailedAttempt(why, None),))

    def incidents(self) -> Iterator[Incident]:
        """Yield the error, or why the goal was missed."""
        yield from super().incidents()
        for failed in self.failed:
            yield Incident(f"friction only: {failed.cause}", waypoint=failed.waypoint)


KINDS: tuple[type[Trial], ...] = (
    WordsTrial,
    DemoTrial,
    UnseenTrial,
    RepeatTrial,
    NoopTrial,
    RandomTrial,
    ReachTrial,
    KeyFramesTrial,
    FrictionTrial,
)
RECORDS: dict[Part, type[Trial]] = {kind.part: kind for kind in KINDS}
"""Part of the check -> its record."""

Kind = TypeVar("Kind", bound=Trial)


def of_kind(trials: Iterable[Trial], kind: type[Kind]) -> list[Kind]:
    """Return the trials of one part of the check."""
    return [trial for trial in trials if isinstance(trial, kind) and trial.part == kind.part]


def ordered(trials: Iterable[Trial]) -> list[Trial]:
    """Sort trials, so that a report does not depend on the order in which workers finish."""
    return sorted(trials, key=lambda trial: (trial.task, trial.part, trial.seed))
