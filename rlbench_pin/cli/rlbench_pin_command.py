"""Entry point of the program `rlbench-pin`. It is installed next to the package, so that Ctrl-C is handled before the import."""

from __future__ import annotations

import importlib
import os
import signal
import sys
from types import FrameType


def main() -> int:
    """Run the command line of this process and return its exit code; Ctrl-C ends it quietly from now on."""
    is_default = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # not where a shell lets it ignore Ctrl-C
    if is_default:
        signal.signal(signal.SIGINT, _end_at_once)
    module = importlib.import_module("rlbench_pin.cli.main")
    code: int = module.program() if is_default else module.main()
    return code


def _end_at_once(_: int, __: FrameType | None) -> None:
    """End this process with exit code 128 + the number of the signal; no work was begun."""
    sys.stderr.write("rlbench-pin: interrupted\n")
    sys.stderr.flush()
    os._exit(130)


if __name__ == "__main__":
    sys.exit(main())
