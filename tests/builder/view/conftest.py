"""Pages that nobody looks at, of copies of tasks."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from viser import ViserServer

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.view import Window
from rlbench_pin.builder.view.widgets import Control, Panel
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
        assert window.world.wait(20.0)
    assert window.session.edits.wait(20.0)


def controls(panel: Panel) -> Iterator[Control]:
    """Yield all controls of a panel, also those in folders."""
    for found in panel.controls:
        yield found
        if found.children is not None:
            yield from controls(found.children)


def control(window: Window, panel: str, kind: str, label: str) -> Control:
    """Return the only control of a kind and label, or the first of several alike."""
    present = list(controls(window.panels[panel]))
    return next(c for c in present if c.key[0] == kind and c.label == label)


def call(window: Window, found: Control, value: object = None) -> None:
    """Do what a control does when a browser gives it a value."""
    window.session.post(lambda: found.callback(value))
    settle(window)


def press(window: Window, panel: str, label: str) -> None:
    """Press a button, or one of a row of buttons."""
    present = list(controls(window.panels[panel]))
    found = [c for c in present if c.key[0] == "button" and c.values[0] == label]
    found += [c for c in present if c.key[0] == "button row" and label in c.key[2:]]
    assert len(found) == 1, label
    call(window, found[0], label)


def text(window: Window, panel: str) -> str:
    """Return all notes and HTML of a panel."""
    return "\n".join(str(c.values[0]) for c in controls(window.panels[panel]) if c.key[0] in ("note", "html"))
