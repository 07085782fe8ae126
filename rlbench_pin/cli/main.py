"""The entry point: it handles Ctrl-C first, and imports all other modules afterwards."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Sequence

from rlbench_pin.cli.interrupts import is_whole_process, loading, print_any_name

__all__ = ["main", "program"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code: 0 done, 1 failed, 2 wrong usage, 130 interrupted, 141 closed pipe.

    Args:
        arguments: The arguments after `rlbench-pin`; None for those of this process. With None, Ctrl-C ends the process, unless
            another handler is installed or the process ignores Ctrl-C, as in the background of a shell.
    """
    if arguments is None and is_whole_process():
        return program()
    return _run(list(sys.argv[1:] if arguments is None else arguments), lambda: None)


def program() -> int:
    """Run the command line of this process, which has no other purpose, and return its exit code."""
    with loading() as begin:
        print_any_name()
        return _run(sys.argv[1:], begin)


def _run(words: Sequence[str], on_begin: Callable[[], None]) -> int:
    return int(importlib.import_module("rlbench_pin.cli.running").run(words, on_begin))


if __name__ == "__main__":
    sys.exit(main())
