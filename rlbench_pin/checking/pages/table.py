"""The table that `rlbench-pin check` prints."""

from __future__ import annotations

from collections.abc import Sequence

from rlbench_pin.checking.report import TaskReport
from rlbench_pin.rates import Rate

HEADER = (
    "task", "var", "first try", "95 %", "in tries", "scene", "unseen", "lasts", "replay", "keys", "rest", "flail", "repeat",
    "reach", "drift", "overlap", "demo", "plan", "speed", "verdict",
)  # fmt: skip


def table(reports: Sequence[TaskReport]) -> str:
    """Return one line per task under a line of headings."""
    rows = [HEADER, *map(_row, reports)]
    widths = [max(map(len, column)) for column in zip(*rows)]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)


def _row(r: TaskReport) -> tuple[str, ...]:
    low, high = r.first_try.interval
    rates = (r.within_tries, r.same_scene, r.unseen, r.lasting, r.replay, r.key_frames, r.idle, r.random, r.repeat, r.accepted)
    return (
        r.task,
        str(len(r.variations)),
        _share(r.first_try),
        f"{low:.0%}..{high:.0%}",
        *map(_share, rates),
        f"{1000 * r.drift.value:.2f} mm",
        f"{1000 * r.penetration.value:.2f} mm",
        f"{r.simulated:.1f} s",
        f"{1000 * r.planning:.0f} ms",
        f"{r.speed.times_real_time:.1f} x",
        "; ".join(r.faults) or "ok",
    )


def _share(rate: Rate) -> str:
    return f"{rate.count}/{rate.of}"
