"""Whatever is done in the page: the server lives, nothing is raised, every edit can be undone, and what is saved can be read."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path

import pytest

from rlbench_pin.builder.contracts import TaskText
from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.scene import read_scene
from tests.builder.browser.conftest import Desk, Sit
from tests.builder.browser.page import until
from tests.builder.browser.wild_user import WildUser

BURST = 12
WORK = ("Validate", "Map of what", "Simulate", "Demonstration", "Plan paths")
"""Buttons that keep a machine busy for long; the long form presses them, too."""
SAVE_AS = "showSaveFilePicker"
"""What the page's own menu asks of a browser that has nobody to answer."""
Copied = Callable[[str], TaskDocument]


def _check(desk: Desk, user: WildUser, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]) -> None:
    """Nothing was raised on either side, and the document is valid, or says why it is not."""
    desk.window.validation.stop()
    desk.settle()
    story = "\n".join(user.done[-3 * BURST :])
    out, err = capfd.readouterr()
    assert [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR] == [], story
    assert "Traceback" not in out + err, f"{out}{err}\n{story}"
    assert "A mistake of the builder" not in desk.page.text, story
    assert [error for error in desk.page.errors() if SAVE_AS not in error] == [], story
    document = desk.document
    if all(problem.file != "scene" for problem in document.problems):
        file = document.folder / "looked_at.toml"
        file.write_text(document.scene_text)
        read_scene(file)
        file.unlink()
    assert all(problem.message for problem in document.problems)


def _undo_all(desk: Desk, before: TaskText) -> None:
    """Take everything back, and make it again: the same bytes."""
    document, session = desk.document, desk.session
    session.post(lambda: None)
    desk.settle()
    wild, count = document.text, 0
    while document.undoable:
        document.undo()
        count += 1
        assert count < 5000
    assert document.text == before
    for _ in range(count):
        document.redo()
    assert document.text == wild
    session.post(session.changed)
    desk.settle()


def _run(
    desk: Desk,
    seed: int,
    bursts: int,
    caplog: pytest.LogCaptureFixture,
    capfd: pytest.CaptureFixture[str],
    leave: tuple[str, ...],
) -> None:
    before = desk.document.text
    desk.settle()
    desk.page.quiet()
    user = WildUser(desk, seed, ("Run the code", *leave))
    for _ in range(bursts):
        user.act(BURST)
        _check(desk, user, caplog, capfd)
    _undo_all(desk, before)
    _check(desk, user, caplog, capfd)
    document = desk.document
    document.save(over=True)
    assert not document.unsaved
    kept = TaskDocument.open(document.folder / f"{document.name}.toml")
    assert kept.text == document.text
    until(lambda: f"{document.name}" in desk.page.text, "the page lives")


def test_a_wild_user(
    sit: Sit, copied: Copied, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """A few bursts."""
    _run(sit(copied("pick_and_lift")), 7, 3, caplog, capfd, WORK)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("task", ["pick_and_lift", "open_drawer", "light_bulb_in", "wipe_desk"])
def test_wilder_users(
    sit: Sit, copied: Copied, task: str, seed: int, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    """Many more, with the code of the task allowed to run in every other."""
    desk = sit(copied(task))
    if seed % 2:
        desk.session.post(desk.window.world.allow_code)
    _run(desk, seed, 12, caplog, capfd, ())
