"""Copies of tasks of the library, and a task world in this process."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rlbench_pin.builder.contracts import OpenedTask, TaskText
from rlbench_pin.builder.worker.problems import Pair
from rlbench_pin.builder.worker.world import TaskWorld
from rlbench_pin.tasks import LIBRARY

Copied = Callable[[str], TaskText]
Opened = Callable[..., OpenedTask]


def copy_of(name: str, folder: Path) -> TaskText:
    """Copy the pair of a task of the library into a folder, and return it as an editor has it."""
    folder.mkdir(parents=True, exist_ok=True)
    scene, python = ((LIBRARY / f"{name}{suffix}").read_text(encoding="utf-8") for suffix in (".toml", ".py"))
    (folder / f"{name}.toml").write_text(scene, encoding="utf-8")
    (folder / f"{name}.py").write_text(python, encoding="utf-8")
    return TaskText(name, folder, scene, python)


@pytest.fixture
def copied(tmp_path: Path) -> Copied:
    """Return what copies a task of the library."""
    return lambda name: copy_of(name, tmp_path / "mine")


@pytest.fixture(scope="package")
def world() -> Iterator[TaskWorld]:
    """A task world in this process."""
    world = TaskWorld()
    yield world
    world.close()


@pytest.fixture
def opened(world: TaskWorld) -> Opened:
    """Return what opens a text in the world, or puts another scene in its place."""

    def build(text: TaskText, *, run_task: bool = True, place: bool = False) -> OpenedTask:
        python = text.folder / f"{text.name}.py"
        python.write_text(text.python, encoding="utf-8")
        python.with_suffix(".toml").write_text(text.scene, encoding="utf-8")
        return world.place() if place else world.open(Pair(python, text.folder), run_task, "panda")

    return build
