"""Images of a check: reach maps, and the files of all images."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from rlbench_pin.checking.reach import Reach
from rlbench_pin.checking.records import DemoTrial, ReachTrial, Trial, of_kind
from rlbench_pin.checking.sheets import demo_sheet, font
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.tasks import PLACEMENT_AREA, find_task, task_scene

_INK, _PAPER = (30, 30, 30), (255, 255, 255)
_SCALE = 210.0
"""Pixels per metre."""
_TABLE = ((-0.36, 0.72), (-0.56, 0.56))
"""Range of x and y of a panel [m]."""
_PER_ROW, _GAP, _MAP_CAPTION, _HEAD = 5, 10, 20, 48
_YES, _NO, _MAP_FAINT, _FLOOR = (0, 128, 90), (213, 70, 0), (120, 120, 120), (238, 238, 232)
_LOGGER = logging.getLogger(__name__)


def reach_map(task: str, reaches: Sequence[Reach], fixed: bool) -> Image.Image:
    """Draw one panel for each waypoint, and one for all waypoints with a collision-free arm at home.

    Args:
        task: Name for the title.
        reaches: Random layouts of the task, each with its reached waypoints.
        fixed: Draw the positions of the waypoints instead of that of the task root, which does not move.
    """
    count = len(reaches[0].waypoints)
    panels = [_panel("all, arm free", [(_spot(r, None, fixed), r.place[2], r.accepted) for r in reaches], fixed)]
    for k in range(count):
        marks = [(_spot(r, k, fixed), r.place[2], r.reached[k]) for r in reaches if k < len(r.reached)]
        panels.append(_panel(f"waypoint {reaches[0].waypoints[k]}", marks, fixed))
    return _map_sheet(task, panels, fixed, len(reaches))


def _spot(reach: Reach, waypoint: int | None, fixed: bool) -> tuple[float, float]:
    if fixed and reach.spots:
        return reach.spots[0 if waypoint is None else waypoint]
    return reach.place[:2]


def _panel(title: str, marks: Sequence[tuple[tuple[float, float], float, bool]], fixed: bool) -> Image.Image:
    """Draw dots (reached) and crosses (not) on the table; the robot is at the bottom, its left is left."""
    width, height = (round(_SCALE * np.ptp(_TABLE[axis])) for axis in (1, 0))
    panel = Image.new("RGB", (width, height + _MAP_CAPTION), _PAPER)
    draw = ImageDraw.Draw(panel)
    good = sum(reached for _, _, reached in marks)
    draw.text((0, 2), f"{title}: {good}/{len(marks)}", fill=_INK if good == len(marks) else _NO, font=font(13))
    draw.rectangle((0, _MAP_CAPTION, width - 1, height + _MAP_CAPTION - 1), fill=_FLOOR)
    draw.rectangle(
        (*_pixel(PLACEMENT_AREA.x[1], PLACEMENT_AREA.y[1]), *_pixel(PLACEMENT_AREA.x[0], PLACEMENT_AREA.y[0])),
        fill=_PAPER,
        outline=_MAP_FAINT,
    )
    base_x, base_y = robot_description(DEFAULT_ROBOT).base_pose[:2]
    x, y = _pixel(base_x, base_y)
    draw.ellipse((x - 12, y - 12, x + 12, y + 12), fill=_MAP_FAINT)
    for (mx, my), yaw, reached in sorted(marks, key=lambda mark: not mark[2]):
        _mark(draw, _pixel(mx, my), None if fixed else yaw, reached)
    return panel


def _mark(draw: ImageDraw.ImageDraw, at: tuple[int, int], yaw: float | None, reached: bool) -> None:
    x, y = at
    color = _YES if reached else _NO
    if yaw is not None:  # towards the task's own x
        draw.line((x, y, x - 8 * np.sin(yaw), y - 8 * np.cos(yaw)), fill=color, width=1)
    if reached:
        draw.ellipse((x - 2, y - 2, x + 2, y + 2), fill=color)
        return
    draw.line((x - 4, y - 4, x + 4, y + 4), fill=color, width=2)
    draw.line((x - 4, y + 4, x + 4, y - 4), fill=color, width=2)


def _pixel(x: float, y: float) -> tuple[int, int]:
    """Return column and row of a panel for world coordinates x, y [m]; x increases upwards, y to the left."""
    return round(_SCALE * (_TABLE[1][1] - y)), _MAP_CAPTION + round(_SCALE * (_TABLE[0][1] - x))


def _map_sheet(task: str, panels: Sequence[Image.Image], fixed: bool, count: int) -> Image.Image:
    width, height = panels[0].width + _GAP, panels[0].height + _GAP
    columns = min(_PER_ROW, len(panels))
    rows = -(-len(panels) // columns)
    sheet = Image.new("RGB", (_GAP + columns * width, _HEAD + rows * height), _PAPER)
    draw = ImageDraw.Draw(sheet)
    draw.text((_GAP, 4), f"{task}: reach of the arm at {count} places", fill=_INK, font=font(16))
    marks = "places of the waypoint" if fixed else "places of the task, a line along its x"
    draw.text((_GAP, 27), f"dots reached, crosses not; {marks}; frame: workspace; disc: robot", fill=_MAP_FAINT, font=font(12))
    for k, panel in enumerate(panels):
        sheet.paste(panel, (_GAP + (k % columns) * width, _HEAD + (k // columns) * height))
    return sheet


def draw_images(task: str, trials: Sequence[Trial], out: Path) -> dict[str, str]:
    """Draw the images of one task into `out`, and return content (`sheet`, `map`) -> file below `out`."""
    drawn = {}
    solved = [trial for trial in of_kind(trials, DemoTrial) if trial.solved]
    if solved:
        first = min(solved, key=lambda trial: (len(trial.failed), trial.seed))
        try:
            drawn["sheet"] = _draw_sheet(task, first, out)
        except RlbenchPinError as error:
            _LOGGER.warning("No contact sheet of '%s' is drawn: %s", task, error)
    placed = sorted((trial for trial in of_kind(trials, ReachTrial) if trial.reach), key=lambda trial: trial.seed)
    if placed:
        drawn["map"] = _draw_map(task, placed, out)
    return drawn


def _draw_sheet(task: str, trial: DemoTrial, out: Path) -> str:
    """Draw the contact sheet of a demonstration, and return the name of its file."""
    sheet, _ = demo_sheet(find_task(task), trial.seed, trial.variation, attempt=len(trial.failed))
    file = Path("images") / f"{trial.task}.jpg"
    (out / file).parent.mkdir(parents=True, exist_ok=True)
    sheet.save(out / file, quality=80, optimize=True)
    return file.as_posix()


def _draw_map(task: str, trials: Sequence[ReachTrial], out: Path) -> str:
    static = task_scene(find_task(task)).placement.static
    file = Path("images") / f"{trials[0].task}_reach.png"
    (out / file).parent.mkdir(parents=True, exist_ok=True)
    reach_map(trials[0].task, [trial.reach for trial in trials if trial.reach], static).save(out / file)
    return file.as_posix()
