"""Both files as text: edited in the page, and by an editor beside it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rlbench_pin.builder.document import TaskDocument
from tests.builder.browser.conftest import Desk, Sit
from tests.builder.browser.page import until

SCENE, PYTHON = "pick_and_lift.toml", "pick_and_lift.py"
SOON = 20.0
PLACE, ELSEWHERE = "pose = [0.0, 0.12, 0.0225]", "pose = [0.05, 0.12, 0.0225]"


def _stands(desk: Desk, x: float) -> None:
    """Wait until the body stands there in the page's scene."""
    until(lambda: abs(desk.session.places.elements["distractor0"][0] - 0.25 - x) < 1e-9, f"the body at {x}", SOON)
    until(lambda: abs(_drawn_at(desk)[0] - 0.25 - x) < 1e-6, f"the body drawn at {x}", SOON)


def _drawn_at(desk: Desk) -> np.ndarray:
    """Return where the page's scene has the body."""
    script = "return [...window.__viserMutable.nodePoseData['/bodies/distractor0/0'].position]"
    return np.array(desk.page.browser.execute_script(script))


def test_texts_are_edited_in_place(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """What is valid counts at once; what is not is told at its line, the last good scene stays, and it can be repaired."""
    document = copied("pick_and_lift")
    desk, before = sit(document), document.text
    page = desk.page
    desk.settle()
    page.quiet()
    page.tab("Files")
    _apply(desk, SCENE, before.scene.replace(PLACE, ELSEWHERE))
    _stands(desk, 0.05)
    broken = document.scene_text.replace('name = "distractor0"', 'name = "distractor0', 1)
    _apply(desk, SCENE, broken)
    line = next(number for number, text in enumerate(broken.splitlines(), 1) if text == 'name = "distractor0')
    assert [(problem.file, problem.line) for problem in document.problems] == [("scene", line)]
    page.shows("Problems (1)")
    page.shows(f"line {line}:")
    page.screenshot("broken_scene")
    _stands(desk, 0.05)
    _apply(desk, SCENE, before.scene)
    until(lambda: "Problems" not in page.text, "no problems")
    _stands(desk, 0.0)
    _apply(desk, PYTHON, before.python.replace("def init_task(self) -> None:", "def init_task(self) -> None", 1))
    page.shows("Problems (1)")
    assert [problem.file for problem in document.problems] == ["task"]
    _apply(desk, PYTHON, before.python)
    until(lambda: "Problems" not in page.text, "no problems")
    while document.undoable:
        step = document.step
        page.press(f"Undo: {document.undoable}")
        until(lambda step=step: document.step != step, "undone")  # type: ignore[misc]
    assert document.text == before
    assert page.errors() == []


def _apply(desk: Desk, name: str, text: str) -> None:
    """Put a text into the field of a file, and apply it."""
    desk.page.paste(name, text)
    until(lambda: desk.page.field(name).get_attribute("value") == text, "the text in the field")
    desk.page.press(f"Apply {name}")
    document = desk.document
    until(lambda: (document.scene_text if name == SCENE else document.python_text) == text, "the text is taken")


def test_an_editor_beside_the_page(sit: Sit, copied: Callable[[str], TaskDocument]) -> None:
    """A file that is written elsewhere is read again, also a broken one, and that is undone; unsaved work is asked about."""
    document = copied("pick_and_lift")
    desk, before = sit(document), document.text
    page, file = desk.page, document.folder / SCENE
    desk.settle()
    page.quiet()
    changed = before.scene.replace(PLACE, ELSEWHERE)
    file.write_text(changed)
    page.shows("Read again")
    assert document.scene_text == changed
    _stands(desk, 0.05)
    file.write_text(changed.replace("[placement]", "[placement"))
    page.shows("Problems (1)")
    _stands(desk, 0.05)
    page.screenshot("broken_on_disk")
    page.press(f"Undo: {document.undoable}")
    until(lambda: document.scene_text == changed, "the text before")
    until(lambda: "Problems" not in page.text, "no problems")
    file.write_text(before.scene)
    page.tab("Files")
    page.shows("changed on disk")
    page.press("Load the files from disk")
    until(lambda: document.scene_text == before.scene, "what is on disk")
    _stands(desk, 0.0)
    (document.folder / PYTHON).write_bytes(b"\xff\xfe no text")
    page.shows("Not done")
    assert document.python_text == before.python
    (document.folder / PYTHON).write_text(before.python)
    until(lambda: not document.unsaved, "nothing to save")
    assert page.errors() == []
