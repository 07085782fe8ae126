"""Ctrl-C at any moment: exit code 130, no traceback of this process or of its workers, no half of a file, nobody left behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rlbench_pin.cli import rlbench_pin_command
from rlbench_pin.cli.interrupts import is_whole_process, loading
from rlbench_pin.cli.main import main
from rlbench_pin.datasets import stored_tasks, task_faults
from tests.cli.support import TASK

HOME = Path(rlbench_pin_command.__file__).parent
START = (
    f"import sys; sys.path.insert(0, {str(HOME)!r}); import rlbench_pin_command as c; print('up', flush=True); sys.exit(c.main())"
)
"""What the installed program does, and a word when Python is up: before that, Ctrl-C is not ours."""
QUICK = [0.01, 0.04, 0.08, 0.12, 0.17, 0.23, 0.3, 0.4, 0.6, 1.2]
"""Moments after the start of the program [s]: ten, most of them while it imports."""
LONG = [0.02, 0.3, 0.8, 1.3, 1.8, 2.4, 3.0, 4.0, 5.5, 7.0]
COMMANDS = [
    ("list",),
    ("doctor",),
    ("new", "touch_it", "--out", "OUT"),
    ("view", TASK, "--out", "OUT/view.png", "--size", "64"),
    ("demo", TASK, "--episodes", "3", "--out", "OUT"),
    ("video", TASK, "--size", "160", "120", "--out", "OUT"),
    ("record", TASK, "--workers", "0", "--episodes", "40", "--products", "--out", "OUT"),
    ("record", TASK, "--workers", "2", "--episodes", "40", "--products", "--out", "OUT"),
    ("check", TASK, "--episodes", "10", "--out", "OUT", "--json", "OUT/all.json"),
    ("check", TASK, "--episodes", "10", "--workers", "2", "--out", "OUT"),
    ("evaluate", "expert", "--tasks", TASK, "--out", "OUT/all.json"),
    ("problems", "export", TASK, "--out", "OUT"),
    ("replay", "DATA"),
    ("dataset", "verify", "DATA"),
    ("dataset", "merge", "DATA", "--out", "OUT"),
    ("dataset", "rerender", "DATA", "--workers", "1", "--out", "OUT"),
    ("dataset", "export", "robomimic", "DATA", "OUT"),
]


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small recording."""
    root = tmp_path_factory.mktemp("data") / "data"
    assert main(["record", TASK, "--workers", "0", "--episodes", "4", "--image-size", "32", "32", "--out", str(root)]) == 0
    return root


def interrupted(words: tuple[str, ...], moment: float, data: Path, out: Path) -> tuple[int, str]:
    """Start a command, press Ctrl-C after a while [s], and return the exit code and what it said on stderr."""
    arguments = [str(data) if word == "DATA" else word.replace("OUT", str(out)) for word in words]
    process = subprocess.Popen(
        [sys.executable, "-c", START, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a test run in the background of a shell ignores it
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "up\n"
    time.sleep(moment)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers, too
    _, err = process.communicate(timeout=120)
    assert_nobody_is_left(process.pid)
    return process.returncode, err


def assert_all_is_well(code: int, err: str, out: Path) -> None:
    """Quiet, and everything that is there is whole."""
    assert code in (0, 130), err
    for word in ("Traceback", "Exception", "Error", "semaphore"):
        assert word not in err
    files = [path for path in out.parent.rglob("*") if path.is_file() and out in (path, *path.parents)]
    assert [path for path in files if path.name.endswith((".part", ".part.mp4")) or path.match(".recording*.mp4")] == []
    for file in files:
        if file.suffix == ".json":
            json.loads(file.read_text())
        elif file.suffix == ".jsonl":
            assert file.read_text()[-1:] in ("", "\n")
    if any(file.suffix == ".h5" and "episodes" in file.parts for file in files):
        assert [fault for task in stored_tasks(out) for fault in task_faults(out, task)] == []


def assert_nobody_is_left(group: int) -> None:
    """Every process of the command has ended, or does so shortly."""
    deadline = time.monotonic() + 10.0
    while time.monotonic() < deadline:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)
    raise AssertionError("workers are left")


@pytest.mark.parametrize("moment", QUICK)
def test_ten_moments_of_a_start(moment: float, data: Path, tmp_path: Path) -> None:
    """From the first hundredth of a second on, while everything is imported."""
    code, err = interrupted(("view", TASK, "--out", "OUT/view.png"), moment, data, tmp_path / "out")
    assert (code, err) == (130, "rlbench-pin: interrupted\n")


@pytest.mark.parametrize("moment", [1.0, 1.8, 2.6, 4.0])
@pytest.mark.parametrize("words", [COMMANDS[7], COMMANDS[9]], ids=["record", "check"])
def test_workers_in_their_first_seconds(words: tuple[str, ...], moment: float, data: Path, tmp_path: Path) -> None:
    """They leave Ctrl-C to the process that started them, from their first moment on."""
    code, err = interrupted(words, moment, data, tmp_path / "out")
    assert_all_is_well(code, err, tmp_path / "out")


@pytest.mark.slow
@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_ten_moments_of_every_command(words: tuple[str, ...], data: Path, tmp_path: Path) -> None:
    """Begun, at work, nearly done."""
    for number, moment in enumerate(LONG):
        code, err = interrupted(words, moment, data, tmp_path / str(number) / "out")
        assert_all_is_well(code, err, tmp_path / str(number) / "out")


def test_an_interrupt_that_is_lost_comes_again() -> None:
    """In `__del__` no exception leaves; the program ends all the same, and says nothing of it."""
    code = (
        "import gc, signal, sys, time\n"
        "from rlbench_pin.cli.interrupts import loading\n"
        "class Thing:\n"
        "    def __del__(self):\n"
        "        signal.raise_signal(signal.SIGINT)\n"
        "        time.sleep(0)\n"
        "with loading() as begin:\n"
        "    begin()\n"
        "    try:\n"
        "        thing = Thing()\n"
        "        del thing\n"
        "        time.sleep(5)\n"
        "    except KeyboardInterrupt:\n"
        "        sys.exit(130)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (130, "")


def test_an_interrupt_waits_until_an_import_has_ended(tmp_path: Path) -> None:
    """A compiled library that is being loaded cannot stop, and would end the process with a report of its own."""
    (tmp_path / "slow_module.py").write_text(
        "import signal, time\nsignal.raise_signal(signal.SIGINT)\ntime.sleep(0.3)\nprint('loaded', flush=True)\n"
    )
    code = (
        f"import sys, time; sys.path.insert(0, {str(tmp_path)!r})\n"
        "from rlbench_pin.cli.interrupts import loading\n"
        "with loading() as begin:\n"
        "    begin()\n"
        "    try:\n"
        "        import slow_module\n"
        "        time.sleep(5)\n"
        "    except KeyboardInterrupt:\n"
        "        sys.exit(130)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (130, "loaded\n", "")


def test_a_program_that_calls_a_command_keeps_its_handling() -> None:
    """Handlers are those of before; a process that ignores Ctrl-C goes on ignoring it."""
    before = signal.getsignal(signal.SIGINT)
    assert main(["--version"]) == 0
    assert signal.getsignal(signal.SIGINT) is before
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        assert not is_whole_process()
    finally:
        signal.signal(signal.SIGINT, before)


def test_when_all_is_said_an_interrupt_changes_nothing() -> None:
    """The exit code is that of the work, however quickly somebody presses Ctrl-C at its end."""
    before, hook = signal.getsignal(signal.SIGINT), sys.unraisablehook
    try:
        with loading() as begin:
            begin()
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)
        sys.unraisablehook = hook
