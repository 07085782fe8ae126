"""The table of commands. Parses a command line, runs the command, and returns an exit code for each error."""

from __future__ import annotations

import errno
import inspect
import sys
from collections.abc import Callable, Sequence
from dataclasses import make_dataclass
from typing import Protocol

import tyro

from rlbench_pin import __version__
from rlbench_pin.cli.arm import Arm
from rlbench_pin.cli.build import Build
from rlbench_pin.cli.challenge import Challenge
from rlbench_pin.cli.check import Check
from rlbench_pin.cli.conventions import Conventions
from rlbench_pin.cli.dataset import Dataset
from rlbench_pin.cli.demo import RecordDemos
from rlbench_pin.cli.doctor import Doctor
from rlbench_pin.cli.evaluate import Evaluate
from rlbench_pin.cli.factors import ListFactors
from rlbench_pin.cli.interrupts import INTERRUPTED, PIPE_CLOSED, flushed, say
from rlbench_pin.cli.list_tasks import ListTasks
from rlbench_pin.cli.new import New
from rlbench_pin.cli.problems import Problems
from rlbench_pin.cli.record import Record, spelled_out
from rlbench_pin.cli.replay import Replay
from rlbench_pin.cli.results import ShowResults, VerifyResults
from rlbench_pin.cli.serve import Serve
from rlbench_pin.cli.train import Train
from rlbench_pin.cli.video import Video
from rlbench_pin.cli.view import View
from rlbench_pin.errors import RlbenchPinError, TaskEnvironmentError, UnknownName

COMMANDS: dict[str, type] = {
    "list": ListTasks,
    "demo": RecordDemos,
    "record": Record,
    "dataset": Dataset,
    "replay": Replay,
    "check": Check,
    "view": View,
    "video": Video,
    "new": New,
    "build": Build,
    "arm": Arm,
    "doctor": Doctor,
    "evaluate": Evaluate,
    "factors": ListFactors,
    "conventions": Conventions,
    "challenge": Challenge,
    "serve": Serve,
    "results": ShowResults,
    "results verify": VerifyResults,
    "train": Train,
    "problems": Problems,
}
DONE, FAILED, MISUSED = 0, 1, 2
_WRITING = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
DESCRIPTION = (
    "Robot manipulation tasks with planned demonstrations. `rlbench-pin COMMAND --help` prints the arguments of a command, "
    "`rlbench-pin --version` prints the version."
)


class Command(Protocol):
    """Interface of a command."""

    def run(self) -> int:
        """Do the work and return the exit code."""
        ...


def summary(command: type) -> str:
    """Return the first paragraph of the help of a command."""
    return " ".join((inspect.getdoc(command) or "").split("\n\n")[0].split())


def parse(words: Sequence[str]) -> Command:
    """Return the command of a command line.

    Raises:
        UnknownName: No command has this name; proposes the nearest name.
        SystemExit: The help or the version was printed (0), or the arguments are not valid (2).
    """
    if list(words) == ["--version"]:
        print(f"rlbench-pin {__version__}")
        raise SystemExit(DONE)
    if " ".join(words[:2]) in COMMANDS:
        words = [" ".join(words[:2]), *words[2:]]
    asked = words[0] if words else ""
    if asked and not asked.startswith("-") and asked not in COMMANDS:
        raise UnknownName("command", asked, tuple(COMMANDS), "rlbench-pin --help")
    if asked == "record":
        words = spelled_out(words)
    commands: dict[str, Callable[..., object]] = {
        name: command if name == asked else make_dataclass(command.__name__, [], namespace={"__doc__": summary(command)})
        for name, command in COMMANDS.items()
    }  # the parser of a command is built only when it is needed
    command = _parsed(commands, words)
    if isinstance(command, Evaluate | Record) and command.protocol is not None:
        command = _parsed({**commands, asked: command.with_protocol_defaults()}, words)
    elif isinstance(command, Record) and command.resume:
        command = _parsed({**commands, asked: command.with_recorded_defaults()}, words)
    return command


def _parsed(commands: dict[str, Callable[..., object]], words: Sequence[str]) -> Command:
    command: Command = tyro.extras.subcommand_cli_from_dict(
        commands, prog="rlbench-pin", description=DESCRIPTION, args=list(words)
    )
    return command


def run(words: Sequence[str], on_begin: Callable[[], None]) -> int:
    """Run the command of a command line to its end and return the exit code.

    Args:
        words: The command line after `rlbench-pin`.
        on_begin: Called after the words are parsed, before the work begins.

    Returns:
        0 done, 1 failed, 2 wrong usage, 130 interrupted, 141 closed pipe.
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
    """Flush the output and return the exit code."""
    problem = flushed()
    if problem is None or code in (MISUSED, INTERRUPTED):
        return code
    if isinstance(problem, BrokenPipeError):
        return PIPE_CLOSED
    say(f"rlbench-pin: the output cannot be written: {problem.strerror or problem}. Use another file or disk.")
    return code or FAILED


def _system_error(error: OSError | UnicodeError | MemoryError) -> str:
    if isinstance(error, MemoryError):
        return "there is not enough memory. Use fewer workers or smaller images, or free some memory."
    if isinstance(error, UnicodeError):
        return f"a name is not valid text: {error}. Choose a name with ASCII characters only."
    reason = error.strerror or str(error)
    if error.filename is None:
        if error.errno in _WRITING:
            return f"the output cannot be written: {reason}. Use another file or disk."
        return f"a system call failed: {reason}. Check the permissions and the free resources of this machine."
    return f"'{error.filename}': {reason}. Check that the file or folder exists and can be used."


def _print_error(problem: object, code: int) -> int:
    try:
        print(f"rlbench-pin: {problem}", file=sys.stderr)
    except OSError:  # the pipe is closed
        return code
    return code
