"""Things are hung on others by dropping, waypoints change places, and what is deleted with others is asked first."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np
import pytest
from viser import FrameHandle

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.view import Window
from rlbench_pin.builder.view.panels.properties import property_items
from rlbench_pin.builder.view.widgets import Button, Choice, Entry, Fold, Item, Note, Row
from rlbench_pin.spatial import compose
from tests.builder.view.conftest import Show, settle
from tests.builder.view.stand_ins import StageStandIn

Copied = Callable[[str], TaskDocument]


def _all(items: Iterable[Item]) -> Iterator[Item]:
    for item in items:
        yield item
        if isinstance(item, Fold):
            yield from _all(item.items)


def _selected(window: Window, name: str) -> list[Item]:
    window.session.post(lambda: window.session.select(name))
    settle(window)
    return list(_all(property_items(window.session, lambda: None)))


def _press(window: Window, label: str) -> None:
    items = _all(property_items(window.session, lambda: None))
    found = [item.on_press for item in items if isinstance(item, Button) and item.label == label]
    found += [
        item.presses[label]
        for item in _all(property_items(window.session, lambda: None))
        if isinstance(item, Row) and label in item.presses
    ]
    assert len(found) == 1, label
    window.session.post(found[0])
    settle(window)


def _drop(window: Window, name: str, place: np.ndarray) -> list[str]:
    """Drag a thing to a world point (3,), and return what was marked meanwhile."""
    _selected(window, name)
    start = window.session.places.of(name)
    assert start is not None
    goal = np.concatenate([place, start[3:]])
    window._dragging.drag(start, "start")
    window._dragging.drag(goal, "update")
    marked = window._dragging._mark.shown
    settle(window)
    window._dragging.drag(goal, "end")
    settle(window)
    return [marked, window._dragging._mark.shown]


@pytest.mark.parametrize("name", ["distractor0", "waypoint3", "goal"])
def test_what_is_dropped_onto_a_body_hangs_on_it(copied: Copied, show: Show, name: str) -> None:
    """The body is marked meanwhile; the thing stays where it was let go, and one undo takes drag and parent back."""
    document = copied("pick_and_lift")
    window, texts = show(document, StageStandIn()), document.text
    window.session.drops_onto, window.session.snap = True, "free"
    block = window.session.places.of("distractor1")
    assert block is not None
    goal = block[:3] + np.array([0.004, -0.003, 0.0613])
    assert _drop(window, name, goal) == ["distractor1", ""]
    thing, place = window.session.thing(name), window.session.places.of(name)
    assert thing is not None and place is not None
    assert thing.parent == "distractor1"
    assert np.abs(place[:3] - goal).max() < 1e-9
    window.session.post(lambda: window.session.do(lambda d: d.undo()))
    settle(window)
    assert document.text == texts and not document.undoable


def test_nothing_is_dropped_onto_itself_or_beside_bodies(copied: Copied, show: Show) -> None:
    """What hangs on a thing is no target, nor is the empty table; without the switch a drag is a drag."""
    document = copied("pick_and_lift")
    window = show(document, StageStandIn())
    window.session.drops_onto = True
    there = window.session.places.of("block")
    assert there is not None
    assert _drop(window, "marker", there[:3] + [0.0, 0.0, 0.05]) == ["block", ""]
    assert _drop(window, "block", there[:3] + [0.0, 0.0, 0.06]) == ["", ""]  # the marker hangs on it by now
    assert _drop(window, "distractor0", np.array([0.1, -0.3, 0.8])) == ["", ""]
    assert window.session.thing("distractor0").parent == "root"  # type: ignore[union-attr]
    window.session.drops_onto = False
    here = window.session.places.of("distractor1")
    assert here is not None
    assert _drop(window, "distractor0", here[:3] + [0.0, 0.0, 0.05]) == ["", ""]
    assert window.session.thing("distractor0").parent == "root"  # type: ignore[union-attr]


def test_a_chosen_parent_keeps_the_place_in_one_edit(copied: Copied, show: Show) -> None:
    """By the choice in the panel."""
    document = copied("setup_checkers")
    window, texts = show(document, StageStandIn()), document.text
    before = window.session.places.of("waypoint1")
    choice = next(i for i in _selected(window, "waypoint1") if isinstance(i, Choice) and i.label == "Parent")
    window.session.post(lambda: choice.on_change("square0"))
    settle(window)
    after = window.session.places.of("waypoint1")
    assert before is not None and after is not None
    assert window.session.thing("waypoint1").parent == "square0"  # type: ignore[union-attr]
    assert np.abs(after - before).max() < 1e-9
    document.undo()
    assert document.text == texts and not document.undoable


def test_waypoints_change_places(copied: Copied, show: Show) -> None:
    """Earlier, later, to a number; the selection goes along, and the list shows them in order with the cause."""
    document = copied("pick_and_lift")
    window = show(document, StageStandIn(("waypoint0", "waypoint1", "waypoint2", "waypoint3"), "unreachable"))
    before = document.spec
    items = _selected(window, "waypoint1")
    listed = [i for i in items if isinstance(i, Button) and i.key.startswith("visit ")]
    assert [i.label[:2] for i in listed] == ["0 ", "1 ", "2 ", "3 "] and [i.shade for i in listed] == [
        "red",
        "blue",
        "red",
        "red",
    ]
    assert "close" in listed[1].label and "on block" in listed[1].label
    _press(window, "Later")
    assert window.session.selected == "waypoint2" and window.session.thing("waypoint2").parent == "block"  # type: ignore[union-attr]
    choice = next(i for i in _selected(window, "waypoint2") if isinstance(i, Choice) and i.label == "Visited as")
    window.session.post(lambda: choice.on_change("waypoint1"))
    settle(window)
    assert window.session.selected == "waypoint1" and document.spec == before
    _selected(window, "waypoint0")
    _press(window, "Earlier")
    assert document.spec == before


def test_a_curve_is_made_of_poses(copied: Copied, show: Show) -> None:
    """Poses are added, changed, put earlier and removed; a curve without any is refused."""
    document = copied("pick_and_lift")
    window = show(document, StageStandIn())
    path = next(i for i in _selected(window, "waypoint2") if isinstance(i, Choice) and i.label == "Path")
    window.session.post(lambda: path.on_change("curve"))
    settle(window)
    curve = next(i for i in _selected(window, "waypoint2") if isinstance(i, Choice) and i.label == "Curve")
    window.session.post(lambda: curve.on_change("poses to pass"))
    settle(window)
    _press(window, "Add a pose behind the last")

    def heights() -> list[float]:
        assert document.spec is not None
        return [point[2] for point in document.spec.waypoint[2].points]

    assert heights() == [-0.05, 0.0, 0.02]
    folds = [i for i in _selected(window, "waypoint2") if isinstance(i, Fold) and i.label.startswith("Pose")]
    row = next(i for i in folds[2].items if isinstance(i, Row))
    window.session.post(row.presses["Earlier"])
    settle(window)
    assert heights() == [-0.05, 0.02, 0.0]
    drawn = window._viser.scene.get_handle_by_name("/curve/1")
    goal = window.session.places.of("waypoint2")
    assert isinstance(drawn, FrameHandle) and goal is not None
    assert np.allclose(drawn.position, compose(goal, np.array([0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 1.0]))[:3], atol=1e-6)
    for count in (2, 1, 1):
        folds = [i for i in _selected(window, "waypoint2") if isinstance(i, Fold) and i.label.startswith("Pose")]
        window.session.post(next(i for i in folds[0].items if isinstance(i, Row)).presses["Remove"])
        settle(window)
        assert len(heights()) == count
    _selected(window, "block")
    assert window._viser.scene.get_handle_by_name("/curve/0") is None


def test_deleting_what_others_need_is_asked_first(copied: Copied, show: Show) -> None:
    """The panel lists what would go; then conditions and grasps that name it go as well, and one undo brings all back."""
    document = copied("pick_and_lift")
    window, texts = show(document, StageStandIn()), document.text
    _selected(window, "block")
    _press(window, "Delete")
    asked = "\n".join(i.text for i in _all(property_items(window.session, lambda: None)) if isinstance(i, Note))
    assert "waypoint1" in asked and 'objects(["block"])' in asked and document.text == texts
    _press(window, "Keep it")
    assert window.session.needed is None and document.text == texts
    _press(window, "Delete")
    _press(window, "Delete with what hangs on it")
    assert window.session.selected == "" and document.spec is not None and not [p for p in document.problems if p.file == "scene"]
    assert [w.name for w in document.spec.waypoint] == ["waypoint0"]
    assert document.behaviour.graspable == ()
    document.undo()
    assert document.text == texts and not document.undoable


@pytest.mark.parametrize("new", ["", "marker", "Block", "a b", "table", "root"])
def test_a_bad_name_is_refused(copied: Copied, show: Show, new: str) -> None:
    """Empty, taken, not a name, reserved: nothing has changed, and the thing stays selected."""
    document = copied("pick_and_lift")
    window, texts = show(document, StageStandIn()), document.text
    told: list[str] = []
    window.session._notify = lambda title, text, bad: told.append(text)
    entry = next(i for i in _selected(window, "block") if isinstance(i, Entry) and i.label == "Name")
    window.session.post(lambda: entry.on_commit(new))
    settle(window)
    assert document.text == texts and window.session.selected == "block" and len(told) == 1 and told[0]
