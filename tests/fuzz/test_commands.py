"""Whatever is typed: exit code 0, 1 or 2, a text, and never a traceback."""

from __future__ import annotations

import dataclasses
import io
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.cli.main import main
from rlbench_pin.cli.running import COMMANDS
from tests.demos_for_tests import fill
from tests.fuzz.cases import Case, Tally

TASK = "reach_target"
WORDS = (
    "", "x", "-", "--", "-1", "0", "1.5", "nan", "1e999", "99999999999999999999", "None", "True", TASK, "reach_targt", "../x",
    "/dev/null", "/proc/nowhere", "a\nb", "ünï☃", "\udcff", "--help", "--out", "--json", "--workers", "[]", "{}", "x" * 5000, "=",
)  # fmt: skip
BASES = (
    ("list",), ("new", "touch_it", "--out", "NEW"), ("demo", TASK, "--episodes", "1", "--no-video", "--out", "NEW"),
    ("record", TASK, "--episodes", "1", "--workers", "0", "--products", "--out", "NEW"), ("record", "--resume", "--out", "DATA"),
    ("dataset", "info", "DATA"), ("dataset", "verify", "DATA"), ("dataset", "merge", "DATA", "--out", "NEW"),
    ("dataset", "export", "robomimic", "DATA", "NEW"), ("dataset", "rerender", "DATA", "--out", "NEW"),
    ("dataset", "seeds", "DATA"),
    ("replay", "DATA"), ("view", TASK, "--size", "32", "--out", "FILE/x.png"),
    ("video", TASK, "--size", "64", "48", "--out", "FILE"),
    ("check", TASK, "--episodes", "0", "--contract-seeds", "0", "--placements", "1", "--out", "FILE"),
    ("problems", "export", TASK, "--out", "FILE"),
    ("evaluate", "--tasks", "nothing"), ("doctor", "x"), ("serve", "missing.py:make"),
    ("results", "verify", "DATA"), ("results", "verify", "missing.json", "--sample", "1%"),
    ("conventions", "missing.py:make"), ("challenge", "splits"),
    ("challenge", "run", "missing.py:make"), ("nothing",), (),
)  # fmt: skip
"""Command lines that are short, or refused early; NEW is a new folder, DATA a dataset, FILE a file where a folder should be."""
EXPENSIVE = frozenset({"check", "evaluate", "video", "view", "demo", "record", "doctor", "problems"})
"""Their lines are changed in a way that leaves them refused or short."""


def flags_of(command: str) -> list[str]:
    """Return the flags of a command."""
    kind = COMMANDS.get(command)
    names = [f.name for f in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else []
    return [f"--{name.replace('_', '-')}" for name in names]


def typed(folder: Path, rng: np.random.Generator) -> list[str]:
    """Draw a command line: a base with one to three words changed, added or left out."""
    words = list(BASES[int(rng.integers(len(BASES)))])
    command = words[0] if words else ""
    for _ in range(int(rng.integers(1, 4))):
        kind, at = int(rng.integers(5)), int(rng.integers(len(words) + 1))
        word = WORDS[int(rng.integers(len(WORDS)))]
        flags = flags_of(command)
        if kind == 0 and at < len(words):
            words[at] = word
        elif kind == 1 and at < len(words):
            del words[at]
        elif kind == 2 and flags:
            words += [flags[int(rng.integers(len(flags)))], word]
        elif kind == 3:
            words.insert(at, word)
        else:
            words = [("FILE" if w == "NEW" else "MISSING" if w == "DATA" else w) for w in words]
    if command in EXPENSIVE and rng.random() < 0.8:
        words += ["--no-such-flag"] if rng.random() < 0.1 else ["--out", "FILE/below"]
    places = {
        "NEW": folder / f"new{rng.integers(10**9)}",
        "DATA": folder / "data",
        "FILE": folder / "file",
        "MISSING": folder / "gone",
    }
    return [str(places.get(word, word)).replace("FILE/", f"{folder / 'file'}/") for word in words]


class Run:
    """Runs a command in this process and checks its output."""

    def __init__(self, words: list[str]) -> None:
        self.words = words

    def __call__(self) -> tuple[int, str, str]:
        """Return exit code, stdout and stderr."""
        out, err = io.TextIOWrapper(io.BytesIO(), "utf-8"), io.TextIOWrapper(io.BytesIO(), "utf-8", errors="backslashreplace")
        with redirect_stdout(out), redirect_stderr(err):
            try:
                code = main(self.words)
            except SystemExit as stop:
                code = int(stop.code or 0)
        texts = []
        for stream in (out, err):
            stream.flush()
            texts.append(stream.buffer.getvalue().decode("utf-8", "replace"))  # type: ignore[attr-defined]
        return code, texts[0], texts[1]


def checked(result: object) -> str:
    """Say what is wrong with the outcome of a command."""
    code, out, err = result  # type: ignore[misc]
    if code not in (0, 1, 2):
        return f"exit code {code}"
    if "Traceback" in err or "Traceback" in out:
        return f"a traceback: {err[-200:]!r}"
    return "" if out.strip() or err.strip() else f"exit code {code} and not a word"


def try_commands(tally: Tally, folder: Path, seed: int, count: int) -> None:
    """Type many lines, and fail with all that is wrong."""
    fill(folder / "data", range(2))
    (folder / "file").write_text("no folder")
    for number in range(count):
        words = typed(folder, np.random.default_rng((seed, number)))
        name = f"rlbench-pin {words[0][:20] if words else ''}"
        tally.run(Case(ascii(name), ascii(words)[:300], Run(words), check_result=checked))
    assert not tally.faults, f"seed {seed}:\n{tally.report()}"


@pytest.mark.simulation
def test_command_lines(tally: Tally, seed: int, elsewhere: Path) -> None:
    """Some lines of each command, in this process."""
    try_commands(tally, elsewhere, seed, 120)
    assert tally.cases >= 120


@pytest.mark.slow
def test_many_command_lines(tally: Tally, seed: int, elsewhere: Path) -> None:
    """Many lines of each command, in this process."""
    try_commands(tally, elsewhere, seed, 1_500)
    assert tally.cases >= 1_500


@pytest.mark.slow
def test_command_lines_of_processes(tally: Tally, seed: int, elsewhere: Path) -> None:
    """A few as users start them."""
    fill(elsewhere / "data", range(2))
    (elsewhere / "file").write_text("no folder")
    for number in range(20):
        words = [w for w in typed(elsewhere, np.random.default_rng((seed, number, 7))) if "\0" not in w]
        command = [sys.executable, "-m", "rlbench_pin.cli.main", *words]
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=120, check=False)
        problem = checked((done.returncode, done.stdout, done.stderr))
        assert not problem, (words, problem)
