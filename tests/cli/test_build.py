"""`rlbench-pin build`: what it opens, what it refuses, how it ends."""

from __future__ import annotations

import signal
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from rlbench_pin.cli.main import main
from tests.builder.raw_page import RawPage

SHOWN = 60.0
IGNORING = ("/bin/sh", "-c", "trap '' INT; exec \"$@\"", "sh")
"""Words before a command that begins with SIGINT ignored."""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("push_button", "--task-file", "x.py"), "both name a task"),
        (("--task-file", "missing.py"), "There is no task file 'missing.py'"),
        (("Bad Name",), "Bad Name"),
        (("fresh", "--port", "-1"), "--port is -1"),
    ],
)
def test_what_cannot_be_built_is_said(
    words: tuple[str, ...], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before anything is served, and no file is left."""
    assert main(["build", *words, "--out", str(tmp_path), "--no-browser"]) in (1, 2)
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.simulation
def test_the_page_is_served_until_it_is_interrupted(tmp_path: Path) -> None:
    """To who has the address alone; nothing is written that was not saved, and no process stays.

    The process begins with SIGINT ignored, as under `nohup` or in the background of a script.
    """
    command = [*IGNORING, sys.executable, "-m", "rlbench_pin.cli.main", "build", "fresh", "--out", str(tmp_path), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert "'fresh' in" in process.stdout.readline()
        address = process.stdout.readline().split()[0]
        with urllib.request.urlopen(address, timeout=SHOWN) as answer:
            assert b"<html" in answer.read().lower()
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(address.rsplit("/", 2)[0] + "/wrong/", timeout=SHOWN)
        process.send_signal(signal.SIGINT)
        assert process.wait(SHOWN) == 130
        assert "Traceback" not in process.stderr.read()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.simulation
@pytest.mark.parametrize("first", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_what_was_not_saved_is_offered_again(tmp_path: Path, first: signal.Signals) -> None:
    """However the first builder is ended, with a line that says where; a server that is killed afterwards has saved it."""
    command = [sys.executable, "-m", "rlbench_pin.cli.main", "build", "fresh", "--out", str(tmp_path), "--no-browser"]
    for label, ending in (("Add frame", first), ("Apply the draft", signal.SIGKILL)):
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True) as process:
            assert process.stdout is not None
            process.stdout.readline()
            port, token = process.stdout.readline().split()[0].rstrip("/").rsplit(":", 1)[1].split("/")
            try:
                page = RawPage((int(port), token), "")
                page.press(label)
                page.updated("Undo: ")
                if ending == signal.SIGKILL:
                    page.press("Save")
                    page.told("Saved")
                process.send_signal(ending)
                process.wait(SHOWN)
            finally:
                process.kill()
            said = process.stdout.read()
        if ending == first:
            assert process.returncode == 130
            assert f"the next start offers them from the draft {tmp_path / '.fresh.draft'}" in said
            assert [file.name for file in tmp_path.iterdir()] == [".fresh.draft"]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["fresh.py", "fresh.toml"]
    assert "[[frame]]" in (tmp_path / "fresh.toml").read_text()
