"""The table of commands, help that is quick and says what is taken, the version, and exit codes."""

from __future__ import annotations

import subprocess
import sys
from typing import get_args

import pytest

from rlbench_pin import __version__
from rlbench_pin.cli import options
from rlbench_pin.cli.main import main
from rlbench_pin.cli.running import COMMANDS, run, summary
from rlbench_pin.datasets import Compression
from rlbench_pin.datasets.formats import ExportFormat
from rlbench_pin.environment.observations.config import RenderMode

Capture = pytest.CaptureFixture[str]
HEAVY = ("pybullet", "ompl", "toppra", "osqp", "placo", "coal", "pinocchio", "h5py", "av", "scipy", "PIL", "tqdm")
"""Libraries that take long to import."""
SUBCOMMANDS = ("info", "verify", "merge", "rerender", "seeds", "export")
"""Those of `dataset`."""
FOR_TASKS = ("coal", "pinocchio")
"""Those that poses are made of, which tasks import."""


def loaded_after(*words: str) -> list[str]:
    """Return the heavy libraries that a process has imported after a command."""
    code = (
        f"import sys; from rlbench_pin.cli.main import main; main({words!r})\nprint([m for m in {HEAVY!r} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    found: list[str] = eval(done.stdout.splitlines()[-1])
    return found


@pytest.mark.parametrize("words", [("--help",), ("--version",), ("fly",), ()])
def test_help_imports_no_command(words: tuple[str, ...]) -> None:
    """The list of commands, the version and a wrong name need none of the libraries that commands work with."""
    assert loaded_after(*words) == []


def test_help_of_a_command_imports_nothing_that_works() -> None:
    """What a command takes is said without its work: every help in one process, and none of the heavy libraries."""
    commands = [*COMMANDS, *(f"dataset {name}" for name in SUBCOMMANDS)]
    code = (
        "import sys, contextlib, io; from rlbench_pin.cli.main import main\n"
        f"with contextlib.redirect_stdout(io.StringIO()): codes = {{main([*name.split(), '--help']) for name in {commands!r}}}\n"
        f"print(codes, [m for m in {HEAVY!r} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    assert done.stdout == "{0} []\n"


def test_choices_are_those_that_work() -> None:
    """Help names them without importing what they choose between."""
    for said, works in (
        (options.Compression, Compression),
        (options.RenderMode, RenderMode),
        (options.ExportFormat, ExportFormat),
    ):
        assert get_args(said) == get_args(works)


def test_list_imports_tasks_only() -> None:
    """No simulator, no planner, nothing that reads files of data."""
    assert set(loaded_after("list")) <= set(FOR_TASKS)


def test_help_lists_every_command(capsys: Capture) -> None:
    """By name, with its summary, and the way to the version."""
    assert main(["--help"]) == 0
    out = " ".join(capsys.readouterr().out.replace("│", " ").split())
    for name, command in COMMANDS.items():
        assert f"• {name} {summary(command)}" in out
    assert "rlbench-pin --version" in out


@pytest.mark.parametrize(
    "words",
    [*((name,) for name in COMMANDS), *(("dataset", n) for n in SUBCOMMANDS)],
)
def test_help_says_what_is_taken(words: tuple[str, ...], capsys: Capture) -> None:
    """Tasks, files, folders or the choices: never just that it is text."""
    assert main([*words, "--help"]) == 0
    out = capsys.readouterr().out
    assert f"usage: rlbench-pin {' '.join(words)}" in out
    assert "STR" not in out
    assert "[[" not in out
    assert "{None" not in out and "(default: )" not in out


@pytest.mark.parametrize(
    ("words", "choices"),
    [
        (("demo",), "{left_shoulder,right_shoulder,overhead,wrist,front}..."),
        (("record",), "{rgb,depth,mask,point_cloud}..."),
        (("problems",), "{export} TASK..."),
        (("replay",), "FILE..."),
        (("dataset", "merge"), "FOLDER... --out PATH"),
    ],
)
def test_help_names_choices(words: tuple[str, ...], choices: str, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where there are few, all of them."""
    monkeypatch.setenv("COLUMNS", "200")
    assert main([*words, "--help"]) == 0
    assert choices in capsys.readouterr().out


def test_the_version(capsys: Capture) -> None:
    """One line on stdout."""
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"rlbench-pin {__version__}\n"


@pytest.mark.parametrize(
    ("problem", "code", "says"),
    [
        (KeyboardInterrupt(), 130, ""),
        (BrokenPipeError(32, "Broken pipe"), 141, ""),
        (OSError(28, "No space left on device"), 1, "the output cannot be written: No space left on device."),
        (FileNotFoundError(2, "No such file or directory", "x/y"), 1, "'x/y': No such file or directory."),
        (MemoryError(), 1, "not enough memory"),
        (UnicodeEncodeError("utf-8", "\udcff", 0, 1, "surrogates not allowed"), 1, "a name is not valid text"),
    ],
)
def test_what_the_system_refuses_is_an_exit_code(
    problem: BaseException, code: int, says: str, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line on stderr at most, never a traceback."""

    class Failing:
        def run(self) -> int:
            raise problem

    monkeypatch.setattr("rlbench_pin.cli.running.parse", lambda words: Failing())
    begun: list[bool] = []
    assert run(["list"], lambda: begun.append(True)) == code
    err = capsys.readouterr().err
    assert begun == [True]
    assert says in err
    assert "Traceback" not in err
    assert err.count("\n") <= 1
