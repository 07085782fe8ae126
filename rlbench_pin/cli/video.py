"""`rlbench-pin video TASK...`: record videos of demonstrations with a camera that circles around the table."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
import tyro

from rlbench_pin.cli.list_tasks import named_tasks
from rlbench_pin.cli.options import MaybePath, Size, SomeTasks, check_at_least, check_file, checked_names
from rlbench_pin.errors import DemoError, TaskEnvironmentError, storing

if TYPE_CHECKING:
    from tqdm import tqdm

    from rlbench_pin.environment import Environment, TaskEnvironment
    from rlbench_pin.recording.video import Orbit
    from rlbench_pin.tasks import Task

_CELL = (320, 240)


@dataclass(frozen=True)
class Video:
    """Record videos of demonstrations: one video per task, or one video of all tasks in a grid."""

    tasks: tyro.conf.Positional[SomeTasks] = ()
    """Task names, as `rlbench-pin list` prints them, separated by spaces or commas, `all`, or task files."""
    grid: bool = False
    """Record one video with all tasks side by side, instead of one video for each task."""
    variation: int = 0
    """Variation of the tasks."""
    seed: int = 0
    """Seed of the episodes."""
    size: Size = (1280, 720)
    """Width and height of the video of one task [px], even numbers."""
    speed: float = 0.005
    """Angle by which the camera moves in a control tick [rad]."""
    fps: int = 20
    """Control ticks per second of the video; 20 is real time."""
    smooth: Literal[1, 2, 3] = 1
    """Number of frames for each control tick, taken between physics steps; 3 gives 60 frames per second."""
    domain_randomization: bool = False
    """Change textures and lights every ten ticks."""
    textures_path: MaybePath = None
    """Folder of textures for `--domain-randomization`. Default: the textures of the package."""
    renderer: Literal["cpu", "egl", "auto"] = "cpu"
    """Renderer: `cpu`, `egl`, or `auto` for EGL if it is available."""
    max_attempts: int = 10
    """Maximum number of attempts for each demonstration."""
    out: Path = Path("out/video")
    """Folder of the videos."""

    def run(self) -> int:
        """Record the videos, and print their paths."""
        from rlbench_pin.datasets import VideoWriter
        from rlbench_pin.recording.video import Orbit

        tasks = self._checked_tasks()
        if self.grid:
            print(self._record_grid(tasks))
            return 0
        for task in tasks:
            path = self.out / f"{task.get_name()}.mp4"
            with storing(path), self._environment() as environment, VideoWriter(path, self.size, self.fps * self.smooth) as video:
                self._play(environment.get_task(task), Orbit(size=self.size, step=self.speed / self.smooth), video.add)
            print(path)
        return 0

    def _checked_tasks(self) -> tuple[type[Task], ...]:
        """Return the tasks, after all arguments were checked."""
        from rlbench_pin.tasks import find_task

        check_at_least(self, variation=0, seed=0, fps=1, max_attempts=1, size=2)
        if any(side % 2 for side in self.size):
            raise TaskEnvironmentError(f"--size is {self.size[0]} {self.size[1]}; a video needs an even width and height.")
        if not np.isfinite(self.speed):
            raise TaskEnvironmentError(f"--speed is {self.speed}; it must be an angle [rad].")
        tasks = tuple(map(find_task, checked_names(self.tasks, named_tasks, "rlbench-pin video TASK...")))
        for name in ("grid",) if self.grid else (task.get_name() for task in tasks):
            check_file(self.out / f"{name}.mp4")
        return tasks

    def _record_grid(self, tasks: tuple[type[Task], ...]) -> Path:
        from rlbench_pin.datasets import VideoWriter
        from rlbench_pin.recording.video import Clip, Orbit, grid_frames, grid_size

        clips = {}
        for task in tasks:
            clip = clips[task.get_name()] = Clip()
            with self._environment() as environment:
                orbit = Orbit(size=_CELL, step=self.speed / self.smooth)
                self._play(environment.get_task(task), orbit, clip.add)
        path = self.out / "grid.mp4"
        with storing(path), VideoWriter(path, grid_size(len(clips), _CELL), self.fps * self.smooth) as video:
            for image in grid_frames(clips, _CELL):
                video.add(image)
        return path

    def _environment(self) -> Environment:
        from rlbench_pin.environment import (
            Discrete,
            Environment,
            JointPosition,
            MoveArmThenGripper,
            RandomizeEvery,
            VisualRandomizationConfig,
        )
        from rlbench_pin.environment.presets import low_dim_config

        mode = MoveArmThenGripper(JointPosition(), Discrete())
        if not self.domain_randomization:
            return Environment(mode, obs_config=low_dim_config(), seed=0, renderer=self.renderer)
        return Environment(
            mode,
            obs_config=low_dim_config(),
            seed=0,
            renderer=self.renderer,
            randomize_every=RandomizeEvery.TRANSITION,
            frequency=10,
            visual_randomization_config=VisualRandomizationConfig(self.textures_path),
        )

    def _play(self, task: TaskEnvironment, orbit: Orbit, add: Callable[[np.ndarray], None]) -> None:
        """Find an attempt that succeeds, then replay it with a camera whose image contains the whole end state."""
        from rlbench_pin.cli.bars import progress_bar

        task.set_variation(self.variation)
        attempt = self._successful_attempt(task)
        orbit = orbit.around(task.world)
        with progress_bar(unit="frame", desc=task.get_name(), leave=False) as bar, _each_tick(task, orbit, add, bar, self.smooth):
            task.try_demo(seed=self.seed, attempt=attempt, record=False)

    def _successful_attempt(self, task: TaskEnvironment) -> int:
        causes = []
        for attempt in range(self.max_attempts):
            outcome = task.try_demo(seed=self.seed, attempt=attempt, record=False)
            if outcome.success:
                return attempt
            causes.append(outcome.cause)
        name = task.get_name()
        raise DemoError(f"Seed {self.seed} of '{name}' failed {self.max_attempts} times: {'; '.join(causes)}. Try another seed.")


@contextmanager
def _each_tick(  # type: ignore[no-untyped-def]
    task: TaskEnvironment, orbit: Orbit, add: Callable[[np.ndarray], None], bar: tqdm, smooth: int
):
    """Take `smooth` images of every tick of the block, the last at its end, and repeat the last image of all for a second."""
    world = task.world
    every = round(world.control_dt / world.timestep) // smooth
    frame, steps, tick = 0, 0, -1
    between: list[np.ndarray] = []

    def shoot() -> None:
        nonlocal frame
        for image in (*between, orbit.image(world, frame + len(between))):
            add(image)
            frame += 1
            bar.update()
        between.clear()

    def look_between() -> None:
        """Called before a physics step; images of ticks without a callback, such as those of settling, are dropped."""
        nonlocal steps, tick
        if world.ticks != tick:
            steps, tick = 0, world.ticks
            between.clear()
        if steps and steps % every == 0:
            between.append(orbit.image(world, frame + len(between)))
        steps += 1

    task.runtime.register_step_callback(shoot)
    if smooth > 1:
        world.on_physics.append(look_between)
    try:
        yield
    finally:
        task.runtime.remove_step_callback(shoot)
        if smooth > 1:
            world.on_physics.remove(look_between)
    for _ in range(smooth * round(1.0 / world.control_dt)):
        shoot()
