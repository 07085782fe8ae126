"""`rlbench-pin demo TASK`: plan demonstrations, write them to a dataset, record videos."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from rlbench_pin.cli.options import Cameras, Disturbances, RobotName, Size, TaskName, check_at_least, check_folder
from rlbench_pin.errors import DemoError, storing
from rlbench_pin.observation import CAMERAS, Demo, Observation

if TYPE_CHECKING:
    from tqdm import tqdm

    from rlbench_pin.environment import TaskEnvironment
    from rlbench_pin.recording.video import VideoRecorder


@dataclass(frozen=True)
class RecordDemos:
    """Plan demonstrations of one task, write each to an HDF5 episode, and record a video."""

    task: tyro.conf.Positional[TaskName]
    """Task name, as `rlbench-pin list` prints it, or a task file."""
    variation: int = 0
    """Variation of the task; -1 draws one for each episode."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    episodes: int = 1
    """Number of successful episodes to write."""
    out: Path = Path("out/demo")
    """Folder of the dataset."""
    video: bool = True
    """Record a video of each episode from the side, as an MP4 file next to it."""
    image_size: Size = (128, 128)
    """Width and height of the cameras' images [px]."""
    cameras: Cameras = CAMERAS
    """Cameras whose images are stored."""
    max_attempts: int = 10
    """Maximum number of attempts for each episode."""
    robot: RobotName = "panda"
    """Name of the arm, or path of its TOML file."""
    disturb: Disturbances = ()
    """Disturbances: one of these happens at a random time, and the planner continues from the state after it."""
    json: bool = False
    """Print JSON for programs."""

    def run(self) -> int:
        """Record, and print the paths of the files."""
        from rlbench_pin.environment.presets import image_config, make_environment
        from rlbench_pin.tasks import find_task

        check_at_least(self, variation=-1, seed=0, episodes=1, image_size=1, max_attempts=1)
        config, chosen = image_config(self.image_size, self.cameras), find_task(self.task)
        check_folder(self.out)
        with make_environment(config, robot=self.robot) as environment:
            task = environment.get_task(chosen)
            task.set_variation(self.variation)
            recorded = list(self._record_all(task))
        if self.json:
            print(json.dumps([asdict(r) for r in recorded], indent=1))
        return 0

    def _record_all(self, task: TaskEnvironment) -> Iterator[Recorded]:
        from rlbench_pin.cli.bars import progress_bar

        with progress_bar(total=self.episodes, unit="demo", desc=self.task) as bar:
            for seed in range(self.seed, self.seed + self.episodes):
                recorded = self._record(task, seed, bar)
                bar.update()
                if not self.json:
                    bar.write(_text(recorded))
                yield recorded

    def _record(self, task: TaskEnvironment, seed: int, bar: tqdm) -> Recorded:
        """Repeat attempts until a demonstration of this seed succeeds, then write it."""
        from rlbench_pin.recording.video import VideoRecorder
        from rlbench_pin.tasks import keep_task

        causes = []
        for attempt in range(self.max_attempts):
            with storing(self.out), ExitStack() as stack:
                recorder = stack.enter_context(VideoRecorder(task, self.out)) if self.video else None
                outcome = task.try_demo(seed=seed, attempt=attempt, on_frame=_counter(bar, seed), disturb=self.disturb)
                if outcome.demo is not None:
                    keep_task(self.out, type(task.task))
                    return self._keep(outcome.demo, outcome.duration, recorder)
                causes.append(outcome.cause)
        raise DemoError(f"Seed {seed} of '{self.task}' failed {self.max_attempts} times: {'; '.join(causes)}. Try another seed.")

    def _keep(self, demo: Demo, seconds: float, recorder: VideoRecorder | None) -> Recorded:
        from rlbench_pin.datasets import DatasetWriter

        episode = DatasetWriter(self.out).add(demo)
        video = None if recorder is None else recorder.keep(episode.parent.with_name("videos") / f"{episode.stem}.mp4")
        assert demo.seed is not None
        return Recorded(
            task=demo.task_name,
            variation=demo.variation_number,
            seed=demo.seed,
            attempt=demo.attempt,
            frames=len(demo),
            seconds=round(seconds, 3),
            instruction=demo.instructions[0],
            episode=str(episode),
            video=None if video is None else str(video),
        )


@dataclass(frozen=True)
class Recorded:
    """One demonstration on disk."""

    task: str
    variation: int
    seed: int
    attempt: int
    frames: int
    seconds: float
    """Length of the demonstration in simulated time [s]."""
    instruction: str
    episode: str
    video: str | None


def _counter(bar: tqdm, seed: int) -> Callable[[Observation], None]:
    """Return a callback that shows the number of the current frame in the bar."""
    frames = itertools.count(1)

    def count(_: Observation) -> None:
        number = next(frames)
        bar.set_postfix(seed=seed, frame=number, refresh=number % 10 == 0)

    return count


def _text(recorded: Recorded) -> str:
    lines = [
        f"{recorded.task}, variation {recorded.variation}, seed {recorded.seed}: "
        f'{recorded.frames} frames, {recorded.seconds:.1f} s, "{recorded.instruction}"',
        f"  episode  {recorded.episode}",
    ]
    return "\n".join(lines + ([f"  video    {recorded.video}"] if recorded.video else []))
