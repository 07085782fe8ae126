"""`rlbench-pin view TASK`: one picture of a task, as the five cameras see a demonstration."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro

from rlbench_pin.cli.setup import find_task, low_dim_config, make_environment
from rlbench_pin.cli.sheet import contact_sheet
from rlbench_pin.environment import ObservationConfig, TaskEnvironment
from rlbench_pin.observation import CAMERAS, Demo, Observation

MOMENTS = 5


@dataclass(frozen=True)
class View:
    """Draw a contact sheet: the five cameras at the reset and at four moments of a demonstration."""

    task: tyro.conf.Positional[str]
    """Task name, as `rlbench-pin list` prints it."""
    variation: int = 0
    """Variation of the task."""
    seed: int = 0
    """Seed of the episode."""
    out: Path | None = None
    """PNG to write; `out/view/<task>.png` by default."""
    size: int = 256
    """Side of each picture [px]."""

    def run(self) -> int:
        """Draw, and print where the picture is."""
        config = low_dim_config()
        for camera in config.cameras().values():
            camera.image_size = (self.size, self.size)
        with make_environment(config) as environment:
            task = environment.get_task(find_task(self.task))
            task.set_variation(self.variation)
            demo = task.get_demos(1, live_demos=True, seed=self.seed)[0]
            frames = moments(task, demo, config)
        out = self.out or Path("out/view") / f"{demo.task_name}.png"
        out.parent.mkdir(parents=True, exist_ok=True)
        times = ["reset", *(f"t = {moment:.1f} s" for moment in list(frames)[1:])]
        pictures = [[getattr(obs, f"{camera}_rgb") for camera in CAMERAS] for obs in frames.values()]
        names = [camera.replace("_", " ") for camera in CAMERAS]
        title = f"{demo.task_name}: {demo.instructions[0]}"
        subtitle = f"variation {demo.variation_number}, seed {self.seed}, {len(demo)} frames"
        contact_sheet(pictures, times, names, title, subtitle).save(out)
        print(out)
        return 0


def moments(task: TaskEnvironment, demo: Demo, config: ObservationConfig, count: int = MOMENTS) -> dict[float, Observation]:
    """Play a demonstration again and look through all cameras at `count` frames of it, first and last among them.

    Playing it twice is cheaper than taking every picture, and the second time goes exactly as the first.

    Returns:
        Time since the reset [s] -> what is seen then.
    """
    wanted = set(np.linspace(0, len(demo) - 1, count).round().astype(int).tolist())
    seen: dict[float, Observation] = {}
    frame, began = 0, 0.0

    def look(_: Observation) -> None:
        nonlocal frame, began
        began = began if frame else task.world.time
        if frame in wanted:
            for camera in config.cameras().values():
                camera.rgb = True
            seen[task.world.time - began] = task.get_observation()
            config.set_all_high_dim(False)
        frame += 1

    assert demo.random_seed is not None
    task.try_demo(seed=demo.random_seed, variation=demo.variation_number, attempt=demo.attempt, on_frame=look)
    return seen
