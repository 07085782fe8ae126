"""Play recovery demonstrations of every task, and write docs/results/recovery.json and recovery.md.

`python scripts/write_recovery_results.py --episodes 3 --workers 2` resumes after an interruption, at the same commit.
With `--film` it only draws the video docs/images/recovery.webp: a push, two slips and a stop. A red bar marks the disturbance, a
green bar the recovery.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from tqdm import tqdm

sys.path.insert(0, str(Path(__file__).parent))

from reference_lib.docs import table

from rlbench_pin.environment import low_dim_config, make_environment
from rlbench_pin.environment.recovery import PUSH
from rlbench_pin.observation import DISTURBANCES, PHASE, RECOVERY, TASK, Disturbance, Observation
from rlbench_pin.rates import wilson
from rlbench_pin.recording.video import Clip, grid_frames, points_to_show
from rlbench_pin.sim import framed
from rlbench_pin.tasks import library_names

DOCS = Path(__file__).resolve().parents[1] / "docs"
DATA, PAGE, FILM = DOCS / "results" / "recovery.json", DOCS / "results" / "recovery.md", DOCS / "images" / "recovery.webp"
FIRST_SEED = 3_000_000
"""Seeds that nothing was tuned on."""
SHOWN = (("push", "meat_off_grill", 1), ("slip", "pick_and_lift", 1), ("slip", "open_drawer", 3), ("stop", "open_drawer", 2))
"""Disturbance, task and seed of each part of the film."""
CELL, EVERY, PAUSE, STILL = (240, 220), 2, 100, 8
"""Size of an image [px], ticks between two images, time of each [ms], images of the end."""
EYE = (0.75, 1.45, 1.95)
"""Ahead of the robot's left shoulder [m]."""

Outcomes = dict[str, list[str]]
"""Disturbance -> causes of failure of its episodes, empty where one succeeded."""


def play(task: str, episodes: int) -> Outcomes:
    """Return the outcomes of a task; none where there is nothing to let go of."""
    found: Outcomes = {}
    with make_environment(low_dim_config()) as environment:
        running = environment.get_task(task)
        for kind in DISTURBANCES:
            outcomes = []
            for episode in range(episodes):
                variation = episode % running.variation_count()
                outcome = running.try_demo(seed=FIRST_SEED + episode, variation=variation, record=False, disturb=(kind,))
                if "No segment of the demonstration allows" not in outcome.cause:
                    outcomes.append(outcome.cause)
            found[kind] = outcomes
    return found


def _job(words: tuple[str, int]) -> tuple[str, Outcomes]:
    return words[0], play(*words)


def summary(tasks: dict[str, Outcomes]) -> list[list[str]]:
    """Return a row for each disturbance."""
    rows = []
    for kind in DISTURBANCES:
        outcomes = [not cause for task in tasks.values() for cause in task[kind]]
        low, high = wilson(sum(outcomes), len(outcomes))
        rate, count = sum(outcomes) / len(outcomes), sum(1 for task in tasks.values() if task[kind])
        rows.append([f"`{kind}`", f"{count}", f"{len(outcomes)}", f"{rate:.1%}", f"{low:.1%} to {high:.1%}"])
    return rows


def _share(causes: list[str]) -> str:
    return f"{sum(not cause for cause in causes)} of {len(causes)}" if causes else ""


def write(content: dict[str, Any]) -> None:
    """Write the page."""
    tasks: dict[str, Outcomes] = content["tasks"]
    rows = [[f"`{name}`", *(_share(tasks[name][kind]) for kind in DISTURBANCES)] for name in sorted(tasks)]
    lines = [
        "# Recovery demonstrations: results",
        "",
        f"Success at the first try after one disturbance, {content['episodes']} episodes for each task and disturbance,",
        f"from seeds that nothing was tuned on, at commit `{content['commit']}`.",
        f"A push moves the gripper by {100 * PUSH:.0f} cm. Where nothing is gripped, nothing can slip.",
        "Written by `python scripts/write_recovery_results.py`.",
        "",
        table(["Disturbance", "Tasks", "Episodes", "Success", "95 %"], summary(tasks), "lrrrr"),
        "",
        table(["Task", *(f"`{kind}`" for kind in DISTURBANCES)], rows, "lrrr"),
    ]
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")


def clip_of(kind: Disturbance, name: str, seed: int) -> Clip:
    """Film one disturbance."""
    clip, colors = Clip(), {TASK: None, RECOVERY: (40, 170, 60)}
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        task.reset(seed=seed, variation=0)
        view = framed(EYE, points_to_show(task.world), (2 * CELL[0], 2 * CELL[1]))
        frame = 0

        def look(observation: Observation) -> None:
            nonlocal frame
            phase = observation.misc.get(PHASE, TASK)
            if frame % EVERY == 0 or phase not in colors:
                small = Image.fromarray(task.world.renderer.image(view)).resize(CELL, Image.Resampling.LANCZOS)
                image = np.array(small)
                if (color := colors.get(phase, (220, 40, 30))) is not None:
                    image[-10:] = color
                clip.add(image)
            frame += 1

        outcome = task.try_demo(seed=seed, variation=0, on_frame=look, disturb=(kind,))
        if not outcome.success:
            raise SystemExit(f"{name}, seed {seed}: {outcome.cause}")
    for _ in range(STILL):
        clip.add(np.asarray(clip.frame(len(clip) - 1)))
    return clip


def film() -> None:
    """Write the film."""
    clips = {f"{kind}: {name}": clip_of(kind, name, seed) for kind, name, seed in SHOWN}
    first, *rest = [Image.fromarray(image) for image in grid_frames(clips, CELL)]
    first.save(FILM, save_all=True, append_images=rest, duration=PAUSE, loop=0, quality=50, method=4)


def main() -> None:
    """Play what is missing, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=3, help="episodes of each task and disturbance")
    parser.add_argument("--workers", type=int, default=2, help="worker processes")
    parser.add_argument("--film", action="store_true", help="draw only the video")
    options = parser.parse_args()
    if options.film:
        film()
        return
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True).stdout.strip()
    content: dict[str, Any] = {"commit": commit, "episodes": options.episodes, "tasks": {}}
    before = json.loads(DATA.read_text(encoding="utf-8")) if DATA.exists() else {}
    if before.get("commit") == commit and before["episodes"] == options.episodes:
        content = before
    jobs = [(name, options.episodes) for name in library_names() if name not in content["tasks"]]
    with multiprocessing.get_context("spawn").Pool(options.workers, maxtasksperchild=20) as pool:
        for name, found in tqdm(pool.imap_unordered(_job, jobs), total=len(jobs), unit="task", desc="recovery"):
            content["tasks"][name] = found
            DATA.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    write(content)


if __name__ == "__main__":
    main()
