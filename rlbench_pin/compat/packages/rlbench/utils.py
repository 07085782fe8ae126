"""Task classes by name, and stored demonstrations."""

from __future__ import annotations

import importlib

import numpy as np

from rlbench.backend.task import Task
from rlbench_pin.compat.known_tasks import KNOWN_TASKS
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.environment.stored import StoredSelection, read_stored_demos
from rlbench_pin.errors import UnknownName
from rlbench_pin.observation import Demo
from rlbench_pin.tasks.registry import camel_case


class InvalidTaskName(UnknownName):
    """No task has the name."""


def name_to_task_class(task_file: str) -> type[Task]:
    """Return the class of a task for the name of its file, with or without `.py`: `reach_target` -> `ReachTarget`.

    Raises:
        InvalidTaskName: No task has that name.
    """
    name = task_file.removesuffix(".py")
    try:
        module = importlib.import_module(f"rlbench.tasks.{name}")
    except ModuleNotFoundError as error:
        if error.name != f"rlbench.tasks.{name}":
            raise
        raise InvalidTaskName("task", task_file, KNOWN_TASKS) from error
    found = getattr(module, camel_case(name), None)
    if not isinstance(found, type) or not issubclass(found, Task):
        raise InvalidTaskName("task", task_file, KNOWN_TASKS)
    return found


def get_stored_demos(
    amount: int,
    image_paths: bool,
    dataset_root: str,
    variation_number: int,
    task_name: str,
    obs_config: ObservationConfig,
    random_selection: bool = True,
    from_episode_number: int = 0,
) -> list[Demo]:
    """Return stored demonstrations of one task, from folders of either RLBench layout or from files of this package.

    Args:
        amount: Number of demonstrations; -1 reads all.
        image_paths: Return paths of image files instead of images.
        dataset_root: Folder with a folder for each task.
        variation_number: Number of the variation; -1 selects any.
        task_name: Name of the task.
        obs_config: Contents of observations.
        random_selection: Select with numpy's global generator; otherwise in natural order.
        from_episode_number: First episode without random selection.

    Raises:
        DatasetError: Data are missing or damaged, or too few demonstrations are stored (also a RuntimeError).
    """
    wanted = StoredSelection(amount, variation_number, image_paths, random_selection, from_episode_number)
    rng = np.random.default_rng(int(np.random.randint(2**31)) if random_selection else 0)
    return read_stored_demos(dataset_root, task_name, wanted, obs_config, rng)


__all__ = ["InvalidTaskName", "get_stored_demos", "name_to_task_class"]
