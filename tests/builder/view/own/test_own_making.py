"""Files are made into assets in a process apart, which ends in time; the page goes on meanwhile, and tells what came of it."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from viser import ViserServer

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.view import Window
from rlbench_pin.builder.view.own.making import Making
from rlbench_pin.builder.view.own.solids import OwnAsset
from rlbench_pin.builder.view.own.workshop import Order
from rlbench_pin.builder.view.panels.bodies import body_items
from rlbench_pin.builder.view.widgets import Button, Fold, Item, Slider, Upload
from rlbench_pin.builder.worker import WorkerClient
from rlbench_pin.cli.main import main
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import read_scene
from rlbench_pin.urdf import read_urdf
from tests.builder.view.conftest import Show, settle
from tests.builder.view.own.files import angle, cabinet, make, obj, put
from tests.builder.view.own.test_own_hostile import TEXTS
from tests.builder.view.stand_ins import StageStandIn

Copied = Callable[[str], TaskDocument]
Found = OwnAsset | RlbenchPinError


def _make(name: str, data: bytes, act: Callable[[Making], object] = id, longest: float = 60.0) -> tuple[Found, list[str]]:
    """Return what comes of an order in a process, and what was told on the way."""
    found, notes, ended = list[Found](), list[str](), threading.Event()

    def end(result: Found) -> None:
        found.append(result)
        ended.set()

    order = Order(name, "/nowhere", 1.0, 1.0, (1.0, 0.0, 0.0))
    act(Making(order, data, notes.append, end, longest))
    assert ended.wait(90.0)
    return found[0], notes


def test_a_mesh_is_made_in_a_process() -> None:
    """With notes on the way."""
    asset, notes = _make("angle.obj", obj(angle()))
    assert isinstance(asset, OwnAsset)
    assert {"angle.urdf", "angle.obj", "angle_part0.obj"} <= set(asset.files)
    assert "apart" in notes[-1]


def test_what_takes_too_long_is_ended() -> None:
    """By the clock, or by somebody; the message names the file and the next step."""
    slow, _ = _make("slow.obj", obj(angle()), longest=0.05)
    assert "'slow.obj' is not taken: it takes longer than 0.05 s. Reduce it" in str(slow)
    stopped, _ = _make("stopped.obj", obj(angle()), act=Making.stop)
    assert "it was stopped" in str(stopped)


def test_what_kills_the_process_is_told() -> None:
    """As a parser may do on hostile bytes."""
    killed, _ = _make("deadly.obj", obj(angle()), act=lambda made: os.kill(made._process.pid, 11))
    assert isinstance(killed, RlbenchPinError)
    assert "SIGSEGV" in str(killed)


def test_what_is_refused_is_told() -> None:
    """The reason comes from the process."""
    refused, _ = _make("a.stl", b"solid nothing")
    assert "'a.stl' is not taken" in str(refused)


_OWNER = """
import sys, time
import numpy as np, trimesh
from rlbench_pin.builder.view.own.making import Making
from rlbench_pin.builder.view.own.meshes import obj_text
from rlbench_pin.builder.view.own.workshop import Order
rng = np.random.default_rng(0)
soup = trimesh.Trimesh(rng.random((3000, 3)) * 0.2, rng.integers(0, 3000, (2000, 3)), process=False)
order = Order("soup.obj", "/nowhere", 1.0, 1.0, (1.0, 0.0, 0.0))
made = Making(order, obj_text(soup).encode(), lambda note: print(made._process.pid, note, flush=True), print)
time.sleep(600)
"""


def test_no_process_outlives_a_killed_builder() -> None:
    """A mesh that keeps the library busy for minutes ends with whoever asked."""
    owner = subprocess.Popen([sys.executable, "-c", _OWNER], stdout=subprocess.PIPE, text=True)
    assert owner.stdout is not None
    pid = next(line.split()[0] for line in owner.stdout if "apart" in line)
    owner.kill()
    owner.communicate()
    end = time.monotonic() + 20.0
    while Path(f"/proc/{pid}").exists() and time.monotonic() < end:
        time.sleep(0.1)
    assert not Path(f"/proc/{pid}").exists()


# In the page ----------------------------------------------------------------------------------------------------------


def _item(window: Window, label: str) -> Item:
    """Return the item of the panel that is called so."""
    folds = [item for item in window._adding.items() if isinstance(item, Fold)]
    return next(item for fold in folds for item in fold.items if getattr(item, "label", "") == label)


def _upload(window: Window, label: str, name: str, data: bytes) -> None:
    item = _item(window, label)
    assert isinstance(item, Upload)
    window.session.post(lambda: item.on_file(name, data))


def _finish(window: Window) -> None:
    end = time.monotonic() + 90.0
    settle(window)
    while window._adding._own._making is not None and time.monotonic() < end:
        time.sleep(0.05)
    settle(window)


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Messages in the page."""
    messages: list[str] = []
    monkeypatch.setattr(Window, "_notify", lambda self, title, text, bad: messages.append(text))
    return messages


