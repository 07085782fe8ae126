"""Filming an episode from the side, one picture per control tick."""

from __future__ import annotations

import os
from pathlib import Path
from types import TracebackType

import numpy as np

from rlbench_pin.datasets import VideoWriter
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.recording.films.framing import framed, things_to_see
from rlbench_pin.sim import CameraView, World
from rlbench_pin.values import as_path, as_record

FILM_SIZE = (640, 480)
"""Width and height [px]."""

EYE = (-0.05, 1.62, 1.80)
"""Where films are taken from: the robot's left [m]."""


def film_view(world: World) -> CameraView:
    """Return the camera from the robot's left that has the arm and the whole task in its picture, where they are now."""
    return framed(EYE, things_to_see(world), FILM_SIZE)


class Film:
    """Films every tick of an environment between `with` and its end; `keep` says where the film goes, otherwise it is lost.

    Args:
        task: What to film.
        folder: Where to write while filming.
    """

    def __init__(self, task: TaskEnvironment, folder: Path) -> None:
        self._task = as_record(task, TaskEnvironment, "task")
        fps = round(1.0 / task.world.control_dt)
        self._video = VideoWriter(as_path(folder, "folder") / f".filming{os.getpid()}.mp4", FILM_SIZE, fps)
        self._pause = fps
        self._kept = False
        self._view: CameraView | None = None

    def __enter__(self) -> Film:
        self._task.runtime.register_step_callback(self._film_tick)
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        self._task.runtime.remove_step_callback(self._film_tick)
        if not self._kept:
            self._video.discard()

    def keep(self, path: Path) -> Path:
        """Finish the film with a second of its last picture and move it to `path`."""
        last = self._picture()
        for _ in range(self._pause):
            self._video.add(last)
        self._kept = True
        path.parent.mkdir(parents=True, exist_ok=True)
        os.replace(self._video.close(), path)
        return path

    def _film_tick(self) -> None:
        self._video.add(self._picture())

    def _picture(self) -> np.ndarray:
        """Picture of now, from where the first was taken."""
        if self._view is None:
            self._view = film_view(self._task.world)
        return self._task.world.renderer.image(self._view)
