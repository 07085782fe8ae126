"""Plots of results: success with its interval, one bar per task and policy, in colours for colour-blind readers."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation.results.profile import Profile
from rlbench_pin.evaluation.results.statistics import Summary
from rlbench_pin.evaluation.results.tables import MEAN, printable
from rlbench_pin.values import as_path, as_record, as_several, as_whole

SUFFIXES = (".png", ".svg")
MAX_POLICIES = 8
"""Maximum number of policies in one plot."""
COLORS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442", "#000000")
"""Colours of Okabe and Ito, in an order in which neighbours also differ in lightness."""
_FIXED = {"svg.hashsalt": "rlbench_pin", "svg.fonttype": "none", "font.family": "DejaVu Sans", "font.size": 9.0}
_BAR, _GAP, _FRAME, _WIDTH = 0.17, 0.12, 1.1, 7.5
"""Height of a bar, space between tasks, height of everything else, width of the plot [inch]."""


def draw_results(path: Path | str, summaries: Sequence[Summary]) -> Path:
    """Draw several evaluations side by side, and return the path; equal results give the same file.

    Args:
        path: A PNG or SVG file.
        summaries: Statistics of 1 to 8 evaluations.

    Raises:
        InvalidValue: The file has another suffix, or there are too many policies.
        StorageError: The file cannot be written.
    """
    found = [as_record(s, Summary, "A summary") for s in as_several(summaries, "summaries")]
    return write_plot(check_plot(path, len(found)), lambda: _figure(found))


def draw_profiles(path: Path | str, profiles: Sequence[Profile]) -> Path:
    """Draw success over factors, one panel per profile, one axis per factor; equal results give the same file.

    Args:
        path: A PNG or SVG file.
        profiles: 1 to 8 profiles.

    Raises:
        InvalidValue: The file has another suffix, or there are too many profiles.
        StorageError: The file cannot be written.
    """
    found = [as_record(profile, Profile, "A profile") for profile in as_several(profiles, "profiles")]
    return write_plot(check_plot(path, len(found)), lambda: _profile_figure(found))


def write_plot(path: Path, draw: Callable[[], Figure]) -> Path:
    """Write the figure that `draw` returns, and return the path; equal figures give the same file.

    Raises:
        StorageError: The file cannot be written.
    """
    kind, written = path.suffix.lower()[1:], io.BytesIO()
    metadata: dict[str, Any] = {"Date": None} if kind == "svg" else {"Software": None}
    with rc_context(_FIXED):
        draw().savefig(written, format=kind, dpi=150, metadata=metadata)
    return write_whole(path, written.getvalue())


def _profile_figure(profiles: Sequence[Profile]) -> Figure:
    figure = Figure(figsize=(_WIDTH, 5.5 * len(profiles)), layout="constrained")
    for place, profile in enumerate(profiles):
        _draw_profile(figure.add_subplot(len(profiles), 1, place + 1, projection="polar"), profile)
    return figure


def _draw_profile(axes: Any, profile: Profile) -> None:
    """Draw one profile: a line for each level through the axes of its factors, and a circle without factors."""
    values: dict[str, dict[str, float]] = {}
    for row in profile.rows:
        name, _, level = row.setting.rpartition(":") if "+" not in row.setting else (row.setting, "", "together")
        values.setdefault(name, {})[level] = row.summary.success.value
    names, levels = list(values), list(dict.fromkeys(level for found in values.values() for level in found))
    angles = np.linspace(0.0, 2.0 * np.pi, len(names), endpoint=False)
    around = np.linspace(0.0, 2.0 * np.pi, 181)
    axes.plot(around, np.full(181, profile.base.success.value), color="#888888", linewidth=1.0, linestyle="--", label="none")
    for place, level in enumerate(levels):
        chosen = [(angle, values[name][level]) for angle, name in zip(angles, names) if level in values[name]]
        line: dict[str, Any] = {"color": COLORS[place % len(COLORS)], "marker": "o", "markersize": 3.5, "linewidth": 1.2}
        closed = [*chosen, chosen[0]] if len(chosen) == len(names) > 2 else chosen
        axes.plot(*zip(*closed), label=level if level.isalpha() else f"level {level}", clip_on=False, **line)
    axes.set_xticks(angles, [_label(name).strip() for name in names])
    axes.tick_params(axis="x", pad=4)
    for label, angle in zip(axes.get_xticklabels(), angles, strict=True):
        side = np.cos(angle)
        label.set_horizontalalignment("center" if abs(side) < 0.05 else "left" if side > 0.0 else "right")
    axes.set_ylim(0.0, 1.0)
    axes.set_yticks(np.linspace(0.25, 1.0, 4), [f"{v} %" for v in (25, 50, 75, 100)])
    axes.set_title(f"{_label(profile.policy)}: success by factor", pad=24)
    axes.legend(loc="lower left", bbox_to_anchor=(1.05, 0.0), frameon=False)


def check_plot(path: Path | str, policies: int) -> Path:
    """Return the path of a plot, or raise InvalidValue as `draw_results` does.

    Args:
        path: A PNG or SVG file.
        policies: Number of policies in the plot.
    """
    path = as_path(path, "path")
    if path.suffix.lower() not in SUFFIXES:
        raise InvalidValue("path of a plot", str(path), f"has to end with {' or '.join(SUFFIXES)}")
    if not 1 <= as_whole(policies, "policies") <= MAX_POLICIES:
        raise InvalidValue("policies in one plot", policies, f"have to be 1 to {MAX_POLICIES}", "Draw several plots.")
    return path


def _figure(summaries: Sequence[Summary]) -> Figure:
    """Return the figure: a group of bars per task, the first task on top, the mean below a line."""
    names = list(dict.fromkeys(task.task for summary in summaries for task in summary.tasks))
    groups = [*names, MEAN] if len(names) > 1 else names
    step = _BAR * len(summaries) + _GAP
    figure = Figure(
        figsize=(_WIDTH, step * max(1, len(groups)) + _FRAME + 0.2 * ((len(summaries) - 1) // 3)), layout="constrained"
    )
    axes = figure.add_subplot()
    for place, summary in enumerate(summaries):
        rates = [_bar(summary, group) for group in groups]
        at = [step * i + _BAR * (place - (len(summaries) - 1) / 2) for i, rate in enumerate(rates) if rate is not None]
        values = np.array([rate for rate in rates if rate is not None]).reshape(-1, 3)
        spread = np.abs(values[:, 1:] - values[:, :1]).T
        color = COLORS[place]
        bar: dict[str, Any] = {"color": color, "label": _label(summary.policy), "edgecolor": "black", "linewidth": 0.5}
        axes.barh(at, values[:, 0], height=0.9 * _BAR, clip_on=False, zorder=2, **bar)
        line: dict[str, Any] = {"fmt": "o", "markersize": 3.5, "markerfacecolor": color, "markeredgecolor": "#222222"}
        axes.errorbar(values[:, 0], at, xerr=spread, ecolor="#222222", elinewidth=1, capsize=2, clip_on=False, zorder=3, **line)
    if len(names) > 1:
        axes.axhline(step * (len(groups) - 1.5), color="black", linewidth=0.6)
    axes.set_yticks([step * i for i in range(len(groups))], [_label(group).strip() for group in groups])
    axes.set_ylim(step * (len(groups) - 0.5), -step / 2)
    axes.set_xlim(0.0, 1.0)
    axes.set_xticks(np.linspace(0.0, 1.0, 6), [f"{v} %" for v in range(0, 101, 20)])
    axes.set_xlabel(f"success, with 95 % intervals ({_episodes(summaries)})")
    axes.grid(axis="x", color="#cccccc", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.tick_params(axis="y", length=0)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.legend(loc="outside upper center", ncols=min(3, len(summaries)), frameon=False)
    return figure


def _bar(summary: Summary, group: str) -> tuple[float, float, float] | None:
    """Return rate and interval of a task, or of the mean; None where there are none."""
    if group == MEAN:
        return summary.success.value, summary.success.low, summary.success.high
    for task in summary.tasks:
        if task.task == group and task.success.of:
            return task.success.value, *task.success.interval
    return None


def _label(name: str) -> str:
    """Return a name for matplotlib: a dollar starts no formula, and a leading underscore does not remove it from the legend."""
    text = printable(name, most=45).replace("$", r"\$")
    return f" {text}" if text.startswith("_") else text


def _episodes(summaries: Sequence[Summary]) -> str:
    """Return the number of episodes of each task as text."""
    counts = sorted({task.success.of for summary in summaries for task in summary.tasks})
    span = str(counts[0]) if len(counts) == 1 else f"{counts[0]} to {counts[-1]}" if counts else "no"
    return f"{span} episode{'s' * (counts != [1])} of each task"
