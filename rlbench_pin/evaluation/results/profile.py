"""Profile of a policy over factors of generalisation: success at each level, and the difference to success without factors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation.results.comparison import Comparison, compare
from rlbench_pin.evaluation.results.records import Results
from rlbench_pin.evaluation.results.statistics import Estimate, Summary, summarise
from rlbench_pin.evaluation.results.tables import Table
from rlbench_pin.values import as_record

BASE = "none"
"""Name of the episodes without factors."""


@dataclass(frozen=True)
class FactorRow:
    """Results of one setting of factors."""

    setting: str
    """Setting, such as `light_color:2`."""
    tasks: int
    """Number of tasks that the setting can change."""
    summary: Summary
    """Success with the factors."""
    base: Summary
    """Success of the same episodes without factors."""
    comparison: Comparison
    """Paired comparison, episode by episode; the first is without factors."""


@dataclass(frozen=True)
class Profile:
    """Success of a policy by factor and level. There is no mean over different factors."""

    policy: str
    trained_on: str
    """Factors in the training data, as the user stated them."""
    base: Summary
    """Statistics of all episodes without factors."""
    rows: tuple[FactorRow, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        rows = [
            {
                "factors": row.setting,
                "tasks": row.tasks,
                "episodes": row.summary.episodes,
                "success": row.summary.success.as_dict(),
                "without": row.base.success.as_dict(),
                "difference": row.comparison.difference.as_dict(),
                "p_exact": row.comparison.pairs.p.exact,
            }
            for row in self.rows
        ]
        return {"trained_on": self.trained_on, "none": self.base.success.as_dict(), "factors": rows}


def factor_profile(results: Results) -> Profile:
    """Return the profile of an evaluation with factors.

    Args:
        results: Results of `evaluate` with settings of factors.

    Raises:
        InvalidValue: The evaluation had no factors.
    """
    if not as_record(results, Results, "results").factors:
        raise InvalidValue("results", results.policy, "were made without factors", "Evaluate with `--factors NAME:LEVEL`.")
    base = results.of_factors("")
    rows = tuple(_row(base, results.of_factors(setting), setting) for setting in results.factors)
    return Profile(results.policy, results.trained_on, _summary(base), rows)


def _row(base: Results, changed: Results, setting: str) -> FactorRow:
    same = replace(
        base,
        tasks=changed.tasks,
        episodes=tuple(e for e in base.episodes if e.task in changed.tasks),
        task_versions=changed.task_versions,
    )
    comparison = compare(same, changed, np.random.default_rng(0))
    return FactorRow(setting, len(changed.tasks), _summary(changed), _summary(same), comparison)


def _summary(results: Results) -> Summary:
    return summarise(results, np.random.default_rng(0))


def profile_table(profile: Profile) -> Table:
    """Return the table of a profile: one row without factors, then one row for each setting."""
    as_record(profile, Profile, "profile")
    head = ("factors", "tasks", "episodes", "success", "95 %", "without", "difference", "95 %", "p")
    base = profile.base
    rows = [(BASE, str(len(base.tasks)), str(base.episodes), _percent(base.success), _span(base.success), "", "", "", "")]
    for row in profile.rows:
        d, p = row.comparison.difference, row.comparison.pairs.p.exact
        success = (_percent(row.summary.success), _span(row.summary.success), _percent(row.base.success))
        paired = (f"{100 * d.value:+.1f}", f"{100 * d.low:+.1f} to {100 * d.high:+.1f}", f"{p:.4f}" if p >= 1e-4 else f"{p:.1e}")
        rows.append((row.setting, str(row.tasks), str(row.summary.episodes), *success, *paired))
    notes = (
        "Success: mean over tasks. Without: the same episodes without factors. Difference: points, paired on the same seeds; "
        "p of McNemar's test, not corrected for several factors.",
        f"Factors in the training data: {profile.trained_on or 'not stated'}.",
    )
    return Table(f"{profile.policy}: factors of generalisation", head, tuple(rows), notes)


def _percent(estimate: Estimate) -> str:
    return f"{100 * estimate.value:.1f} %"


def _span(estimate: Estimate) -> str:
    return f"{100 * estimate.low:.1f} to {100 * estimate.high:.1f}"
