"""Tables of results and comparisons, for a terminal or in Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rlbench_pin.evaluation.results.comparison import Comparison, Pairs
from rlbench_pin.evaluation.results.statistics import Estimate, Summary, TaskSummary, added_counts, width_note
from rlbench_pin.rates import Rate
from rlbench_pin.values import as_flag, as_record, as_several, as_text

MEAN = "mean over tasks"
ALL = "all"


@dataclass(frozen=True)
class Table:
    """A table with its title and notes."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()
    """Sentences below the table."""

    def text(self, markdown: bool = False) -> str:
        """Return the table as aligned text, or in Markdown.

        Args:
            markdown: Whether to use Markdown.
        """
        as_flag(markdown, "markdown")
        cells = [[printable(cell, markdown) for cell in row] for row in (self.head, *self.rows)]
        widths = [max(len(row[i]) for row in cells) for i in range(len(self.head))]
        lines = [_line(row, widths, markdown) for row in cells]
        rule = ["|" + "|".join("-" * (w + 2 - (i > 0)) + ":" * (i > 0) for i, w in enumerate(widths)) + "|"] if markdown else []
        title = [f"{'### ' * markdown}{printable(self.title, most=200)}", ""] if self.title else []
        notes = ["", *(printable(note, most=2000) for note in self.notes)] if self.notes else []
        return "\n".join([*title, lines[0], *rule, *lines[1:], *notes])


def printable(text: str, markdown: bool = False, most: int = 60) -> str:
    """Return a text from a file that is safe to print: no control characters, limited length, and no bars in a Markdown table.

    Args:
        text: A name, or a sentence.
        markdown: Whether it is for a table in Markdown.
        most: Maximum number of characters.
    """
    plain = "".join(letter if letter.isprintable() else "?" for letter in as_text(text, "text"))
    plain = plain if len(plain) <= most else f"{plain[: most - 3]}..."
    return plain.replace("|", "\\|") if markdown else plain


def _line(cells: Sequence[str], widths: Sequence[int], markdown: bool) -> str:
    padded = [cell.rjust(width) if i else cell.ljust(width) for i, (cell, width) in enumerate(zip(cells, widths))]
    return f"| {' | '.join(padded)} |" if markdown else "  ".join(padded).rstrip()


def task_table(summary: Summary) -> Table:
    """Return the table of an evaluation: one row per task and one for the mean."""
    as_record(summary, Summary, "summary")
    head = (
        "task",
        "episodes",
        "success",
        "95 %",
        "stable",
        "steps",
        "refused",
        "collisions",
        "force [N]",
        "violations",
        "faults",
    )
    rows = [_task_row(task) for task in summary.tasks]
    if len(summary.tasks) > 1:
        success = (_percent(summary.success.value), _span(summary.success), _percent(summary.stable.value))
        rows.append((MEAN, str(summary.episodes), *success, "", *_counts(summary.tasks, summary.episodes)))
    return Table(summary.policy, head, tuple(rows), tuple(_notes(summary)))


def overview_table(summaries: Sequence[Summary]) -> Table:
    """Return a table of the success of several evaluations: one row per task and one for the mean."""
    found = [as_record(summary, Summary, "A summary") for summary in as_several(summaries, "summaries")]
    by_task = [{task.task: task.success for task in summary.tasks} for summary in found]
    names = tuple(dict.fromkeys(name for rates in by_task for name in rates))
    rows = [(name, *(_rate(rates[name]) if name in rates else "" for rates in by_task)) for name in names]
    if len(names) > 1:
        rows.append((MEAN, *(f"{_percent(s.success.value)} ({_span(s.success)})" for s in found)))
    return Table("Success, with its 95 % interval", ("task", *(s.policy for s in found)), tuple(rows))


