"""The panels *Try* and *Validate* show results, for which files they hold, and what is missing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rlbench_pin.builder.contracts import ValidationLine
from rlbench_pin.builder.document import TaskDocument, condition_kinds
from rlbench_pin.builder.view import Window
from tests.builder.view.conftest import Show, call, control, press, settle, text
from tests.builder.view.stand_ins import WorkerStandIn

Copied = Callable[[str], TaskDocument]


def _press(window: Window, label: str) -> None:
    press(window, "Validate", label)
    assert window.validation.requests.wait(10.0)
    settle(window)


def _validated(copied: Copied, show: Show, *lines: ValidationLine) -> Window:
    window = show(copied("pick_and_lift"), WorkerStandIn(("waypoint0",), lines=lines))
    window.session.post(window.world.allow_code)
    settle(window)
    _press(window, "Validate")
    return window


def test_a_verdict_counts_for_the_files_that_were_validated(copied: Copied, show: Show) -> None:
    """An edit makes it one of before; the edit undone, it counts again. Ten demonstrations are not a hundred."""
    window = _validated(copied, show, ValidationLine("demonstrations", True, "10 of 10"))
    assert window.validation.is_green
    assert "100 demonstrations validated (10 of the present files)" in text(window, "Validate")
    window.session.post(lambda: window.session.do(lambda d: d.set("block", "fixed", True)))
    settle(window)
    assert not window.validation.is_green and "have changed since" in text(window, "Validate")
    assert "Saved (press Save)" in text(window, "Validate")
    window.session.post(lambda: window.session.do(lambda d: d.undo()))
    settle(window)
    assert window.validation.is_green and "have changed since" not in text(window, "Validate")
    call(window, control(window, "Validate", "number", "Demonstrations"), 100.0)
    _press(window, "Validate")
    assert window.session.document.name == "pick_and_lift" and "100 demonstrations validated<" in text(window, "Validate")


def test_a_failure_opens_at_its_seed(copied: Copied, show: Show) -> None:
    """One click plays it; of many, it is said how many more there are."""
    failures = tuple((seed, seed % 3, f"cause {seed}") for seed in range(10))
    window = _validated(copied, show, ValidationLine("demonstrations", False, "0 of 10", failures))
    assert (
        not window.validation.is_green and "cause 7" in text(window, "Validate") and "... and 2 more." in text(window, "Validate")
    )
    _press(window, "Open seed 7, variation 1")
    assert window.world.worker.asked[-1] == "demonstrate 7 1"  # type: ignore[attr-defined]


def test_the_map_has_a_legend(copied: Copied, show: Show) -> None:
    """What each colour means and how often it is there; taken away, both are gone."""
    window = _validated(copied, show)
    _press(window, "Reach map")
    assert "<b>1</b> the gripper reaches all waypoints" in text(window, "Validate")
    _press(window, "Remove the map")
    assert "all waypoints" not in text(window, "Validate")
    assert window._viser.scene.get_handle_by_name("/reach") is None


def test_what_is_missing_is_said_with_where_to_find_it(copied: Copied, show: Show, tmp_path) -> None:  # type: ignore[no-untyped-def]
    """Of an empty task nearly all."""
    window = show(TaskDocument.new(tmp_path, "nothing_yet"), WorkerStandIn())
    said = text(window, "Validate")
    for missing in (
        "Waypoints for a demonstration (see Add)",
        "A success condition (see Behaviour)",
        "green for the present files",
    ):
        assert missing in said
    assert "Docstrings about variations and success (see Behaviour)" in said and "Saved (press Save)" in said


def test_seeds_are_walked_through(copied: Copied, show: Show) -> None:
    """Next, before (not below 0), random; each is laid out at once, and time passes in steps."""
    worker = WorkerStandIn()
    window = show(copied("pick_and_lift"), worker)

    def pressed(label: str) -> str:
        press(window, "Try", label)
        return worker.asked[-1]

    assert [pressed("Next"), pressed("Next"), pressed("Before")] == ["reset 1 0", "reset 2 0", "reset 1 0"]
    assert [pressed("Before"), pressed("Before")] == ["reset 0 0", "reset 0 0"]
    assert pressed("Random") != "reset 0 0"
    assert [pressed("0.05 s"), pressed("2 s")] == ["simulate 0.05", "simulate 2.0"]


NONE = "registers no success condition"


def test_missing_conditions_are_named_once_the_code_was_run(copied: Copied, show: Show) -> None:
    """Before, the scene stands alone: nothing is known about its conditions."""
    worker = WorkerStandIn(conditions=())
    window = show(copied("pick_and_lift"), worker)
    press(window, "Try", "Reset")
    assert NONE not in text(window, "Try") and NONE not in window.player._conditions.content
    press(window, "Try", "Run the code of pick_and_lift.py")
    assert NONE in text(window, "Try")
    worker.conditions = ("a condition",)
    window.session.post(lambda: window.session.do(lambda d: d.set_python_text(d.python_text + "\n")))
    settle(window)
    assert NONE not in text(window, "Try")


def test_the_page_does_not_ask_about_python_that_the_builder_wrote(show: Show, tmp_path: Path) -> None:
    """It runs from the start, also after edits by forms; it is asked about what was typed, and not again once that is undone."""
    document, worker = TaskDocument.new(tmp_path, "reach_it"), WorkerStandIn()
    window = show(document, worker)

    def do(edit: Callable[[TaskDocument], object]) -> str:
        window.session.post(lambda: window.session.do(edit))
        settle(window)
        return text(window, "Try")

    assert "read it first" not in text(window, "Try")
    assert "read it first" not in do(lambda d: d.set_behaviour("title", "Reach it."))
    assert "read it first" not in do(lambda d: d.add("frame", {}))
    assert "read it first" not in do(lambda d: d.save())
    assert {asked for asked in worker.asked if asked.startswith("open")} == {"open True"}
    typed = document.python_text + "\nprint(1)\n"
    assert "read it first" in do(lambda d: d.set_python_text(typed))
    assert "read it first" in do(lambda d: d.set_behaviour("title", "Touch it."))
    assert worker.asked[-1] == "open False"
    do(lambda d: d.undo())
    assert "read it first" not in do(lambda d: d.undo())
    assert worker.asked[-1] == "open True"
    (tmp_path / "reach_it.py").write_text(typed)
    assert "read it first" in do(lambda d: d.reload())
    assert "read it first" in text(show(TaskDocument.open(tmp_path / "reach_it.py"), WorkerStandIn()), "Try")


def test_words_of_the_validator_and_kinds_of_conditions_have_legends(copied: Copied, show: Show) -> None:
    """Each line that is there, and each kind that a button adds."""
    window = _validated(copied, show, ValidationLine("replay", True, "9/10", meaning="Recorded actions reach the goal again."))
    assert "- **replay**: Recorded actions reach the goal again." in text(window, "Validate")
    said = text(window, "Behaviour")
    assert all(f"- **{kind.name}**: {kind.text}" in said for kind in condition_kinds())
