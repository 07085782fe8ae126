"""Images of a check: contact sheets of demonstrations and reach maps."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from rlbench_pin.checking.reach import Reach
from rlbench_pin.checking.records import DemoTrial, ReachTrial, Trial, of_kind
from rlbench_pin.environment import ObservationConfig, TaskEnvironment
from rlbench_pin.environment.presets import clear_view, low_dim_config, make_environment
from rlbench_pin.errors import DemoError, RlbenchPinError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.tasks import PLACEMENT_AREA, Task, find_task, task_scene

_MARGIN = 8
_CAPTION = 18
_TITLE = 46
_INK, _PAPER, _FAINT = (30, 30, 30), (255, 255, 255), (110, 110, 110)
MOMENTS = 5
_SCALE = 210.0
"""Pixels per metre."""
_TABLE = ((-0.36, 0.72), (-0.56, 0.56))
"""Range of x and y of a panel [m]."""
_PER_ROW, _GAP, _MAP_CAPTION, _HEAD = 5, 10, 20, 48
_YES, _NO, _MAP_FAINT, _FLOOR = (0, 128, 90), (213, 70, 0), (120, 120, 120), (238, 238, 232)
_SIZE = 144
"""Side of an image [px]."""
_LOGGER = logging.getLogger(__name__)


def contact_sheet(
    images: Sequence[Sequence[np.ndarray]], rows: Sequence[str], columns: Sequence[str], title: str, subtitle: str
) -> Image.Image:
    """Lay images out in a grid.

    Args:
        images: One row of uint8 (h, w, 3) arrays, all of one shape, per entry of `rows`.
        rows: Captions of the rows.
        columns: Captions of the columns.
        title: First line at the top.
        subtitle: Second line at the top.
    """
    height, width = images[0][0].shape[:2]
    cell = (width + _MARGIN, height + _CAPTION + _MARGIN)
    sheet = Image.new("RGB", (_MARGIN + len(columns) * cell[0], _TITLE + _MARGIN + len(rows) * cell[1]), _PAPER)
    draw = ImageDraw.Draw(sheet)
    draw.text((_MARGIN, 6), title, fill=_INK, font=font(17))
    draw.text((_MARGIN, 28), subtitle, fill=_FAINT, font=font(13))
    for i, (row, name) in enumerate(zip(images, rows)):
        for j, (image, camera) in enumerate(zip(row, columns)):
            corner = (_MARGIN + j * cell[0], _TITLE + i * cell[1])
            draw.text(corner, f"{camera}, {name}", fill=_FAINT, font=font(12))
            sheet.paste(Image.fromarray(image), (corner[0], corner[1] + _CAPTION))
    return sheet


def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return the font of images, `size` high [px]."""
    return ImageFont.load_default(size)


def demo_sheet(
    task: type[Task], seed: int, variation: int = 0, *, attempt: int | None = None, size: int = 256
) -> tuple[Image.Image, str]:
    """Draw a demonstration, and return the image and the name of the task.

    Args:
        task: Class of the task.
        seed: Seed of the episode.
        variation: Variation of the task.
        attempt: Number of the attempt of the seed; None takes the first that succeeds.
        size: Side of each image [px].

    Raises:
        DemoError: The demonstration fails.
    """
    config = sheet_config(size)
    with make_environment(config) as environment:
        task_environment = environment.get_task(task)
        demo = _demonstrate(task_environment, seed, variation, attempt)
        frames = moments(task_environment, demo, config)
    times = ["reset", *(f"t = {moment:.1f} s" for moment in list(frames)[1:])]
    images = [[getattr(obs, f"{camera}_rgb") for camera in config.all_cameras()] for obs in frames.values()]
    names = [camera.replace("_", " ") for camera in config.all_cameras()]
    subtitle = f"variation {demo.variation_number}, seed {seed}, {len(demo)} frames"
    return contact_sheet(images, times, names, f"{demo.task_name}: {demo.instructions[0]}", subtitle), demo.task_name


def sheet_config(size: int) -> ObservationConfig:
    """Return the five cameras and the clear view, of `size` px and with smooth edges, all off: `moments` turns them on."""
    config = low_dim_config()
    config.extra_cameras = clear_view((size, size))
    for camera in config.all_cameras().values():
        camera.set_all(False)
        camera.image_size, camera.antialiasing = (size, size), True
    return config


def _demonstrate(task_environment: TaskEnvironment, seed: int, variation: int, attempt: int | None) -> Demo:
    if attempt is None:
        task_environment.set_variation(variation)
        return task_environment.get_demos(1, live_demos=True, seed=seed)[0]
    outcome = task_environment.try_demo(seed=seed, variation=variation, attempt=attempt)
    if outcome.demo is None:
        raise DemoError(
            f"Seed {seed}, attempt {attempt} of '{task_environment.get_name()}' does not succeed again: {outcome.cause}",
            task_environment.task,
        )
    return outcome.demo


def moments(task: TaskEnvironment, demo: Demo, config: ObservationConfig, count: int = MOMENTS) -> dict[float, Observation]:
    """Replay a demonstration and render all cameras at `count` frames of it, including the first and the last.

    Playing it twice is cheaper than taking every image, and the replay is identical.

    Returns:
        Time since the reset [s] -> the observation.
    """
    wanted = set(np.linspace(0, len(demo) - 1, count).round().astype(int).tolist())
    seen: dict[float, Observation] = {}
    frame, began = 0, 0.0

    def look(_: Observation) -> None:
        nonlocal frame, began
        began = began if frame else task.world.time
        if frame in wanted:
            for camera in config.all_cameras().values():
                camera.rgb = True
            seen[task.world.time - began] = task.get_observation()
            for camera in config.all_cameras().values():
                camera.set_all(False)
        frame += 1

    assert demo.seed is not None
    task.try_demo(seed=demo.seed, variation=demo.variation_number, attempt=demo.attempt, on_frame=look)
    return seen


def reach_map(task: str, reaches: Sequence[Reach], fixed: bool) -> Image.Image:
    """Draw one panel for each waypoint, and one for all waypoints with a collision-free arm at home.

    Args:
        task: Name for the title.
        reaches: Random layouts of the task, each with its reached waypoints.
        fixed: Draw the places of the waypoints instead of those of the task root, which does not move.
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
    """World x, y [m] -> column, row of a panel; x grows upwards, y to the left."""
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
            _LOGGER.warning("no images of '%s': %s", task, error)
    placed = sorted((trial for trial in of_kind(trials, ReachTrial) if trial.reach), key=lambda trial: trial.seed)
    if placed:
        drawn["map"] = _draw_map(task, placed, out)
    return drawn


def _draw_sheet(task: str, trial: DemoTrial, out: Path) -> str:
    """The five cameras at the reset, at three moments of a demonstration, and at its end."""
    sheet, _ = demo_sheet(find_task(task), trial.seed, trial.variation, attempt=len(trial.failed), size=_SIZE)
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
