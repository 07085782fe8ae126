"""Copies of tasks of the library, and a stage in this process."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rlbench_pin.builder.contracts import OpenedTask, TaskText
from rlbench_pin.builder.stage.inside.world import StageWorld
from rlbench_pin.builder.stage.problems import Pair
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
def stage() -> Iterator[StageWorld]:
    """The world of a stage, in this process."""
    world = StageWorld()
    yield world
    world.close()


@pytest.fixture
def opened(stage: StageWorld) -> Opened:
    """Return what opens a text in the stage, or puts another scene in its place."""

    def build(text: TaskText, *, run_task: bool = True, place: bool = False) -> OpenedTask:
        python = text.folder / f"{text.name}.py"
        python.write_text(text.python, encoding="utf-8")
        python.with_suffix(".toml").write_text(text.scene, encoding="utf-8")
        return stage.place() if place else stage.open(Pair(python, text.folder), run_task, "panda")

    return build
