"""Pictures of a check: each task from the reset to the end, and a map of what the arm reaches."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path

from rlbench_pin.checking.pages.demo_sheet import demo_sheet
from rlbench_pin.checking.pages.reach_map import reach_map
from rlbench_pin.checking.records import DemoTrial, ReachTrial, Trial, of_kind
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.tasks import find_task, task_scene

_SIZE = 144
"""Side of a picture [px]."""
_LOGGER = logging.getLogger(__name__)


def draw_pictures(task: str, trials: Sequence[Trial], out: Path) -> dict[str, str]:
    """Draw what can be drawn of one task into `out`, and return what it shows -> file below `out`."""
    drawn = {}
    solved = [trial for trial in of_kind(trials, DemoTrial) if trial.solved]
    if solved:
        first = min(solved, key=lambda trial: (len(trial.failed), trial.seed))
        try:
            drawn["sheet"] = _draw_sheet(task, first, out)
        except RlbenchPinError as error:
            _LOGGER.warning("no pictures of '%s': %s", task, error)
    placed = sorted((trial for trial in of_kind(trials, ReachTrial) if trial.reach), key=lambda trial: trial.seed)
    if placed:
        drawn["map"] = _draw_map(task, placed, out)
    return drawn


def _draw_sheet(task: str, trial: DemoTrial, out: Path) -> str:
    """The five cameras at the reset, at three moments of a demonstration, and at its end."""
    sheet, _ = demo_sheet(find_task(task), trial.seed, trial.variation, attempt=len(trial.failed), size=_SIZE)
    file = Path("pictures") / f"{trial.task}.jpg"
    (out / file).parent.mkdir(parents=True, exist_ok=True)
    sheet.save(out / file, quality=80, optimize=True)
    return file.as_posix()


def _draw_map(task: str, trials: Sequence[ReachTrial], out: Path) -> str:
    static = task_scene(find_task(task)).placement.static
    file = Path("pictures") / f"{trials[0].task}_reach.png"
    (out / file).parent.mkdir(parents=True, exist_ok=True)
    reach_map(trials[0].task, [trial.reach for trial in trials if trial.reach], static).save(out / file)
    return file.as_posix()
