"""The images of learning curves in docs/results/learned_baselines.md, from the curve files of trainings."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rlbench_pin.baselines.reinforcement import draw_curves, read_curve

IMAGES = Path(__file__).resolve().parents[2] / "docs" / "images"


def draw_row(name: str, models: Path, tasks: Iterable[str]) -> Path:
    """Draw the curves of what a row has learned by trial, one for each task, and return the image."""
    return draw_curves(IMAGES / f"curves_{name}.png", {task: read_curve(models / name / task) for task in tasks})
