"""A killed builder loses nothing of what was edited; the page offers it at the next opening."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.tasks.registry import LIBRARY
from tests.builder.view.conftest import Show, press, settle, text
from tests.builder.view.stand_ins import WorkerStandIn

Copied = Callable[[str], TaskDocument]
_BUILDER = """
import sys, time
from viser import ViserServer
from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.builder.view import Window
from tests.builder.view.stand_ins import WorkerStandIn
document = TaskDocument.open(sys.argv[1])
window = Window(ViserServer("127.0.0.1", 0, verbose=False), document, WorkerStandIn())
for k in range(10**6):
    window.session.post(lambda: window.session.do(lambda d: d.set("block", "pose", (k / 1e4, 0.0, 0.0225, 0.0, 0.0, 0.0, 1.0))))
    time.sleep(0.05)
"""


@pytest.mark.simulation
def test_a_killed_builder_leaves_its_edits(tmp_path: Path, show: Show) -> None:
    """SIGKILL in the middle of edits; the files are as saved, the draft has the edits but for the last second."""
    for ending in (".toml", ".py"):
        shutil.copy(LIBRARY / f"pick_and_lift{ending}", tmp_path)
    scene, draft = tmp_path / "pick_and_lift.toml", tmp_path / ".pick_and_lift.draft"
    saved = scene.read_bytes()
    process = subprocess.Popen([sys.executable, "-c", _BUILDER, str(scene)])
    try:
        end = time.monotonic() + 60.0
        while not draft.exists() and time.monotonic() < end:
            time.sleep(0.05)
        time.sleep(2.3)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert scene.read_bytes() == saved
    document = TaskDocument.open(scene)
    window = show(document, WorkerStandIn())
    assert "was not saved. It differs from the task in 1 lines of `pick_and_lift.toml`." in text(window, "Header")
    assert "changed since" not in text(window, "Header")
    press(window, "Header", "Apply the draft")
    assert "draft" not in text(window, "Header")
    block = window.session.element("block")
    assert block is not None
    assert block.pose[0] >= 0.001
    window.session.post(lambda: window.session.do(lambda d: d.undo()))
    settle(window)
    assert document.scene_text.encode() == saved
    assert not draft.exists()


def test_a_draft_of_an_older_state_says_so(copied: Copied, show: Show) -> None:
    """And is dropped by its button."""
    document = copied("pick_and_lift")
    window = show(document, WorkerStandIn())
    window.session.post(lambda: window.session.do(lambda d: d.set("block", "fixed", True)))
    settle(window)
    window.drafts.close()
    file = document.folder / "pick_and_lift.py"
    file.write_text(file.read_text() + "# newer\n")
    again = show(TaskDocument.open(file), WorkerStandIn())
    assert "The files have been changed since then" in text(again, "Header")
    press(again, "Header", "Discard the draft")
    assert "draft" not in text(again, "Header")
    assert sorted(p.name for p in document.folder.iterdir()) == ["pick_and_lift.py", "pick_and_lift.toml"]


def test_a_broken_draft_is_told_in_the_page(copied: Copied, show: Show) -> None:
    """The task opens; saving goes on."""
    document = copied("pick_and_lift")
    (document.folder / ".pick_and_lift.draft").write_bytes(bytes(range(256)))
    window = show(document, WorkerStandIn())
    assert ".pick_and_lift.draft.broken" in text(window, "Header")
    window.session.post(lambda: window.session.do(lambda d: d.set("block", "fixed", True)))
    window.session.post(lambda: window.session.do(lambda d: d.save()))
    settle(window)
    assert not document.unsaved
    assert not (document.folder / ".pick_and_lift.draft").exists()
