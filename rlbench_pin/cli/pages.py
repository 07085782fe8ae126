"""Pages that commands serve until Ctrl-C. Modules that need viser are imported when a page is requested."""

from __future__ import annotations

import importlib
import os
import signal
import sys
import threading
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from rlbench_pin.cli.options import check_at_least
from rlbench_pin.errors import TaskEnvironmentError

_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")
_MAX_PORT = 65535


@dataclass(frozen=True)
class PageOptions:
    """Options of commands that can serve a page."""

    live: bool = False
    """Show a live 3D page in a browser until Ctrl-C."""
    port: int = 0
    """Port of the page on 127.0.0.1; 0 takes a free port."""
    browser: bool = True
    """Open the page in a browser if there is a screen."""


def live_module() -> Any:
    """Return `rlbench_pin.viewer.live`.

    Raises:
        MissingExtra: viser is not installed.
    """
    return importlib.import_module("rlbench_pin.viewer.live")


def check_port(page: Any) -> None:
    """Raise TaskEnvironmentError unless the port of a page is valid."""
    check_at_least(page, port=0)
    if page.port > _MAX_PORT:
        raise TaskEnvironmentError(f"--port is {page.port}; it must be at most {_MAX_PORT}. Use 0 for a free port.")


def announce(address: str, browser: bool) -> None:
    """Print the address of a page, and open it if `browser` is set and there is a screen. Signals then end the command."""
    answer_signals()
    print(f"{address}  (Ctrl-C ends it)", flush=True)
    if browser and has_screen():
        webbrowser.open(address)


def has_screen() -> bool:
    """Whether there is a screen for a browser."""
    return sys.platform in ("darwin", "win32") or any(os.environ.get(name) for name in _DISPLAYS)


@contextmanager
def live_page(show: Callable[[Any], Any], title: str, page: PageOptions) -> Iterator[Any]:
    """Serve a page for the duration of a block, and print its address.

    Args:
        show: Draws the view into a viser server and returns it; it is yielded.
        title: Title of the page.
        page: Port, and whether a browser is opened.

    Raises:
        ServerError: The port is in use.
    """
    server_module = importlib.import_module("rlbench_pin.builder.server")
    with server_module.LocalServer(page.port, title=title) as server:
        view = show(server.viser)
        try:
            announce(server.address, page.browser)
            yield view
        finally:
            view.close()


def answer_signals() -> None:
    """Let Ctrl-C, SIGTERM and a closed terminal raise KeyboardInterrupt, also if SIGINT was ignored at the start."""
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) in (signal.SIG_DFL, signal.SIG_IGN):
                signal.signal(number, signal.default_int_handler)


def wait_for_end() -> None:
    """Wait until Ctrl-C, SIGTERM or a closed terminal raises KeyboardInterrupt."""
    answer_signals()
    threading.Event().wait()
