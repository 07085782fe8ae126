"""The page shows what is edited, edits reach the text and the worker, and nothing that is broken ends it."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pytest
from viser import MeshHandle, ViserServer

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.view import Window
from rlbench_pin.builder.view.catalogue import primitive_urdf
from tests.builder.view.conftest import Show, control, controls, press, settle
from tests.builder.view.stand_ins import WorkerStandIn

Copied = Callable[[str], TaskDocument]


def _do(window: Window, edit: Callable[[TaskDocument], object]) -> None:
    window.session.post(lambda: window.session.do(edit))  # type: ignore[arg-type]
    settle(window)


def _drag(window: Window, name: str, *moves: tuple[float, float, float]) -> None:
    window.session.post(lambda: window.session.select(name))
    settle(window)
    start = window.session.places.of(name)
    assert start is not None
    window.dragging.drag(start, "start")
    pose = start.copy()
    for move in moves:
        pose = pose + np.array([*move, 0.0, 0.0, 0.0, 0.0])
        window.dragging.drag(pose, "update")
    window.dragging.drag(pose, "end")
    settle(window)


def test_edits_reach_the_stage(copied: Copied, show: Show) -> None:
    """Opened once without the task's own code; a moved element is placed; changed Python is opened anew."""
    document, worker = copied("pick_and_lift"), WorkerStandIn(("waypoint0",))
    window = show(document, worker)
    assert worker.asked == ["open False", "reach"]
    _do(window, lambda d: d.set("block", "pose", (0.1, 0.0, 0.0225, 0.0, 0.0, 0.0, 1.0)))
    assert worker.asked[2:] == ["place", "reach"]
    assert worker.texts[-1] == document.scene_text
    _do(window, lambda d: d.set_python_text(d.python_text + "\n"))
    assert worker.asked[4:] == ["open False", "reach"]
    window.session.post(window.world.allow_code)
    settle(window)
    assert worker.asked[6:] == ["open True", "reach"]


def test_a_drag_is_one_step_on_the_grid(copied: Copied, show: Show) -> None:
    """What is dragged snaps to centimetres; one undo takes the whole drag back, to the same bytes."""
    document = copied("pick_and_lift")
    before = document.text
    window = show(document, WorkerStandIn(("waypoint0",)))
    _drag(window, "block", (0.0, 0.03, 0.0), (0.0, 0.033, 0.0), (0.0, 0.02, 0.0))
    assert "pose = [0.0, 0.08, 0.0225]" in document.scene_text
    assert window.session.places.elements["waypoint1"][1] == pytest.approx(0.08)
    _do(window, lambda d: d.undo())
    assert document.text == before


@pytest.mark.simulation
def test_a_dragged_waypoint_takes_the_arm_along(copied: Copied, show: Show) -> None:
    """The worker is asked to follow, from the configuration of the waypoint."""
    worker = WorkerStandIn(("waypoint0", "waypoint1", "waypoint2", "waypoint3"))
    window = show(copied("pick_and_lift"), worker)
    home = window.view.tip()
    _drag(window, "waypoint1", (0.0, 0.05, 0.0))
    assert "follow" in worker.asked
    assert not np.allclose(window.view.tip(), home)


def test_a_snapped_body_stands_on_the_table(copied: Copied, show: Show) -> None:
    """By its own geometry."""
    document = copied("pick_and_lift")
    window = show(document, WorkerStandIn())
    window.session.snap = "table"
    _drag(window, "block", (0.0, 0.0, 0.3))
    assert document.scene_text == document.scene_text.replace("pose = [0.0, 0.0, 0.3", "")
    assert window.session.places.elements["block"][2] == pytest.approx(0.752 + 0.0225, abs=1e-6)


def test_a_body_stands_on_what_is_below_it(copied: Copied, show: Show) -> None:
    """A block that is dragged over another one comes to lie on it."""
    window = show(copied("pick_and_lift"), WorkerStandIn())
    window.session.snap = "surface below"
    _drag(window, "block", (0.0, 0.12, 0.2))
    assert window.session.places.elements["block"][2] == pytest.approx(0.752 + 0.045 + 0.0225, abs=1e-6)


