"""The panels that try and judge say what was found, for which files, and what is missing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from rlbench_pin.builder.contracts import Judgement
from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.view import Window
from rlbench_pin.builder.view.widgets import Button, Fold, Item, Markup, Note, Number, Row
from tests.builder.view.conftest import Show, settle
from tests.builder.view.stand_ins import StageStandIn

Copied = Callable[[str], TaskDocument]


def _all(items: Iterable[Item]) -> Iterator[Item]:
    for item in items:
        yield item
        if isinstance(item, Fold):
            yield from _all(item.items)


def _said(window: Window) -> str:
    texts = [item.html if isinstance(item, Markup) else item.text for item in _of(window) if isinstance(item, Markup | Note)]
    return "\n".join(texts)


def _of(window: Window) -> list[Item]:
    return list(_all(window.judging.items()))


def _press(window: Window, label: str) -> None:
    press = next(item.on_press for item in _of(window) if isinstance(item, Button) and item.label == label)
    window.session.post(press)
    settle(window)
    assert window.judging._worker.wait(10.0)
    settle(window)


def _judged(copied: Copied, show: Show, *lines: Judgement) -> Window:
    window = show(copied("pick_and_lift"), StageStandIn(("waypoint0",), lines=lines))
    window.session.post(window.watch.allow)
    settle(window)
    _press(window, "Judge")
    return window


def test_a_verdict_counts_for_the_files_that_were_judged(copied: Copied, show: Show) -> None:
    """An edit makes it one of before; the edit undone, it counts again. Ten demonstrations are not a hundred."""
    window = _judged(copied, show, Judgement("demonstrations", True, "10 of 10"))
    assert window.judging.is_green
    assert "100 demonstrations judged (10 of the files as they stand)" in _said(window)
    window.session.post(lambda: window.session.do(lambda d: d.set("block", "fixed", True)))
    settle(window)
    assert not window.judging.is_green and "have changed since" in _said(window)
    assert "Saved (press Save)" in _said(window)
    window.session.post(lambda: window.session.do(lambda d: d.undo()))
    settle(window)
    assert window.judging.is_green and "have changed since" not in _said(window)
    number = next(item for item in _of(window) if isinstance(item, Number))
    window.session.post(lambda: number.on_change(100.0))
    settle(window)
    _press(window, "Judge")
    assert window.session.document.name == "pick_and_lift" and "100 demonstrations judged<" in _said(window)


def test_a_failure_opens_at_its_seed(copied: Copied, show: Show) -> None:
    """One click plays it; of many, it is said how many more there are."""
    failures = tuple((seed, seed % 3, f"cause {seed}") for seed in range(10))
    window = _judged(copied, show, Judgement("demonstrations", False, "0 of 10", failures))
    assert not window.judging.is_green and "cause 7" in _said(window) and "... and 2 more." in _said(window)
    _press(window, "Open seed 7, variation 1")
    assert window.watch.stage.asked[-1] == "demonstrate 7 1"  # type: ignore[attr-defined]


def test_the_map_has_a_legend(copied: Copied, show: Show) -> None:
    """What each colour means and how often it is there; taken away, both are gone."""
    window = _judged(copied, show)
    _press(window, "Map of what can be reached")
    assert "<b>1</b> the hand gets to all waypoints" in _said(window)
    _press(window, "Take the map away")
    assert "all waypoints" not in _said(window)
    assert window._viser.scene.get_handle_by_name("/reach") is None


def test_what_is_missing_is_said_with_where_to_find_it(copied: Copied, show: Show, tmp_path) -> None:  # type: ignore[no-untyped-def]
    """Of an empty task nearly all."""
    window = show(TaskDocument.new(tmp_path, "nothing_yet"), StageStandIn())
    said = _said(window)
    for missing in ("Waypoints for a demonstration (see Add)", "A success condition (see Behaviour)", "green for the files"):
        assert missing in said
    assert "Docstrings that say what varies and what counts (see Behaviour)" in said and "Saved (press Save)" in said


def test_seeds_are_walked_through(copied: Copied, show: Show) -> None:
    """Next, before (not below 0), random; each is laid out at once, and time passes in steps."""
    stage = StageStandIn()
    window = show(copied("pick_and_lift"), stage)

    def press(label: str) -> str:
        row = next(item for item in window.tryout.items() if isinstance(item, Row) and label in item.presses)
        window.session.post(row.presses[label])
        settle(window)
        return stage.asked[-1]

    assert [press("Next"), press("Next"), press("Before")] == ["reset 1 0", "reset 2 0", "reset 1 0"]
    assert [press("Before"), press("Before")] == ["reset 0 0", "reset 0 0"]
    assert press("Random") != "reset 0 0"
    assert [press("0.05 s"), press("2 s")] == ["simulate 0.05", "simulate 2.0"]
