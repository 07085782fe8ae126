"""What C code prints is caught, and the output of the process is left alone, whatever threads do meanwhile."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from rlbench_pin.sim.server.output import captured_output

C = ctypes.CDLL(None)
LINES = 200
THREADS = f"""
import os, sys, threading
from rlbench_pin.environment.presets import low_dim_config, make_environment

def build(number):
    for _ in range(2):
        with make_environment(low_dim_config()) as environment:
            environment.get_task("reach_target").reset(seed=number)

before = [(os.fstat(fd).st_ino, os.fstat(fd).st_dev) for fd in (1, 2)]
threads = [threading.Thread(target=build, args=(i,)) for i in range(4)]
for thread in threads: thread.start()
for i in range({LINES}):
    os.write(1, b"line %d\\n" % i); print("text", i, flush=True); print("error", i, file=sys.stderr, flush=True)
    threads[0].join(0.01)
for thread in threads: thread.join()
assert before == [(os.fstat(fd).st_ino, os.fstat(fd).st_dev) for fd in (1, 2)]
print("end"); print("end", file=sys.stderr)
"""


def identity(descriptor: int) -> tuple[int, int]:
    """Return what says which file a descriptor stands for."""
    status = os.fstat(descriptor)
    return status.st_dev, status.st_ino


def test_what_c_prints_is_caught_and_what_python_prints_is_not(capfd: pytest.CaptureFixture[str]) -> None:
    """Nested, too; the descriptors are never anything else."""
    before = identity(1), identity(2)
    with captured_output() as outer:
        C.puts(b"one")
        print("python", flush=True)  # noqa: T201
        with captured_output() as inner:
            C.puts(b"two")
            assert (identity(1), identity(2)) == before
    with captured_output() as later:
        pass
    assert (outer.text, inner.text, later.text) == ("one\ntwo\n", "two\n", "")
    assert capfd.readouterr() == ("python\n", "")


def test_an_error_puts_everything_back() -> None:
    """And gives the text up to there."""
    with pytest.raises(ValueError), captured_output() as captured:
        C.puts(b"before")
        raise ValueError
    assert captured.text == "before\n"
    with captured_output() as again:
        C.puts(b"after")
    assert again.text == "after\n"


def test_threads_catch_one_after_the_other() -> None:
    """Each gets its own lines and no others."""
    texts: dict[int, str] = {}

    def catch(number: int) -> None:
        for _ in range(100):
            with captured_output() as captured:
                C.puts(b"thread %d" % number)
                C.puts(b"thread %d" % number)
            texts[number] = texts.get(number, "") + captured.text

    threads = [threading.Thread(target=catch, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert texts == {number: f"thread {number}\n" * 200 for number in range(4)}


@pytest.mark.simulation
def test_environments_built_in_threads_leave_the_output_alone(tmp_path: Path) -> None:
    """Every line that the process writes while four threads build environments arrives, on both descriptors."""
    out, err = tmp_path / "out.txt", tmp_path / "err.txt"
    with open(out, "wb") as stdout, open(err, "wb") as stderr:
        done = subprocess.run([sys.executable, "-c", THREADS], stdout=stdout, stderr=stderr, timeout=300, check=False)
    assert done.returncode == 0, err.read_text()
    lines = out.read_text().splitlines()
    assert lines == [text for i in range(LINES) for text in (f"line {i}", f"text {i}")] + ["end"]
    assert err.read_text().splitlines() == [f"error {i}" for i in range(LINES)] + ["end"]
