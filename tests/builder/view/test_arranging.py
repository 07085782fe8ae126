"""Things are hung on others by dropping, waypoints change places, and what is deleted with others is asked first."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from viser import FrameHandle

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.view import Window
from rlbench_pin.builder.view.placing import top_grasp
from rlbench_pin.spatial import IDENTITY, compose, pose_at, pose_to_matrix
from tests.builder.view.conftest import Show, call, control, controls, press, settle, text
from tests.builder.view.stand_ins import WorkerStandIn

Copied = Callable[[str], TaskDocument]


def _select(window: Window, name: str) -> None:
    window.session.post(lambda: window.session.select(name))
    settle(window)


def _choose(window: Window, label: str, word: str) -> None:
    call(window, control(window, "Selected", "dropdown", label), word)


def _press(window: Window, label: str) -> None:
    press(window, "Selected", label)


def _press_in_pose(window: Window, number: int, label: str) -> None:
    """Press a button of a pose of a curve."""
    folders = [c.children for c in controls(window.panels["Selected"]) if c.key[0] == "folder" and c.label.startswith("Pose")]
    folder = folders[number]
    assert folder is not None
    call(window, next(c for c in folder.controls if c.key[0] == "button row"), label)


def _drop(window: Window, name: str, place: np.ndarray) -> list[str]:
    """Drag an element to a world point (3,), and return what was marked meanwhile."""
    _select(window, name)
    start = window.session.places.of(name)
    assert start is not None
    goal = np.concatenate([place, start[3:]])
    window.dragging.drag(start, "start")
    window.dragging.drag(goal, "update")
    marked = window.drop_mark.shown
    settle(window)
    window.dragging.drag(goal, "end")
    settle(window)
    return [marked, window.drop_mark.shown]


@pytest.mark.parametrize("name", ["distractor0", "waypoint3", "goal"])
def test_what_is_dropped_onto_a_body_hangs_on_it(copied: Copied, show: Show, name: str) -> None:
    """The body is marked meanwhile; the element stays where it was let go, and one undo takes drag and parent back."""
    document = copied("pick_and_lift")
    window, texts = show(document, WorkerStandIn()), document.text
    window.session.drops_onto, window.session.snap = True, "free"
    block = window.session.places.of("distractor1")
    assert block is not None
    goal = block[:3] + np.array([0.004, -0.003, 0.0613])
    assert _drop(window, name, goal) == ["distractor1", ""]
    thing, place = window.session.element(name), window.session.places.of(name)
    assert thing is not None and place is not None
    assert thing.parent == "distractor1"
    assert np.abs(place[:3] - goal).max() < 1e-9
    window.session.post(lambda: window.session.do(lambda d: d.undo()))
    settle(window)
    assert document.text == texts and not document.undoable


def test_nothing_is_dropped_onto_itself_or_beside_bodies(copied: Copied, show: Show) -> None:
    """What hangs on an element is no target, nor is the empty table; without the switch a drag is a drag."""
    document = copied("pick_and_lift")
    window = show(document, WorkerStandIn())
    window.session.drops_onto = True
    there = window.session.places.of("block")
    assert there is not None
    assert _drop(window, "marker", there[:3] + [0.0, 0.0, 0.05]) == ["block", ""]
    assert _drop(window, "block", there[:3] + [0.0, 0.0, 0.06]) == ["", ""]  # the marker hangs on it by now
    assert _drop(window, "distractor0", np.array([0.1, -0.3, 0.8])) == ["", ""]
    assert window.session.element("distractor0").parent == "root"  # type: ignore[union-attr]
    window.session.drops_onto = False
    here = window.session.places.of("distractor1")
    assert here is not None
    assert _drop(window, "distractor0", here[:3] + [0.0, 0.0, 0.05]) == ["", ""]
    assert window.session.element("distractor0").parent == "root"  # type: ignore[union-attr]


def test_a_chosen_parent_keeps_the_place_in_one_edit(copied: Copied, show: Show) -> None:
    """By the choice in the panel."""
    document = copied("setup_checkers")
    window, texts = show(document, WorkerStandIn()), document.text
    before = window.session.places.of("waypoint1")
    _select(window, "waypoint1")
    _choose(window, "Parent", "square0")
    after = window.session.places.of("waypoint1")
    assert before is not None and after is not None
    assert window.session.element("waypoint1").parent == "square0"  # type: ignore[union-attr]
    assert np.abs(after - before).max() < 1e-9
    document.undo()
    assert document.text == texts and not document.undoable


def test_waypoints_change_places(copied: Copied, show: Show) -> None:
    """Earlier, later, to a number; the selection goes along, and the list shows them in order with the cause."""
    document = copied("pick_and_lift")
    window = show(document, WorkerStandIn(("waypoint0", "waypoint1", "waypoint2", "waypoint3"), "unreachable"))
    before = document.spec
    _select(window, "waypoint1")
    listed = [c.values for c in controls(window.panels["Selected"]) if c.label.startswith("visit ")]
    labels = [str(values[0]) for values in listed]
    assert [label[:2] for label in labels] == ["0 ", "1 ", "2 ", "3 "]
    assert [values[1] for values in listed] == ["red", "blue", "red", "red"]
    assert "close" in labels[1] and "on block" in labels[1]
    _press(window, "Later")
    assert window.session.selected == "waypoint2" and window.session.element("waypoint2").parent == "block"  # type: ignore[union-attr]
    _choose(window, "Visited as", "waypoint1")
    assert window.session.selected == "waypoint1" and document.spec == before
    _select(window, "waypoint0")
    _press(window, "Earlier")
    assert document.spec == before


def test_a_curve_is_made_of_poses(copied: Copied, show: Show) -> None:
    """Poses are added, changed, put earlier and removed; a curve without any is refused."""
    document = copied("pick_and_lift")
    window = show(document, WorkerStandIn())
    _select(window, "waypoint2")
    _choose(window, "Path", "curve")
    _choose(window, "Curve", "poses to pass")
    _press(window, "Add a pose after the last")

    def heights() -> list[float]:
        assert document.spec is not None
        return [point[2] for point in document.spec.waypoint[2].points]

    assert heights() == [-0.05, 0.0, 0.02]
    _press_in_pose(window, 2, "Earlier")
    assert heights() == [-0.05, 0.02, 0.0]
    drawn = window._viser.scene.get_handle_by_name("/curve/1")
    goal = window.session.places.of("waypoint2")
    assert isinstance(drawn, FrameHandle) and goal is not None
    assert np.allclose(drawn.position, compose(goal, np.array([0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 1.0]))[:3], atol=1e-6)
    for count in (2, 1, 1):
        _press_in_pose(window, 0, "Remove")
        assert len(heights()) == count
    _select(window, "block")
    assert window._viser.scene.get_handle_by_name("/curve/0") is None


def test_deleting_what_others_need_is_asked_first(copied: Copied, show: Show) -> None:
    """The panel lists what would go; then conditions and grasps that name it go as well, and one undo brings all back."""
    document = copied("pick_and_lift")
    window, texts = show(document, WorkerStandIn()), document.text
    _select(window, "block")
    _press(window, "Delete")
    asked = text(window, "Selected")
    assert "waypoint1" in asked and 'objects(["block"])' in asked and document.text == texts
    _press(window, "Keep it")
    assert window.session.pending_deletion is None and document.text == texts
    _press(window, "Delete")
    _press(window, "Delete with all dependants")
    assert window.session.selected == "" and document.spec is not None and not [p for p in document.problems if p.file == "scene"]
    assert [w.name for w in document.spec.waypoint] == ["waypoint0"]
    assert document.behaviour.graspable == ()
    document.undo()
    assert document.text == texts and not document.undoable


@pytest.mark.parametrize("new", ["", "marker", "Block", "a b", "table", "root"])
def test_a_bad_name_is_refused(copied: Copied, show: Show, new: str) -> None:
    """Empty, taken, not a name, reserved: nothing has changed, and the element stays selected."""
    document = copied("pick_and_lift")
    window, texts = show(document, WorkerStandIn()), document.text
    told: list[str] = []
    window.session._notify = lambda title, text, bad: told.append(text)
    _select(window, "block")
    call(window, control(window, "Selected", "entry", "Name"), new)
    assert document.text == texts and window.session.selected == "block" and len(told) == 1 and told[0]


def test_waypoints_are_added_above_the_selected_object_and_as_its_grasp(copied: Copied, show: Show) -> None:
    """The gripper points down: 10 cm above the middle, and at the middle with fingers that close; the body stays the object."""
    document = copied("pick_and_lift")
    window = show(document, WorkerStandIn())
    disabled = [c.values[2] for c in controls(window.panels["Add"]) if "the selected object" in str(c.values[:1])]
    assert disabled == [True, True]
    _select(window, "block")
    for label in ("Above block", "Grasp block", "Above block"):
        press(window, "Add", label)
    spec, block = document.spec, window.session.places.of("block")
    assert spec is not None and block is not None and window.session.selected == "waypoint6"
    above, grasp, again = spec.waypoint[4:]
    assert {w.parent for w in (above, grasp, again)} == {"block"} and above.pose == again.pose
    assert (above.gripper, grasp.gripper, grasp.ignore_collisions, grasp.symmetry) == (None, "close", True, 4)
    tip = window.session.places.of("waypoint5")
    assert tip is not None
    np.testing.assert_allclose(tip[:3], block[:3], atol=1e-4)
    np.testing.assert_allclose(pose_to_matrix(tip)[:3, 2], (0.0, 0.0, -1.0), atol=1e-6)
    np.testing.assert_allclose(np.array(above.pose[:3]) - grasp.pose[:3], (0.0, 0.0, 0.1), atol=1e-4)


def test_a_grasp_is_across_the_narrowest_side(copied: Copied, show: Show) -> None:
    """However the object is turned, and near the top of a high one; what is too wide for the gripper is refused."""
    box = np.array(list(itertools.product((-0.02, 0.02), (-0.06, 0.06), (-0.1, 0.1))))
    for yaw in (0.0, 0.4, 2.0):
        grasp = top_grasp(pose_at((0.3, 0.1, 0.9), yaw=yaw), box)
        opening = pose_to_matrix(grasp.pose)[:3, 1]
        assert abs(opening @ (np.cos(yaw), np.sin(yaw), 0.0)) == pytest.approx(1.0)
        assert (grasp.width, grasp.symmetry) == (pytest.approx(0.04), 2)
        np.testing.assert_allclose(grasp.pose[:3], (0.3, 0.1, 0.97), atol=1e-9)
    circle = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
    assert top_grasp(IDENTITY, 0.03 * np.stack([np.cos(circle), np.sin(circle), circle * 0.1], axis=1)).symmetry == 12
    document = copied("pick_and_lift")
    window, told = show(document, WorkerStandIn()), []
    window.session._notify = lambda title, text, bad: told.append(text)
    window.session.post(lambda: window.session.do(lambda d: d.set("block", "scale", 2.0)))
    _select(window, "block")
    before = document.text
    press(window, "Add", "Grasp block")
    assert document.text == before and "9.0 cm wide, and the gripper opens 8 cm" in told[0]


def test_frames_regions_and_sensors_are_above_the_catalogue(copied: Copied, show: Show) -> None:
    """They need no scrolling past the objects, and a sensor is attached to what is selected."""
    document = copied("pick_and_lift")
    window = show(document, WorkerStandIn())
    labels = [c.label for c in controls(window.panels["Add"])]
    assert max(labels.index(f"Add {kind}") for kind in ("frame", "region", "sensor")) < labels.index("Search")
    _select(window, "block")
    press(window, "Add", "Add sensor")
    assert window.session.element("sensor").parent == "block"  # type: ignore[union-attr]
