"""`rlbench-pin view --live` serves a page on this machine until Ctrl-C."""

from __future__ import annotations

import signal
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from rlbench_pin.cli.main import main

PATIENCE = 120.0


def test_a_page_is_served_until_interrupted() -> None:
    """Its address stands on stdout; without the token it refuses, and Ctrl-C ends it with 130."""
    words = [sys.executable, "-m", "rlbench_pin.cli.main", "view", "reach_target", "--live", "--no-browser"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            address = process.stdout.readline().split()[0]
            assert address.startswith("http://127.0.0.1:")
            with urllib.request.urlopen(address, timeout=PATIENCE) as answer:
                assert b"<html" in answer.read()
            without_token = address.rstrip("/").rpartition("/")[0]
            with pytest.raises(urllib.error.HTTPError):
                urllib.request.urlopen(without_token, timeout=PATIENCE)
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE) == 130
        finally:
            process.kill()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["view", "reach_target", "--live", "--out", "x.png"], "--out names an image"),
        (["view", "reach_target", "--live", "--port", "70000"], "it must be at most 65535"),
        (["view", "reach_targt", "--live"], "Did you mean 'reach_target'?"),
        (["evaluate", "noop", "--tasks", "reach_target", "--live", "--workers", "2"], "--workers is 2"),
    ],
)
def test_what_cannot_be_shown_is_refused(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    """With the reason and the next step, before anything is served."""
    assert main(words) != 0
    assert said in capsys.readouterr().err


def test_an_empty_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A folder without demonstrations says how to make some."""
    assert main(["view", str(tmp_path), "--live", "--no-browser"]) != 0
    assert "rlbench-pin record" in capsys.readouterr().err


def test_without_viser_it_says_what_to_install() -> None:
    """The extra `builder` brings what is missing; everything else works without."""
    program = (
        "import sys; sys.modules['viser'] = None\n"
        "from rlbench_pin.cli.main import main\n"
        "sys.exit(main(['view', 'reach_target', '--live']))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == 1
    assert "'viser', which is not installed" in done.stderr
    assert "pip install -e '.[builder]'" in done.stderr
