"""Pages that commands serve until Ctrl-C."""

from __future__ import annotations

import importlib
import os
import signal
import sys
import threading
import webbrowser
from dataclasses import dataclass
from typing import Any

from rlbench_pin.cli.options import check_at_least
from rlbench_pin.errors import TaskEnvironmentError

_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")
_LARGEST_PORT = 65535


@dataclass(frozen=True)
class PageOptions:
    """What a command takes that can serve a page."""

    live: bool = False
    """Show it in a browser, in 3D and over time, until Ctrl-C."""
    port: int = 0
    """Where the page is served on 127.0.0.1; 0 takes a free port."""
    browser: bool = True
    """Open the page, where there is a browser."""


def live_module() -> Any:
    """Return `rlbench_pin.builder.playback.live`.

    Raises:
        MissingExtra: viser is not installed.
    """
    return importlib.import_module("rlbench_pin.builder.playback.live")


def check_port(page: Any) -> None:
    """Raise TaskEnvironmentError unless the port of a page is one."""
    check_at_least(page, port=0)
    if page.port > _LARGEST_PORT:
        raise TaskEnvironmentError(f"--port is {page.port}; ports go up to {_LARGEST_PORT}, and 0 takes a free one.")


def announce(address: str, browser: bool) -> None:
    """Print where a page is, and open it where somebody wants that and there is a screen."""
    print(f"{address}  (Ctrl-C ends it)", flush=True)
    if browser and has_screen():
        webbrowser.open(address)


def has_screen() -> bool:
    """Whether a browser would be seen."""
    return sys.platform in ("darwin", "win32") or any(os.environ.get(name) for name in _DISPLAYS)


def serve(view: Any, browser: bool) -> int:
    """Print the address of a page, and keep it until Ctrl-C, which comes as KeyboardInterrupt."""
    with view:
        announce(view.address, browser)
        wait_for_end()
    return 0


def wait_for_end() -> None:
    """Wait until somebody wants the page to end: by Ctrl-C, SIGTERM, or closing the terminal; it comes as KeyboardInterrupt."""
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is signal.SIG_DFL:
                signal.signal(number, signal.default_int_handler)
    threading.Event().wait()
