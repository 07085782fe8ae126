"""The entry point: parse, run, turn errors into exit codes: 0 done, 1 failed, 2 misused."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Protocol

import tyro

from rlbench_pin.cli.check import Check
from rlbench_pin.cli.dataset import Dataset
from rlbench_pin.cli.demo import RecordDemos
from rlbench_pin.cli.doctor import Doctor
from rlbench_pin.cli.evaluate import Evaluate
from rlbench_pin.cli.list_tasks import ListTasks
from rlbench_pin.cli.new import New
from rlbench_pin.cli.problems import Problems
from rlbench_pin.cli.record import Record, spelled_out
from rlbench_pin.cli.replay import Replay
from rlbench_pin.cli.video import Video
from rlbench_pin.cli.view import View
from rlbench_pin.errors import RlbenchPinError, TaskEnvironmentError, UnknownName

DONE, FAILED, MISUSED = 0, 1, 2


class Subcommand(Protocol):
    """What every command can do."""

    def run(self) -> int:
        """Do it and return the exit code."""
        ...


COMMANDS: dict[str, Callable[..., Subcommand]] = {
    "list": ListTasks,
    "demo": RecordDemos,
    "record": Record,
    "dataset": Dataset,
    "replay": Replay,
    "check": Check,
    "view": View,
    "video": Video,
    "new": New,
    "doctor": Doctor,
    "evaluate": Evaluate,
    "problems": Problems,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code of the process."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    command: Subcommand = tyro.extras.subcommand_cli_from_dict(
        COMMANDS,
        prog="rlbench-pin",
        description="Robot manipulation tasks with planned demonstrations.",
        args=spelled_out(words) if words[:1] == ["record"] else words,
    )
    try:
        return command.run()
    except (UnknownName, TaskEnvironmentError) as error:
        return _print_error(error, MISUSED)
    except RlbenchPinError as error:
        return _print_error(error, FAILED)
    except KeyboardInterrupt:
        return _print_error("interrupted", FAILED)


def _print_error(problem: object, code: int) -> int:
    print(f"rlbench-pin: {problem}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
