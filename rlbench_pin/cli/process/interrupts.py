"""Ctrl-C: quiet and at once while a command is loaded, as KeyboardInterrupt while it runs, without effect when all is said."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it: 128 and the number of the signal."""
_AGAIN = 0.05
"""Delay after which an interrupt that was lost comes again [s]."""


def say(text: str) -> None:
    """Write a line to stderr, also from a signal handler, where buffered files must not be used."""
    with suppress(OSError, ValueError, AttributeError):
        sys.stderr.flush()
        os.write(sys.stderr.fileno(), f"{text}\n".encode(errors="replace"))


def end_at_once(_: int, __: FrameType | None) -> None:
    """End this process: nothing was begun. An exception could be lost in a library that is just being imported."""
    say("rlbench-pin: interrupted")
    os._exit(INTERRUPTED)


def is_whole_process() -> bool:
    """Whether signals can be handled here: in the main thread, where nobody else handles Ctrl-C."""
    handler = signal.getsignal(signal.SIGINT)
    return threading.current_thread() is threading.main_thread() and handler in (signal.default_int_handler, end_at_once)


def end_quietly() -> None:
    """Answer Ctrl-C by ending the process, unless somebody else handles it; `python -m` imports the package first."""
    if is_whole_process():
        signal.signal(signal.SIGINT, end_at_once)


def _raise_again(lost: sys.UnraisableHookArgs) -> None:
    """Repeat an interrupt that came where no exception leaves, such as in `__del__`; report everything else as usual."""
    if not issubclass(lost.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(lost)
        return
    timer = threading.Timer(_AGAIN, signal.raise_signal, (signal.SIGINT,))
    timer.daemon = True
    timer.start()


@contextmanager
def loading() -> Iterator[Callable[[], None]]:
    """Answer Ctrl-C in this block by ending the process, or by KeyboardInterrupt once what is yielded was called.

    After the block all is said, and Ctrl-C changes nothing any more.
    """
    signal.signal(signal.SIGINT, end_at_once)
    try:
        yield _interruptible
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _interruptible() -> None:
    """From here on Ctrl-C raises KeyboardInterrupt, which nothing keeps to itself."""
    sys.unraisablehook = _raise_again
    signal.signal(signal.SIGINT, signal.default_int_handler)