def comparison_table(comparison: Comparison) -> Table:
    """Return the table of a comparison: one row per task and one for all tasks."""
    as_record(comparison, Comparison, "comparison")
    head = ("task", "episodes", "both", "only first", "only second", "neither", "difference", "p", "mid-p", "p (Holm)")
    rows = [(task.task, *_pairs(task.pairs), _p(task.p_holm)) for task in comparison.tasks]
    if len(rows) > 1:
        rows.append((ALL, *_pairs(comparison.pairs), ""))
    d, p = comparison.difference, comparison.pairs.p
    better = comparison.second if comparison.pairs.difference > 0 else comparison.first
    call = f"significant at 5 %, '{better}' is better" if comparison.significant else "not significant at 5 %"
    told = [task.task for task in comparison.tasks if task.significant]
    notes = (
        f"Difference in the mean over tasks: {100 * d.value:+.1f} points (95 %: {100 * d.low:+.1f} to {100 * d.high:+.1f}); "
        f"McNemar over all episodes: p = {_p(p.exact)}, mid-p = {_p(p.mid)}: {call}.",
        f"By task, corrected for {len(comparison.tasks)} tests: {', '.join(told) or 'none'} differ{'s' * (len(told) < 2)}.",
        *comparison.remarks,
    )
    what = "success" if comparison.measure == "success" else "stable success"
    return Table(f"{comparison.second} compared with {comparison.first}: {what}", head, tuple(rows), notes)


def _task_row(task: TaskSummary) -> tuple[str, ...]:
    steps = "" if task.steps is None else f"{task.steps:.0f}"
    low, high = task.success.interval
    rates = (_percent(task.success.value), _span(Estimate(task.success.value, low, high)), _percent(task.stable.value))
    return task.task, str(task.success.of), *rates, steps, *_counts([task], task.success.of)


def _counts(tasks: Sequence[TaskSummary], episodes: int) -> tuple[str, ...]:
    """Return refused actions and collisions per episode, the largest force, ticks of violations, and faults."""
    each = max(1, episodes)
    refused = sum(sum(task.refused.values()) for task in tasks) / each
    collisions = sum(task.collisions for task in tasks) / each
    force = max((task.max_force for task in tasks), default=0.0)
    violations, faults = (sum(sum(getattr(task, name).values()) for task in tasks) for name in ("violations", "faults"))
    return f"{refused:.2f}", f"{collisions:.2f}", f"{force:.0f}", str(violations), str(faults)


def _notes(summary: Summary) -> list[str]:
    counted = ((name, added_counts(getattr(task, key) for task in summary.tasks)) for name, key in _COUNTED)
    notes = [f"{name}: {', '.join(f'{what} {n}' for what, n in counts.items())}." for name, counts in counted if counts]
    few = width_note(min((task.success.of for task in summary.tasks), default=0))
    return [_LEGEND, *notes, *fault_notes(summary), *([few] if few else [])]


def fault_notes(summary: Summary) -> list[str]:
    """Return one sentence for the first fault of each kind, and one for workers that died."""
    notes = [
        f"First '{record.fault}' ({record.task}, seed {record.seed}): {' '.join(record.fault_detail.split()) or 'no detail'}"
        for record in as_record(summary, Summary, "summary").first_faults
    ]
    deaths, retried = (sum(getattr(task, name) for task in summary.tasks) for name in ("worker_deaths", "retried"))
    if deaths:
        notes.append(f"Workers that died in an episode: {deaths}. Episodes that were played again after that: {retried}.")
    return [printable(note, most=700) for note in notes]


_LEGEND = (
    "Stable: success still holds after 1 s. Steps: median of successes. Refused actions and collisions: per episode. "
    "Force: maximum. Violations: total control ticks."
)
_COUNTED = (("Refused actions", "refused"), ("Ticks beyond limits", "violations"), ("Episodes that ended with a fault", "faults"))


def _pairs(pairs: Pairs) -> tuple[str, ...]:
    counts = (pairs.of, pairs.both, pairs.only_first, pairs.only_second, pairs.neither)
    return *map(str, counts), f"{100 * pairs.difference:+.1f}", _p(pairs.p.exact), _p(pairs.p.mid)


def _rate(rate: Rate) -> str:
    low, high = rate.interval
    return f"{_percent(rate.value)} ({_span(Estimate(rate.value, low, high))})"


def _span(estimate: Estimate) -> str:
    return f"{100 * estimate.low:.0f} to {100 * estimate.high:.0f}"


def _percent(value: float) -> str:
    return f"{100 * value:.0f} %"


def _p(value: float) -> str:
    return f"{value:.4f}" if value >= 1e-4 else f"{value:.1e}"
