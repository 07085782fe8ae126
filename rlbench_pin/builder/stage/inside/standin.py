"""A task without code: the scene of a task file whose Python is not to be run."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rlbench_pin.tasks import Task, camel_case

SENTENCE = "Nothing is asked: the code of this task was not run."


class StandIn(Task):
    """The scene alone: nothing varies, no condition holds."""

    def init_task(self) -> None:
        """Nothing: there are no conditions, and nothing may be grasped."""

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return a sentence that says so."""
        return [SENTENCE]

    def success(self) -> tuple[bool, bool]:
        """Never reached, never over."""
        return False, False


def stand_in(scene: Path) -> type[Task]:
    """Return a task class of the name of a scene file, with that scene; the file beside it is not run."""

    def scene_file(cls: type[Task]) -> Path:
        return scene

    return type(camel_case(scene.stem), (StandIn,), {"__doc__": StandIn.__doc__, "scene_file": classmethod(scene_file)})
