"""Readers that are gone, disks that are full, names that are no text."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rlbench_pin import __version__

PROGRAM = [sys.executable, "-m", "rlbench_pin.cli.main"]
COMMANDS = [("list",), ("list", "--json"), ("--help",), ("record", "--help"), ("--version",)]


@pytest.mark.parametrize("words", COMMANDS)
def test_a_reader_that_is_gone_is_no_fault(words: tuple[str, ...]) -> None:
    """As with other programs: nothing is said, and the exit code is that of a closed pipe."""
    theirs, ours = os.pipe()
    os.close(theirs)
    done = subprocess.run([*PROGRAM, *words], stdout=ours, stderr=subprocess.PIPE, timeout=120)
    os.close(ours)
    assert (done.returncode, done.stderr) == (141, b"")


@pytest.mark.parametrize("words", COMMANDS)
def test_output_to_a_full_disk(words: tuple[str, ...]) -> None:
    """The reason in one line."""
    with open("/dev/full", "wb") as full:
        done = subprocess.run([*PROGRAM, *words], stdout=full, stderr=subprocess.PIPE, timeout=120)
    assert done.returncode == 1
    assert done.stderr == b"rlbench-pin: the output cannot be written: No space left on device. Use another file or disk.\n"


def test_errors_that_nobody_reads() -> None:
    """The exit code stays that of the misuse."""
    theirs, ours = os.pipe()
    os.close(theirs)
    done = subprocess.run([*PROGRAM, "replay"], stdout=subprocess.PIPE, stderr=ours, timeout=120)
    os.close(ours)
    assert (done.returncode, done.stdout) == (2, b"")


def test_names_that_are_no_text(tmp_path: Path) -> None:
    """They are printed as the bytes they are, under a plain locale too."""
    folder = os.fsencode(tmp_path) + b"/\xff\xfe: a"
    for locale in ("C.UTF-8", "C"):
        name = b"touch_" + locale[:1].lower().encode() + locale[-1:].lower().encode()
        env = {**os.environ, "LC_ALL": locale}
        done = subprocess.run([*PROGRAM, "new", name, "--out", folder], capture_output=True, env=env, timeout=120)
        assert done.returncode == 0, done.stderr
        assert done.stdout.splitlines()[0] == folder + b"/" + name + b".py"
    assert len(os.listdir(folder)) == 4


def test_the_installed_program_starts() -> None:
    """The module that pip puts beside the package, and `python -m`."""
    command = Path(__file__).parents[2] / "rlbench_pin" / "cli" / "rlbench_pin_command.py"
    for program in ([sys.executable, str(command)], PROGRAM):
        env = {**os.environ, "PYTHONPATH": str(command.parents[2])}
        done = subprocess.run([*program, "--version"], capture_output=True, text=True, env=env, timeout=120)
        assert (done.returncode, done.stdout, done.stderr) == (0, f"rlbench-pin {__version__}\n", "")
