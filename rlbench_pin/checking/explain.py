"""Causes of failed demonstrations: the error with its evidence, and an image of the world at that moment."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.environment.runtime import Listener
from rlbench_pin.errors import PlanningError, storing
from rlbench_pin.planning.plan import Plan, PlanRequest
from rlbench_pin.sim import CameraView, World, look_at
from rlbench_pin.tasks import find_task
from rlbench_pin.values import as_path


def explain_failure(task: str, seed: int, variation: int, image: Path | None = None, attempt: int = 0) -> list[str]:
    """Replay one demonstration and return lines with the cause of its failure, or one line when it succeeds.

    Args:
        task: Name of the task, or path of a task file.
        seed: Seed of the episode.
        variation: Variation of the task.
        image: PNG file for an image of the world at the failure; None writes no image.
        attempt: Number of the attempt of the seed.

    Raises:
        StorageError: The image cannot be written.
    """
    image = None if image is None else as_path(image, "image")
    with make_environment(low_dim_config()) as environment:
        task_environment = environment.get_task(find_task(task))
        failures = _Failures()
        with task_environment.runtime.listening(failures):
            outcome = task_environment.try_demo(seed=seed, variation=variation, attempt=attempt, record=False)
        head = f"{task_environment.get_name()} seed {seed} variation {variation} attempt {attempt}"
        if outcome.success:
            return [f"{head}: the demonstration succeeds."]
        lines = [f"{head}: {outcome.cause}", f"  waypoint: {outcome.waypoint}"]
        lines += [line for error in failures.since_success for line in evidence_lines(error)]
        if image is not None:
            with storing(image):
                image.parent.mkdir(parents=True, exist_ok=True)
                Image.fromarray(_look(task_environment.world)).save(image, "PNG")
            lines.append(f"  image: {image}")
        return lines


class _Failures(Listener):
    """Keeps the errors of planning motions to waypoints since the last planned motion."""

    def __init__(self) -> None:
        self.since_success: list[PlanningError] = []

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        """Keep an error, or drop all errors. A motion to a configuration is one of several attempts at the same waypoint."""
        if isinstance(outcome, PlanningError):
            self.since_success += [outcome] if request.kind != "configuration" else []
        else:
            self.since_success.clear()


def evidence_lines(error: Exception) -> list[str]:
    """Return the evidence of an error, a line for each name."""
    if not isinstance(error, PlanningError):
        return []
    return [f"  reason: {error.reason}", *(f"  {name}: {_text(value)}" for name, value in error.evidence.items())]


def _text(value: object) -> str:
    if isinstance(value, np.ndarray):
        return np.array2string(value, precision=4, suppress_small=True)
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value)


def _look(world: World) -> NDArray[np.uint8]:
    """Return an image (h, w, 3) of the table from the robot's left."""
    view = CameraView(look_at((1.3, 1.0, 1.75), (0.1, 0.0, 1.08)), fov=0.9, size=(640, 480), near=0.05, far=5.0)
    return world.renderer.image(view)
