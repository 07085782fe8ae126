"""What a command prints: to a reader that may be gone, a disk that may be full, with names that may be no text."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import TextIO

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
