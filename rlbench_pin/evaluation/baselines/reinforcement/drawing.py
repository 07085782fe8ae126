"""Learning curves as a picture: the share of successes over the steps of training."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rlbench_pin.datasets import write_whole
from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation.baselines.reinforcement.curve import CurvePoint
from rlbench_pin.evaluation.results.plots import COLORS, check_plot

_FIXED = {"svg.hashsalt": "rlbench_pin", "svg.fonttype": "none", "font.family": "DejaVu Sans", "font.size": 9.0}
_WIDTH, _HEIGHT = 6.4, 3.2
"""Size of the picture [inch]."""
WINDOW = 5
"""Legs over which successes while exploring are averaged."""


def draw_curves(path: Path | str, curves: Mapping[str, Sequence[CurvePoint]]) -> Path:
    """Draw learning curves: lines for success while exploring, dots for the most likely action on seeds of its own.

    Args:
        path: A PNG or SVG file.
        curves: What each is called -> its points, 1 to 8.

    Raises:
        InvalidValue: The file has another ending, there are too many curves, or one has no points.
        StorageError: It cannot be written.
    """
    path = check_plot(path, len(curves))
    empty = next((name for name, points in curves.items() if not points), None)
    if empty is not None:
        raise InvalidValue("curve", empty, "has no points yet: a training writes one after each leg")
    kind, written = path.suffix.lower()[1:], io.BytesIO()
    with rc_context(_FIXED):
        metadata: dict[str, Any] = {"Date": None} if kind == "svg" else {"Software": None}
        _figure(curves).savefig(written, format=kind, dpi=150, metadata=metadata)
    return write_whole(path, written.getvalue())


def _figure(curves: Mapping[str, Sequence[CurvePoint]]) -> Figure:
    figure = Figure(figsize=(_WIDTH, _HEIGHT), layout="constrained")
    axes = figure.add_subplot()
    for color, (name, points) in zip(COLORS, curves.items()):
        explored = [(p.steps, p.success, p.episodes) for p in points if p.success is not None]
        if explored:
            steps, successes, episodes = np.array(explored, dtype=float).T
            axes.plot(steps, _smooth(successes * episodes) / _smooth(episodes), color=color, linewidth=1.2)
        _draw_looks(axes, color, points)
        axes.plot([], [], "o-", color=color, markersize=4, label=name)
    axes.set_ylim(0.0, 1.0)
    axes.set_xlim(left=0.0)
    axes.set_yticks(np.linspace(0.0, 1.0, 6), [f"{v} %" for v in range(0, 101, 20)])
    axes.set(xlabel="decisions of training", ylabel="success (dots: without exploring)")
    axes.grid(color="#cccccc", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.legend(loc="outside upper center", ncols=min(3, len(curves)), frameon=False)
    return figure


def _draw_looks(axes: Axes, color: str, points: Sequence[CurvePoint]) -> None:
    """Draw validation as dots with intervals."""
    looks = [(p.steps, p.validation, *p.interval) for p in points if p.validation is not None and p.interval is not None]
    steps, rates, low, high = np.array(looks, dtype=float).reshape(-1, 4).T
    axes.vlines(steps, low, high, colors=color, linewidth=0.8, clip_on=False, zorder=3)
    axes.plot(steps, rates, "o", color=color, markersize=4, clip_on=False, zorder=3)


def _smooth(values: np.ndarray) -> np.ndarray:
    """Return sums over the last legs, shape (n,)."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    ends = np.arange(1, len(sums))
    return np.asarray(sums[ends] - sums[np.maximum(ends - WINDOW, 0)])
