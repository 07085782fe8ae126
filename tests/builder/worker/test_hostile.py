"""Modules that raise, loop, end the process, print or allocate without end: contained, and named at their line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from rlbench_pin.builder.contracts import OpenedTask, TaskText
from rlbench_pin.builder.worker import NothingOpen, WorkerClient, WorkerFault, WorkerLimits
from tests.builder.worker.conftest import copy_of

pytestmark = pytest.mark.simulation

_LIMITS = WorkerLimits(open=3.0, reset=10.0, tick=3.0, memory=2**29)
_IN_STEP = "        if not self.is_green and self.pressed.met():"
_IN_INIT = "        self.button = self.world.body"


@pytest.fixture(scope="module")
def client() -> Iterator[WorkerClient]:
    """A client with little patience and little memory."""
    with WorkerClient(_LIMITS) as made:
        yield made


@pytest.fixture
def text(tmp_path: Path) -> TaskText:
    """A copy of push_button."""
    return copy_of("push_button", tmp_path)


def _with(text: TaskText, code: str, before: str) -> TaskText:
    """Put a line of code before another one."""
    indent = before[: len(before) - len(before.lstrip())]
    python = text.python.replace(before, f"{indent}{code}\n{before}")
    assert python != text.python
    return replace(text, python=python)


def _line(text: TaskText, code: str) -> int:
    return next(i for i, line in enumerate(text.python.splitlines(), start=1) if code in line)


def _lives(client: WorkerClient, text: TaskText) -> None:
    """The client goes on with the next good text."""
    assert client.open(text, run_task=True).problems == ()
    assert client.reset(0).failure is None


def _problem(opened: OpenedTask) -> tuple[str, int | None]:
    (problem,) = opened.problems
    return problem.file, problem.line


def test_a_module_that_loops(client: WorkerClient, text: TaskText) -> None:
    """It is ended when its time is over, and the line at which it was is named."""
    looping = replace(text, python=text.python + "while True:\n    pass  # forever\n")
    opened = client.open(looping, run_task=True)
    assert _problem(opened) in {("task", _line(looping, "forever")), ("task", _line(looping, "while True"))}
    assert "within 3 s" in opened.problems[0].message
    with pytest.raises(NothingOpen, match="within 3 s"):
        client.reach()
    _lives(client, text)


def test_a_module_that_ends_the_process(client: WorkerClient, text: TaskText) -> None:
    """No exit code is taken for an answer."""
    opened = client.open(_with(text, "__import__('os')._exit(0)", _IN_INIT), run_task=True)
    assert _problem(opened)[0] == "task"
    assert "exit code 0" in opened.problems[0].message
    _lives(client, text)


def test_a_module_that_crashes_the_process(client: WorkerClient, text: TaskText) -> None:
    """The line is known even then."""
    crashing = _with(text, "__import__('ctypes').string_at(0)", _IN_INIT)
    opened = client.open(crashing, run_task=True)
    assert _problem(opened) == ("task", _line(crashing, "string_at"))
    assert "SIGSEGV" in opened.problems[0].message
    _lives(client, text)


def test_a_module_that_allocates_without_end(client: WorkerClient, text: TaskText) -> None:
    """It gets a MemoryError at its line, and the machine keeps its memory."""
    hungry = replace(text, python=text.python + "kept = []\nwhile True:\n    kept.append(np.empty(10_000_000))\n")
    opened = client.open(hungry, run_task=True)
    assert _problem(opened) == ("task", _line(hungry, "np.empty"))
    assert "memory" in opened.problems[0].message
    _lives(client, text)


def test_a_module_that_prints_megabytes(client: WorkerClient, text: TaskText) -> None:
    """Nobody waits for anybody; without end it is ended like any other loop."""
    assert client.open(replace(text, python=text.python + "print('x' * 5_000_000)\n"), run_task=True).problems == ()
    endless = replace(text, python=text.python + "while True:\n    print('again' * 100)\n")
    opened = client.open(endless, run_task=True)
    assert _problem(opened)[0] == "task"
    assert opened.problems[0].line in (_line(endless, "again"), _line(endless, "while True"))
    _lives(client, text)


def test_a_step_that_loops(client: WorkerClient, text: TaskText) -> None:
    """The demonstration ends with an error that names the line; the task stays open and can be reset."""
    looping = _with(text, "while True: __import__('time').sleep(0.001)", _IN_STEP)
    assert client.open(looping, run_task=True).problems == ()
    with pytest.raises(WorkerFault) as caught:
        client.demonstrate(0)
    assert caught.value.kind == "timed out"
    assert caught.value.problem is not None
    assert caught.value.problem.line == _line(looping, "while True")
    assert client.reset(0).failure is None
    _lives(client, text)


def test_a_step_that_raises_or_exits(client: WorkerClient, text: TaskText) -> None:
    """That is the reason of a demonstration that failed, with its line."""
    for code, words in (("raise ValueError('boom')", "boom"), ("raise SystemExit(1)", "ends the program")):
        raising = _with(text, code, _IN_STEP)
        assert client.open(raising, run_task=True).problems == ()
        recording = client.demonstrate(0)
        assert recording.failure is not None
        assert words in recording.failure.cause
        assert recording.failure.problem is not None
        assert recording.failure.problem.line == _line(raising, code)
        assert len(recording.frames) == 1


def test_a_scene_that_is_no_scene(client: WorkerClient, text: TaskText) -> None:
    """Empty, binary, endless, deep: a problem of the scene each time."""
    scenes = (
        "",
        "\x00\x01",
        "[" * 5000,
        "format = 2\n" + "[[body]]\n" * 2000,
        "a = " + "[" * 3000 + "]" * 3000,
        "format = 1e400",
    )
    for scene in scenes:
        opened = client.open(replace(text, scene=scene), run_task=False)
        assert [problem.file for problem in opened.problems] == ["scene"], scene[:20]
    _lives(client, text)


@pytest.mark.parametrize(
    "code",
    [
        "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (3, 3))",
        "import builtins; builtins.len = None",
        "import signal; signal.alarm(1); import time; time.sleep(0.9)",
        "import sys; sys.settrace(lambda *args: 1 / 0)",
    ],
)
def test_a_module_that_spoils_its_process(client: WorkerClient, text: TaskText, code: str) -> None:
    """What the next text says counts, not what the one before has left behind."""
    client.open(replace(text, python=f"{text.python}{code}\n"), run_task=True)
    _lives(client, text)


@pytest.mark.parametrize("error", ["ValueError('\\ud800 alone')", "GeneratorExit('no more')"])
def test_errors_of_odd_kinds(client: WorkerClient, text: TaskText, error: str) -> None:
    """They are named at their line, like any other."""
    raising = _with(text, f"raise {error}", _IN_INIT)
    opened = client.open(raising, run_task=True)
    assert _problem(opened) == ("task", _line(raising, "raise"))
    assert error.partition("(")[0] in opened.problems[0].message


def test_an_error_that_is_no_exception(client: WorkerClient, text: TaskText) -> None:
    """It is shown, and the next text opens."""
    code = "raise type('Odd', (BaseException,), {})('own')"
    opened = client.open(replace(text, python=f"{text.python}{code}\n"), run_task=True)
    assert "own" in opened.problems[0].message
    _lives(client, text)
