"""Pictures of a check: each task from the reset to the end, and a map of what the arm reaches."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path

from rlbench_pin.cli.reach_map import reach_map
from rlbench_pin.cli.setup import find_task, low_dim_config, make_environment
from rlbench_pin.cli.sheet import contact_sheet
from rlbench_pin.cli.trials import Trial
from rlbench_pin.cli.view import moments
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.observation import CAMERAS
from rlbench_pin.tasks import task_scene

_SIZE = 144
"""Side of a picture [px]."""
_LOGGER = logging.getLogger(__name__)


def draw_pictures(task: str, trials: Sequence[Trial], out: Path) -> dict[str, str]:
    """Draw what can be drawn of one task into `out`, and return what it shows -> file below `out`."""
    drawn = {}
    good = [t for t in trials if t.part == "demos" and t.success]
    if good:
        first = min(good, key=lambda t: (t.tries, t.seed))
        try:
            drawn["sheet"] = _draw_sheet(task, first, out)
        except RlbenchPinError as error:
            _LOGGER.warning("no pictures of '%s': %s", task, error)
    reaches = sorted((t for t in trials if t.reach is not None), key=lambda t: t.seed)
    if reaches:
        drawn["map"] = _draw_map(task, reaches, out)
    return drawn


def _draw_sheet(task: str, trial: Trial, out: Path) -> str:
    """The five cameras at the reset, at three moments of a demonstration, and at its end."""
    config = low_dim_config()
    for camera in config.cameras().values():
        camera.image_size = (_SIZE, _SIZE)
    with make_environment(config) as environment:
        loop = environment.get_task(find_task(task))
        demo = loop.try_demo(seed=trial.seed, variation=trial.variation, attempt=trial.tries - 1).demo
        if demo is None:
            raise RlbenchPinError(f"seed {trial.seed} does not succeed again")
        frames = moments(loop, demo, config)
    rows = ["reset", *(f"t = {moment:.1f} s" for moment in list(frames)[1:])]
    pictures = [[getattr(obs, f"{camera}_rgb") for camera in CAMERAS] for obs in frames.values()]
    names = [camera.replace("_", " ") for camera in CAMERAS]
    subtitle = f"variation {trial.variation}, seed {trial.seed}, {len(demo)} frames"
    sheet = contact_sheet(pictures, rows, names, f"{trial.task}: {demo.instructions[0]}", subtitle)
    file = Path("pictures") / f"{trial.task}.jpg"
    (out / file).parent.mkdir(parents=True, exist_ok=True)
    sheet.save(out / file, quality=80, optimize=True)
    return file.as_posix()


def _draw_map(task: str, trials: Sequence[Trial], out: Path) -> str:
    static = task_scene(find_task(task)).placement.static
    file = Path("pictures") / f"{trials[0].task}_reach.png"
    (out / file).parent.mkdir(parents=True, exist_ok=True)
    reach_map(trials[0].task, [t.reach for t in trials if t.reach is not None], static).save(out / file)
    return file.as_posix()
