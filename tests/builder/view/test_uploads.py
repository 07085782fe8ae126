"""Uploaded files become bodies of the scene; the page goes on meanwhile, and reports the result."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest
import trimesh
from viser import UploadedFile, ViserServer

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.view import Window
from rlbench_pin.scene import read_scene
from rlbench_pin.urdf import read_urdf
from tests.builder.custom_assets.files import angle, cabinet, obj
from tests.builder.custom_assets.test_conversion import wait_for_end
from tests.builder.custom_assets.test_hostile_files import TEXTS
from tests.builder.view.conftest import Show, call, control, press, settle
from tests.builder.view.stand_ins import WorkerStandIn

Copied = Callable[[str], TaskDocument]


def _upload(window: Window, label: str, name: str, data: bytes) -> None:
    found = control(window, "Add", "upload", label)
    window.session.post(lambda: found.callback(UploadedFile(name, data)))


def _finish(window: Window) -> None:
    end = time.monotonic() + 90.0
    settle(window)
    while window.adding.conversion is not None and time.monotonic() < end:
        time.sleep(0.05)
    settle(window)


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Messages in the page."""
    messages: list[str] = []
    monkeypatch.setattr(Window, "_notify", lambda self, title, text, bad: messages.append(text))
    return messages


@pytest.mark.simulation
def test_a_custom_urdf_is_in_the_scene(copied: Copied, show: Show) -> None:
    """Its files are beside the task, its joints have sliders, it is undone in one step, and what is saved can be read."""
    document = copied("pick_and_lift")
    before = document.text
    window = show(document, WorkerStandIn())
    _upload(window, "Upload a URDF or ZIP", "My Cabinet.zip", cabinet())
    _finish(window)
    assert window.session.selected == "my_cabinet"
    assert sorted(p.name for p in (document.folder / "my_cabinet").iterdir())[0] == "cabinet.urdf"
    assert [p.name for p in document.folder.iterdir() if p.name.startswith(".")] in ([], [".pick_and_lift.draft"])
    assert {"my_cabinet/case", "my_cabinet/door_1"} <= set(window.session.places.links)
    for joint, label, high in (("hinge", "Starts at [rad]", 1.5), ("rail", "Starts at [m]", 0.2)):
        assert control(window, "Selected", "folder", joint)
        slider = control(window, "Selected", "slider", label).handle
        assert (slider.min, slider.max) == (0.0, high)
    document.save()
    scene = read_scene(document.folder / "pick_and_lift.toml")
    assert any(body.asset == "./my_cabinet/cabinet.urdf" for body in scene.body)
    document.undo()
    assert document.text == before


@pytest.mark.simulation
def test_others_edit_while_a_file_is_made(copied: Copied, show: Show, told: list[str]) -> None:
    """One file at a time; edits go on, what is done is shown, and it can be stopped."""
    document = copied("pick_and_lift")
    window = show(document, WorkerStandIn())
    _upload(window, "Upload a mesh", "angle.obj", obj(angle()))
    assert window.session.edits.wait(1.0)
    assert control(window, "Add", "button", "Stop")
    window.session.post(lambda: window.session.do(lambda d: d.set("block", "fixed", True)))
    assert window.session.edits.wait(1.0)
    assert "fixed = true" in document.scene_text
    _upload(window, "Upload a mesh", "second.obj", obj(angle()))
    assert window.session.edits.wait(1.0)
    assert "'angle.obj' is still being converted" in told[-1]
    call(window, control(window, "Add", "button", "Stop"))
    _finish(window)
    assert "it was stopped" in told[-1]
    assert not (document.folder / "angle").exists()


@pytest.mark.simulation
def test_a_hostile_file_is_told_in_the_page(copied: Copied, show: Show, told: list[str]) -> None:
    """Nothing is written, the scene stays, and the next file is taken."""
    document = copied("pick_and_lift")
    window, before = show(document, WorkerStandIn()), document.text
    _upload(window, "Upload a URDF or ZIP", "bomb.urdf", b'<!DOCTYPE r [<!ENTITY a "b">]><robot/>')
    _finish(window)
    assert "entities" in told[-1]
    assert (document.text, sorted(p.name for p in document.folder.iterdir())) == (
        before,
        ["pick_and_lift.py", "pick_and_lift.toml"],
    )
    _upload(window, "Upload a mesh", "pick_and_lift.obj", obj(trimesh.creation.box((0.05, 0.05, 0.05))))
    _finish(window)
    assert 'asset = "./pick_and_lift2/pick_and_lift.urdf"' in document.scene_text
    assert read_urdf(document.folder / "pick_and_lift2" / "pick_and_lift.urdf").links


def test_closing_ends_what_is_made(copied: Copied) -> None:
    """No process outlives its page."""
    server = ViserServer("127.0.0.1", 0, verbose=False)
    window = Window(server, copied("pick_and_lift"), WorkerStandIn())
    settle(window)
    _upload(window, "Upload a mesh", "angle.obj", obj(angle()))
    assert window.session.edits.wait(10.0)
    made = window.adding.conversion
    assert made is not None
    window.close()
    server.stop()
    wait_for_end(made._child.pid)


_BESIDE = ("billion laughs", "external entity", "deep", "other encoding", "two roots", "circle", "infinite", "no size", "missing")


@pytest.mark.parametrize("kind", _BESIDE)
def test_hostile_files_beside_the_task_are_told(copied: Copied, show: Show, told: list[str], kind: str) -> None:
    """A URDF file that is there already is looked at, too, before it is added."""
    document = copied("pick_and_lift")
    (document.folder / "x.urdf").write_text(TEXTS[kind][0])
    window, before = show(document, WorkerStandIn()), document.text
    press(window, "Add", "Add x.urdf")
    assert document.text == before
    assert "x.urdf" in told[-1]
    assert "Internal error" not in told[-1]
