"""Ctrl-C, closed pipes and full disks: the process around a command."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import TextIO

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


PIPE_CLOSED = 141
"""Exit code when the reader of the output is gone, as shells have it: 128 and the number of the signal."""


def print_any_name() -> None:
    """Let stdout and stderr take file names that are no text of their encoding; they come out as the bytes they are."""
    for stream in (sys.stdout, sys.stderr):
        encoding = getattr(stream, "encoding", None) or ""
        errors = "surrogateescape" if encoding.lower().replace("-", "") == "utf8" else "backslashreplace"
        with suppress(AttributeError, ValueError, OSError):
            stream.reconfigure(errors=errors)  # type: ignore[union-attr]


def flushed() -> OSError | None:
    """Write what is still held back; return why that is not possible, and drop it then, or None."""
    problem: OSError | None = None
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError as error:
            problem = problem or error
            _drop(stream)
        except (ValueError, AttributeError):  # closed, or there is none
            continue
    return problem


def _drop(stream: TextIO) -> None:
    """Send what a stream still holds to nowhere, so that the end of the process does not complain of it again."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
        stream.flush()