def test_verdicts_colour_the_hands(copied: Copied, show: Show) -> None:
    """Red where the worker says so."""
    worker = WorkerStandIn(("waypoint0",), "unreachable")
    server = ViserServer("127.0.0.1", 0, verbose=False)
    window = Window(server, copied("pick_and_lift"), worker)
    settle(window)
    hand = server.scene.get_handle_by_name("/ghosts/waypoint0")
    assert isinstance(hand, MeshHandle)
    assert hand.color == (220, 50, 47)
    window.close()
    server.stop()


def test_the_page_outlives_a_broken_scene(copied: Copied, show: Show) -> None:
    """Malformed TOML is a problem at its line; the last scene stays in sight, and a mended text goes on."""
    document, worker = copied("pick_and_lift"), WorkerStandIn()
    window = show(document, worker)
    good = document.scene_text
    _do(window, lambda d: d.set_scene_text(good.replace("[[region]]", "[[region]")))
    assert [p.file for p in document.problems] == ["scene"]
    assert len(worker.asked) == 1
    assert window.session.element("block") is not None
    _do(window, lambda d: d.set_scene_text(good))
    assert not document.problems


def test_the_page_outlives_a_broken_stage(copied: Copied, show: Show) -> None:
    """What the worker raises is shown, and it is asked again after the next edit."""
    document, worker = copied("pick_and_lift"), WorkerStandIn(fault="The simulation died.")
    window = show(document, worker)
    assert window.session.status.fault == "The simulation died."
    worker.fault = ""
    _do(window, lambda d: d.set("block", "fixed", True))
    assert worker.asked == ["open False", "open False"]
    assert window.session.status.fault == ""


def test_refused_edits_are_told_and_change_nothing(copied: Copied, show: Show) -> None:
    """Deleting what others need."""
    document = copied("pick_and_lift")
    window = show(document, WorkerStandIn())
    before = document.text
    _do(window, lambda d: d.delete("block"))
    assert document.text == before


def test_files_changed_on_disk_are_read_again(copied: Copied, show: Show) -> None:
    """What an editor writes appears by itself; with edits that are not saved, somebody has to choose."""
    document = copied("pick_and_lift")
    window = show(document, WorkerStandIn())
    file = document.folder / "pick_and_lift.toml"
    file.write_text(document.scene_text.replace("0.12", "0.13"))
    end = time.monotonic() + 10.0
    while "0.13" not in document.scene_text and time.monotonic() < end:
        time.sleep(0.05)
    assert "0.13" in document.scene_text
    _do(window, lambda d: d.set("block", "fixed", True))
    file.write_text(document.scene_text.replace("0.13", "0.14"))
    window.session.post(window.take_from_disk)
    settle(window)
    assert "0.14" not in document.scene_text
    assert document.changed_on_disk()


def test_moving_a_body_is_quick(copied: Copied, show: Show) -> None:
    """The image follows a drag without waiting for text or worker."""
    window = show(copied("pick_and_lift"), WorkerStandIn())
    frame = window._viser.scene.get_handle_by_name("/bodies/block/0")
    window.session.post(lambda: window.session.select("block"))
    settle(window)
    pose = window.session.places.elements["block"] + np.array([0.0, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0])
    window.dragging.drag(window.session.places.elements["block"], "start")
    window.dragging.drag(pose, "update")
    assert frame is not None
    assert frame.position[1] == pytest.approx(0.05)
    window.dragging.drag(pose, "end")
    settle(window)


def test_urdf_files_beside_the_task_can_be_added(copied: Copied, show: Show) -> None:
    """Those of the folder and of folders in it; one that is none is told, and the scene stays."""
    document = copied("pick_and_lift")
    (document.folder / "own").mkdir()
    (document.folder / "own" / "brick.urdf").write_text(primitive_urdf("brick", "box", (0.1, 0.05, 0.04), 0.2, (1.0, 0.0, 0.0)))
    (document.folder / "broken.urdf").write_text("<robot")
    window = show(document, WorkerStandIn())
    folder = control(window, "Add", "folder", "Custom URDF").children
    assert folder is not None
    assert {c.label for c in controls(folder) if c.key[0] == "button"} == {"Add broken.urdf", "Add own/brick.urdf"}
    before = document.text
    press(window, "Add", "Add broken.urdf")
    assert document.text == before
    press(window, "Add", "Add own/brick.urdf")
    assert 'asset = "./own/brick.urdf"' in document.scene_text
    assert window.session.places.of(window.session.selected)[2] == pytest.approx(0.752 + 0.02, abs=1e-6)  # type: ignore[index]
