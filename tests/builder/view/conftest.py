"""Pages that nobody looks at, of copies of tasks."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from viser import ViserServer

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.view import Window
from rlbench_pin.tasks.registry import LIBRARY
from tests.builder.view.stand_ins import StageStandIn


@pytest.fixture
def copied(tmp_path: Path) -> Callable[[str], TaskDocument]:
    """Open a copy of a task of the library."""

    def copy(name: str) -> TaskDocument:
        for ending in (".toml", ".py"):
            shutil.copy(LIBRARY / f"{name}{ending}", tmp_path)
        return TaskDocument.open(tmp_path / f"{name}.toml")

    return copy


Show = Callable[[TaskDocument, StageStandIn], Window]
"""Shows a document."""


@pytest.fixture
def show() -> Iterator[Show]:
    """Show documents; everything is closed afterwards."""
    ends: list[Callable[[], object]] = []

    def shown(document: TaskDocument, stage: StageStandIn) -> Window:
        server = ViserServer("127.0.0.1", 0, verbose=False)
        window = Window(server, document, stage)
        ends.extend([server.stop, window.close])
        settle(window)
        return window

    yield shown
    for end in reversed(ends):
        end()


def settle(window: Window) -> None:
    """Wait until everything was done that was asked for."""
    for _ in range(3):
        assert window.session.edits.wait(20.0)
        assert window.watch.wait(20.0)
    assert window.session.edits.wait(20.0)
