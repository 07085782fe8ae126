"""Parse a command line, run the command, turn what it raises into exit codes."""

from __future__ import annotations

import errno
import importlib
import sys
from collections.abc import Callable, Sequence
from dataclasses import make_dataclass

import tyro

from rlbench_pin import __version__
from rlbench_pin.cli.process.commands import COMMANDS, Home, Subcommand, working
from rlbench_pin.cli.process.interrupts import INTERRUPTED, say
from rlbench_pin.cli.process.output import PIPE_CLOSED, flushed
from rlbench_pin.errors import RlbenchPinError, TaskEnvironmentError, UnknownName

DONE, FAILED, MISUSED = 0, 1, 2
_WRITING = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
DESCRIPTION = (
    "Robot manipulation tasks with planned demonstrations. `rlbench-pin COMMAND --help` says what a command takes, "
    "`rlbench-pin --version` which version this is."
)


def parse(words: Sequence[str]) -> Subcommand:
    """Return the command that `words` ask for.

    Raises:
        SystemExit: Help or the version was asked for and printed (0), or the words are no command line (2).
    """
    if list(words) == ["--version"]:
        print(f"rlbench-pin {__version__}")
        raise SystemExit(DONE)
    asked = words[0] if words else ""
    if asked == "record":
        words = importlib.import_module("rlbench_pin.cli.arguments.record").spelled_out(words)
    commands: dict[str, Callable[..., object]] = {
        name: home.load() if name == asked else _stand_in(home) for name, home in COMMANDS.items()
    }
    arguments: object = tyro.extras.subcommand_cli_from_dict(
        commands, prog="rlbench-pin", description=DESCRIPTION, args=list(words)
    )
    command: Subcommand = working(arguments)
    return command


def _stand_in(home: Home) -> type:
    """Return a class that has the summary of a command and nothing else."""
    made: type = make_dataclass(home.name, [], namespace={"__doc__": home.summary})
    return made


def run(words: Sequence[str], on_begin: Callable[[], None]) -> int:
    """Run the command that `words` ask for to its end and return the exit code.

    Args:
        words: The command line behind `rlbench-pin`.
        on_begin: Called between reading the words and beginning the work.

    Returns:
        0 done, 1 failed, 2 misused, 130 interrupted, 141 nobody reads the output.
    """
    try:
        command = parse(words)
        on_begin()
        code = command.run()
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else DONE
    except (UnknownName, TaskEnvironmentError) as error:
        code = _print_error(error, MISUSED)
    except RlbenchPinError as error:
        code = _print_error(error, FAILED)
    except KeyboardInterrupt:
        say("rlbench-pin: interrupted")
        code = INTERRUPTED
    except BrokenPipeError:
        code = PIPE_CLOSED
    except (OSError, UnicodeError, MemoryError) as error:
        code = _print_error(_system_error(error), FAILED)
    return _after_flush(code)


def _after_flush(code: int) -> int:
    """Return the exit code when everything printed has left the process."""
    problem = flushed()
    if problem is None or code in (MISUSED, INTERRUPTED):
        return code
    if isinstance(problem, BrokenPipeError):
        return PIPE_CLOSED
    say(f"rlbench-pin: the output cannot be written: {problem.strerror or problem}.")
    return code or FAILED


def _system_error(error: OSError | UnicodeError | MemoryError) -> str:
    if isinstance(error, MemoryError):
        return "there is not enough memory."
    if isinstance(error, UnicodeError):
        return f"a name is no text: {error}. Choose a name of ordinary characters."
    reason = error.strerror or str(error)
    if error.filename is None:
        return f"the output cannot be written: {reason}." if error.errno in _WRITING else f"the system refused: {reason}."
    return f"'{error.filename}': {reason}. See whether the file or folder is there and can be used."


def _print_error(problem: object, code: int) -> int:
    try:
        print(f"rlbench-pin: {problem}", file=sys.stderr)
    except OSError:  # nobody reads it
        return code
    return code
