"""Progress bars on stderr; plain lines where it is not a terminal."""

from __future__ import annotations

import sys
from typing import Any

from tqdm import tqdm

INTERVAL = 10.0
"""Shortest time between two plain lines [s]."""


def progress_bar(*items: Any, **options: Any) -> tqdm:
    """Return a bar of tqdm on a terminal, otherwise one that prints lines; both have the arguments of tqdm."""
    if is_terminal():
        return tqdm(*items, **{"dynamic_ncols": True, **options})
    return _Lines(*items, **{**options, "ncols": 0, "miniters": 1})


def is_terminal() -> bool:
    """Whether stderr is shown by a terminal."""
    return sys.stderr is not None and sys.stderr.isatty()


class _Lines(tqdm):
    """A line at the start, one in `INTERVAL` at most, and one at the end; no control characters."""

    disable: bool
    _next = 0.0

    def display(self, msg: str | None = None, pos: int | None = None) -> bool:
        """Print a line when it is time."""
        if (now := self._time()) < self._next:
            return False
        self._next = now + INTERVAL
        print(str(self), file=self.fp, flush=True)
        return True

    def close(self) -> None:
        """Print the last state."""
        if self.disable:
            return
        if self.leave:
            self._next = 0.0
            self.display()
        self.disable = True
        self._decr_instances(self)