def test_an_own_urdf_stands_in_the_scene(copied: Copied, show: Show) -> None:
    """Its files are beside the task, its joints have sliders, it is undone in one step, and what is saved can be read."""
    document = copied("pick_and_lift")
    before = document.text
    window = show(document, StageStandIn())
    _upload(window, "Upload a URDF or ZIP", "My Cabinet.zip", cabinet())
    _finish(window)
    assert window.session.selected == "my_cabinet"
    assert sorted(p.name for p in (document.folder / "my_cabinet").iterdir())[0] == "cabinet.urdf"
    assert [p.name for p in document.folder.iterdir() if p.name.startswith(".")] in ([], [".pick_and_lift.draft"])
    assert {"my_cabinet/case", "my_cabinet/door_1"} <= set(window.session.places.links)
    body = next(body for body in window.session.spec.body if body.name == "my_cabinet")
    folds = {item.label: item for item in body_items(window.session, body) if isinstance(item, Fold)}
    sliders = [item for fold in folds.values() for item in fold.items if isinstance(item, Slider)]
    assert set(folds) == {"hinge", "rail"}
    assert [(slider.least, slider.most) for slider in sliders] == [(0.0, 1.5), (0.0, 0.2)]
    document.save()
    scene = read_scene(document.folder / "pick_and_lift.toml")
    assert any(body.asset == "./my_cabinet/cabinet.urdf" for body in scene.body)
    document.undo()
    assert document.text == before


def test_others_edit_while_a_file_is_made(copied: Copied, show: Show, told: list[str]) -> None:
    """One file at a time; edits go on, what is done is shown, and it can be stopped."""
    document = copied("pick_and_lift")
    window = show(document, StageStandIn())
    _upload(window, "Upload a mesh", "angle.obj", obj(angle()))
    assert window.session.edits.wait(1.0)
    assert isinstance(_item(window, "Stop"), Button)
    window.session.post(lambda: window.session.do(lambda d: d.set("block", "fixed", True)))
    assert window.session.edits.wait(1.0)
    assert "fixed = true" in document.scene_text
    _upload(window, "Upload a mesh", "second.obj", obj(angle()))
    assert window.session.edits.wait(1.0)
    assert "'angle.obj' is still being made" in told[-1]
    stop = _item(window, "Stop")
    assert isinstance(stop, Button)
    window.session.post(stop.on_press)
    _finish(window)
    assert "it was stopped" in told[-1]
    assert not (document.folder / "angle").exists()


def test_a_hostile_file_is_told_in_the_page(copied: Copied, show: Show, told: list[str]) -> None:
    """Nothing is written, the scene stays, and the next file is taken."""
    document = copied("pick_and_lift")
    window, before = show(document, StageStandIn()), document.text
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
    window = Window(server, copied("pick_and_lift"), StageStandIn())
    _upload(window, "Upload a mesh", "angle.obj", obj(angle()))
    assert window.session.edits.wait(10.0)
    made = window._adding._own._making
    assert made is not None
    window.close()
    server.stop()
    assert made._process.wait(10.0) != 0


_BESIDE = ("billion laughs", "external entity", "deep", "other encoding", "two roots", "circle", "infinite", "no size", "missing")


@pytest.mark.parametrize("kind", _BESIDE)
def test_hostile_files_beside_the_task_are_told(copied: Copied, show: Show, told: list[str], kind: str) -> None:
    """A URDF file that is there already is looked at, too, before it is added."""
    document = copied("pick_and_lift")
    (document.folder / "x.urdf").write_text(TEXTS[kind][0])
    window, before = show(document, StageStandIn()), document.text
    button = _item(window, "Add x.urdf")
    assert isinstance(button, Button)
    window.session.post(button.on_press)
    settle(window)
    assert document.text == before
    assert "x.urdf" in told[-1]
    assert "mistake" not in told[-1]


# In the simulation ----------------------------------------------------------------------------------------------------


@pytest.mark.simulation
def test_an_own_urdf_is_simulated_and_judged(tmp_path: Path) -> None:
    """Its door falls shut or open with the joint, and a fresh process reads the pair."""
    main(["new", "shelf", "--out", str(tmp_path)])
    put(make("cabinet.zip", cabinet(), tmp_path), tmp_path / "cabinet")
    document = TaskDocument.open(tmp_path / "shelf.toml")
    keys = {"asset": "./cabinet/cabinet.urdf", "name": "cabinet", "pose": (-0.1, 0.25, 0.02, 0.0, 0.0, 0.0, 1.0), "fixed": True}
    document.add("body", keys)
    document.set("cabinet/hinge", "position", 1.0)
    document.save()
    with WorkerClient() as stage:
        opened = stage.open(document.text, run_task=True)
        assert opened.problems == ()
        stage.reset(1)
        frame = stage.simulate(0.3).frames[-1]
    assert {"cabinet/case", "cabinet/door_1", "cabinet/drawer"} <= set(frame.poses)
    turn = 2.0 * np.arctan2(frame.poses["cabinet/door_1"][5], frame.poses["cabinet/door_1"][6])
    turn -= 2.0 * np.arctan2(frame.poses["cabinet/case"][5], frame.poses["cabinet/case"][6])
    assert (turn + np.pi) % (2 * np.pi) - np.pi == pytest.approx(1.0, abs=0.1)
    words = [
        "check",
        "--task-file",
        str(document.folder / "shelf.py"),
        "--episodes",
        "1",
        "--contract-seeds",
        "1",
        "--placements",
        "2",
    ]
    program = f"import sys; from rlbench_pin.cli.main import main; sys.exit(main({words!r}))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300)
    assert "shelf" in done.stdout
    assert "Traceback" not in done.stderr
