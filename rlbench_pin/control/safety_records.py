"""Settings of the safety filter, what it answers, and what it counts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

from rlbench_pin.control.qp.constraints import HOLDS, HeldQuantity
from rlbench_pin.errors import InvalidValue
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import NOT_NEGATIVE, POSITIVE, as_record, check_settings, counted, one_of, ruled

Reason = Literal["limits", "distance", "braking", "torque", "infeasible"]
"""Why a command was changed: joint limits; velocity dampers; the way to standstill was not clear, or took more torque than the
motors have; the QP had no solution."""

_RULES = ruled(
    (POSITIVE, "dt gain"),
    (NOT_NEGATIVE, "margin self_margin buffer influence recovery_speed limit_margin"),
    (one_of(*HOLDS), "hold"),
)


def _reasons(value: object, what: str) -> object:
    """Check reason -> count."""
    if not isinstance(value, dict) or not set(value) <= set(get_args(Reason)):
        problem = f"has to map reasons ({', '.join(get_args(Reason))}) to counts"
        raise InvalidValue(what, value, problem, "Leave it out to begin with none.")
    for reason, count in value.items():
        counted(0)(count, f"{what}['{reason}']")
    return value


_COUNT_RULES = ruled((counted(0), "ticks interventions solves stops"), (_reasons, "reasons"))


@dataclass(frozen=True, kw_only=True)
class SafetyConfig:
    """Settings of the safety filter."""

    dt: float = 0.05
    """Control tick [s]."""
    hold: HeldQuantity = "velocity"
    """Whether a commanded velocity is reached at once and held, linearly over the tick, or anywhere between."""
    margin: float = 0.01
    """Minimum distance to the world [m]."""
    self_margin: float = 0.005
    """Minimum distance between parts of the arm, and of what it holds [m]."""
    buffer: float = 0.003
    """The dampers begin this much before the minimum distance, so that curvature does not break it at once [m]."""
    gain: float = 5.0
    """Of the distance above the minimum, the share that may be lost per second [1/s]."""
    influence: float = 0.05
    """Pairs nearer than this always take part in the QP [m]."""
    recovery_speed: float = 0.05
    """Speed at which pairs below the minimum are made to separate, at most [m/s]."""
    limit_margin: float = 0.0
    """Distance kept from the joint position limits [rad]."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a number that is NaN, of a wrong kind, or outside its range (also a ValueError)."""
        check_settings(self, _RULES)


@dataclass(frozen=True, eq=False, slots=True)
class SafeCommand:
    """What the filter passes on, and why."""

    velocity: FloatArray
    """Joint velocity of the next tick (n,), [rad/s]."""
    wanted: FloatArray
    """Joint velocity that was asked for (n,), [rad/s]."""
    reasons: tuple[Reason, ...]
    """Empty when the wanted velocity passed unchanged."""
    pairs: tuple[tuple[str, str], ...]
    """What came too near, as names."""
    stopped: bool
    """Whether the command is the hardest braking, because nothing better was found."""

    @property
    def intervened(self) -> bool:
        """Whether the command differs from the wanted one."""
        return bool(self.reasons)

    def __str__(self) -> str:
        """Say what happened in words."""
        near = ", ".join(f"{a} near {b}" for a, b in self.pairs)
        return f"{' and '.join(self.reasons) or 'passed'}{f' ({near})' if near else ''}{', braking' if self.stopped else ''}"


@dataclass
class FilterCounts:
    """What a filter did so far."""

    ticks: int = 0
    """Commands in all."""
    interventions: int = 0
    """Commands that were changed."""
    solves: int = 0
    """QPs solved."""
    stops: int = 0
    """Commands that were the hardest braking."""
    reasons: dict[str, int] = field(default_factory=dict)
    """Reason -> number of commands that were changed for it."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a count that is no whole number, or a reason that there is not (also a ValueError)."""
        check_settings(self, _COUNT_RULES)

    def add(self, command: SafeCommand) -> None:
        """Count one command."""
        as_record(command, SafeCommand, "command")
        self.ticks += 1
        self.interventions += command.intervened
        self.stops += command.stopped
        for reason in command.reasons:
            self.reasons[reason] = self.reasons.get(reason, 0) + 1
