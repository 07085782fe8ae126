"""The entry point: everything else is imported when Ctrl-C is already answered quietly."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Sequence

from rlbench_pin.cli.process.commands import COMMANDS
from rlbench_pin.cli.process.interrupts import loading
from rlbench_pin.cli.process.output import print_any_name

__all__ = ["COMMANDS", "main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code: 0 done, 1 failed, 2 misused, 130 interrupted, 141 nobody reads the output.

    Args:
        arguments: The words after `rlbench-pin`; None for those of this process, which then answers Ctrl-C by ending.
    """
    if arguments is not None:
        return _run(list(arguments), lambda: None)
    with loading() as begin:
        print_any_name()
        return _run(sys.argv[1:], begin)


def _run(words: Sequence[str], on_begin: Callable[[], None]) -> int:
    return int(importlib.import_module("rlbench_pin.cli.process.running").run(words, on_begin))


if __name__ == "__main__":
    sys.exit(main())
