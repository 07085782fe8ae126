"""Both files can be read and edited in the page: lines have numbers, problems their place, and nothing typed gets lost."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from urllib.parse import unquote

import pytest
from viser import ViserServer

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.view.files import problem_html
from rlbench_pin.builder.view.widgets import CodeField, line_numbers
from rlbench_pin.viewer.recording import Problem
from tests.builder.view.conftest import Show, control, settle, text
from tests.builder.view.stand_ins import WorkerStandIn


@pytest.fixture
def viser() -> Iterator[ViserServer]:
    """A page that nobody looks at."""
    server = ViserServer("127.0.0.1", 0, verbose=False)
    yield server
    server.stop()


def test_lines_have_numbers_and_wrong_ones_are_red() -> None:
    """As many as there are, and the wrong one in red."""
    image = unquote(line_numbers("code-0", 3, (2,)))
    assert [f">{k}</text>" in image for k in (1, 2, 3, 4)] == [True, True, True, False]
    assert image.count("#fdd8d3") == 1 and 'fill="#c0392b">2<' in image


def test_what_was_typed_outlives_another_edit(viser: ViserServer) -> None:
    """A drag meanwhile changes the file, not what somebody is typing; applied or discarded, field and file agree again."""
    field = CodeField(viser.gui, "a.toml", "one", lambda is_typed: None)
    field.show("two")
    assert field.typed == "two" and not field.discard.visible
    field._text.value = "two and more"
    field.show("three")
    assert field.typed == "two and more" and field.discard.visible
    assert "changed while you typed" in field.warning
    field.discard_typed()
    assert field.typed == "three" and not field.discard.visible
    field._text.value = "four"
    field.show("four")
    field.show("three")  # undone
    assert field.typed == "three"


def test_saving_says_what_is_typed_and_not_applied(copied: Callable[[str], TaskDocument], show: Show) -> None:
    """The file gets what was applied; the page says that more is typed, until it is applied or discarded."""
    window, told = show(copied("pick_and_lift"), WorkerStandIn()), list[str]()
    window.session._notify = lambda title, text, bad: told.append(f"{title}: {text}")
    field = control(window, "Files", "code", "pick_and_lift.toml").handle
    field._text.value = "typed"
    field._draw()
    window.session.post(window.session.save)
    settle(window)
    assert any(words.startswith("Not saved: Typed text in pick_and_lift.toml") for words in told)
    assert "not applied" in text(window, "Header")
    field.discard_typed()
    told.clear()
    window.session.post(window.session.save)
    settle(window)
    assert len(told) == 1 and told[0].startswith("Saved: ")


def test_fields_keep_their_places_when_a_file_changes_on_disk(copied: Callable[[str], TaskDocument], show: Show) -> None:
    """The question comes behind them, so that what somebody is typing is not made anew."""
    document = copied("pick_and_lift")
    window = show(document, WorkerStandIn())
    before = list(window.panels["Files"].controls)
    window.session.post(lambda: window.session.do(lambda d: d.set("block", "fixed", True)))
    settle(window)
    (document.folder / "pick_and_lift.toml").write_text("# by an editor\n")
    window.session.post(window.session.changed)
    settle(window)
    after = window.panels["Files"].controls
    assert after[: len(before)] == before
    assert [c.label for c in after if c.key[0] == "button"][1:] == ["Load the files from disk", "Save over it"]


@pytest.mark.parametrize(
    ("problem", "text"),
    [
        (Problem("scene", 2, "file: it is not valid TOML: expected (at line 2, column 3)."), "a = 1\nb =\nc = 3\n"),
        (Problem("task", 2, "This is no Python: invalid syntax."), "a = 1\nb =\nc = 3\n"),
    ],
)
def test_a_caret_stands_where_reading_ended(problem: Problem, text: str) -> None:
    """Below the line, at its column."""
    html = problem_html(text, problem)
    rows = html.split("<div")
    line = next(k for k, row in enumerate(rows) if "b =" in row)
    assert rows[line + 1].endswith("^</div>") and "Line 2." in html
    assert "^" not in problem_html(text, Problem("task", 1, "The scene has no body 'x'."))


def test_problems_are_text_not_html() -> None:
    """What others wrote is escaped."""
    assert "<script>" not in problem_html("<script>\n", Problem("scene", 1, "<script>"))
