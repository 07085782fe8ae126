"""Sums up how controllers followed legs: one record per controller, and a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.evaluation.controllers.trials import PLAN, LegTrial
from rlbench_pin.values import as_record, as_several


@dataclass(frozen=True)
class ControllerSummary:
    """How one controller followed the legs of one kind."""

    controller: str
    """Name of the controller, or `PLAN`."""
    kind: str
    """`free` or `contact`."""
    legs: int
    """Legs that it followed."""
    tip_median_mm: float
    """Median distance of the tip from the reference [mm]."""
    tip_max_mm: float
    """Largest distance of the tip from the reference [mm]."""
    joint_median_mrad: float
    """Median of the largest joint error [mrad]."""
    joint_max_mrad: float
    """Largest joint error [mrad]."""
    end_max_mm: float
    """Largest error of the tip at the end of a leg, a second for arriving included."""
    overtime_median_s: float
    """Time until arrival (at rest within 1 mm) after the planned end, median, a second at most [s]."""
    overtime_max_s: float
    """Longest time until arrival [s]."""
    violations: dict[str, int]
    """Ticks beyond the limits of joint position, velocity, acceleration."""
    ticks: int
    """Control ticks in all."""
    touched: int
    """Legs on which something was touched that was not touched at the start."""
    clearance_mm: float | None
    """Smallest distance to the world as it stood at the start of a leg; None where nothing is near [mm]."""
    interventions: float
    """Share of commands that a safety filter changed."""
    stops: float
    """Share of commands that were braking, because the controller found no solution."""
    median_us: float
    """Median cost of a command [us]."""
    p99_us: float
    """99th percentile of the cost of a command [us]."""


def summarise_legs(trials: Sequence[LegTrial]) -> list[ControllerSummary]:
    """Return one summary per controller and kind of leg, free legs first, controllers in the order they came."""
    for trial in as_several(trials, "trials"):
        as_record(trial, LegTrial, "A trial")
    names = tuple(dict.fromkeys(t.controller for t in trials))
    groups = [
        (name, free, [t for t in trials if t.controller == name and t.leg.free == free])
        for free in (True, False)
        for name in names
    ]
    return [_summary(name, "free" if free else "contact", group) for name, free, group in groups if group]


def _summary(name: str, kind: str, trials: Sequence[LegTrial]) -> ControllerSummary:
    tip, joint = (np.concatenate([getattr(t, key) for t in trials]) for key in ("tip_errors", "joint_errors"))
    seconds = np.concatenate([t.seconds for t in trials])
    nearest, overtimes, commands = min(t.clearance for t in trials), [t.overtime for t in trials], max(1, len(seconds))
    median, p99 = np.percentile(seconds, (50, 99)) if len(seconds) else (0.0, 0.0)
    return ControllerSummary(
        controller=name,
        kind=kind,
        legs=len(trials),
        tip_median_mm=_thousandths(np.median(tip)),
        tip_max_mm=_thousandths(tip.max()),
        joint_median_mrad=_thousandths(np.median(joint)),
        joint_max_mrad=_thousandths(joint.max()),
        end_max_mm=_thousandths(max(t.tip_errors[-1] for t in trials)),
        overtime_median_s=round(float(np.median(overtimes)), 3),
        overtime_max_s=round(max(overtimes), 3),
        violations={key: sum(t.violations[key] for t in trials) for key in trials[0].violations},
        ticks=0 if name == PLAN else len(tip),
        touched=sum(bool(t.touched) for t in trials),
        clearance_mm=_thousandths(nearest) if math.isfinite(nearest) else None,
        interventions=round(sum(t.interventions for t in trials) / commands, 4),
        stops=round(sum(t.stops for t in trials) / commands, 4),
        median_us=round(1e6 * float(median), 1),
        p99_us=round(1e6 * float(p99), 1),
    )


def _thousandths(value: float) -> float:
    return round(1e3 * float(value), 3)


HEADER = (
    "controller", "legs", "tip mm", "joint mrad", "end mm", "overtime s", "violations",
    "touched", "clearance mm", "filtered", "stops", "us", "p99 us",
)  # fmt: skip


def table(summaries: Sequence[ControllerSummary]) -> str:
    """Return a Markdown table of summaries; errors as median / maximum, violations as position / velocity / acceleration."""
    for summary in as_several(summaries, "summaries"):
        as_record(summary, ControllerSummary, "A summary")
    rows = [HEADER, *map(_row, summaries)]
    widths = [max(map(len, column)) for column in zip(*rows)]
    rows.insert(1, tuple("-" * width for width in widths))
    return "\n".join("| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |" for row in rows)


def _row(s: ControllerSummary) -> tuple[str, ...]:
    clearance = "" if s.clearance_mm is None else f"{s.clearance_mm:.1f}"
    if s.controller == PLAN:
        return (s.controller, str(s.legs), *[""] * 6, clearance, *[""] * 4)
    return (
        s.controller,
        str(s.legs),
        f"{s.tip_median_mm:.2f} / {s.tip_max_mm:.1f}",
        f"{s.joint_median_mrad:.2f} / {s.joint_max_mrad:.1f}",
        f"{s.end_max_mm:.2f}",
        f"{s.overtime_median_s:.2f} / {s.overtime_max_s:.2f}",
        " / ".join(str(count) for count in s.violations.values()),
        str(s.touched),
        clearance,
        f"{s.interventions:.1%}",
        f"{s.stops:.1%}",
        f"{s.median_us:.0f}",
        f"{s.p99_us:.0f}",
    )
