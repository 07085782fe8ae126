"""Ctrl-C, closed pipes and full disks, for the process of a command."""

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
"""Exit code after Ctrl-C, as in shells: 128 plus the number of the signal."""
_AGAIN = 0.05
"""Delay after which an interrupt is repeated [s]."""
_IMPORT = "<frozen importlib._bootstrap>"
"""File name that Python gives to the code that imports a module."""


def say(text: str) -> None:
    """Write a line to stderr, also from a signal handler, where buffered files must not be used."""
    with suppress(OSError, ValueError, AttributeError):
        sys.stderr.flush()
        os.write(sys.stderr.fileno(), f"{text}\n".encode(errors="replace"))


def end_at_once(_: int, __: FrameType | None) -> None:
    """End this process at once. No work has begun, and a library that is being imported could lose an exception."""
    say("rlbench-pin: interrupted")
    os._exit(INTERRUPTED)


def is_whole_process() -> bool:
    """Whether signals can be handled: in the main thread, if no other handler of Ctrl-C is installed."""
    handler = signal.getsignal(signal.SIGINT)
    return threading.current_thread() is threading.main_thread() and handler in (signal.default_int_handler, end_at_once)


def end_quietly() -> None:
    """Let Ctrl-C end the process, unless another handler is installed; `python -m` imports the package first."""
    if is_whole_process():
        signal.signal(signal.SIGINT, end_at_once)


def interrupt(_: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt; during an import later, since a compiled library that is being loaded ends the process then."""
    while frame is not None:
        if frame.f_code.co_filename == _IMPORT:
            _interrupt_later()
            return
        frame = frame.f_back
    raise KeyboardInterrupt


def _interrupt_later() -> None:
    timer = threading.Timer(_AGAIN, signal.raise_signal, (signal.SIGINT,))
    timer.daemon = True
    timer.start()


def _raise_again(lost: sys.UnraisableHookArgs) -> None:
    """Repeat an interrupt raised where exceptions are ignored, such as in `__del__`; report all other errors as usual."""
    if issubclass(lost.exc_type, KeyboardInterrupt):
        _interrupt_later()
    else:
        sys.__unraisablehook__(lost)


@contextmanager
def loading() -> Iterator[Callable[[], None]]:
    """Let Ctrl-C end the process in this block, or raise KeyboardInterrupt once the yielded function was called.

    After the block the command is complete, and Ctrl-C has no effect.
    """
    signal.signal(signal.SIGINT, end_at_once)
    try:
        yield _interruptible
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _interruptible() -> None:
    """Let Ctrl-C raise KeyboardInterrupt from now on, and repeat an interrupt that is lost."""
    sys.unraisablehook = _raise_again
    signal.signal(signal.SIGINT, interrupt)


PIPE_CLOSED = 141
"""Exit code when the reader of the output is gone, as in shells: 128 plus the number of the signal."""


def print_any_name() -> None:
    """Let stdout and stderr accept file names that are invalid in their encoding; they are written as their bytes."""
    for stream in (sys.stdout, sys.stderr):
        encoding = getattr(stream, "encoding", None) or ""
        errors = "surrogateescape" if encoding.lower().replace("-", "") == "utf8" else "backslashreplace"
        with suppress(AttributeError, ValueError, OSError):
            stream.reconfigure(errors=errors)  # type: ignore[union-attr]


def flushed() -> OSError | None:
    """Flush stdout and stderr; return the error if that fails, and drop the rest, or None."""
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
    """Discard the buffer of a stream, so that the end of the process does not report the error again."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
        stream.flush()
