"""Pages that commands serve to a browser of this machine."""

from __future__ import annotations

import os
import sys
import threading
import webbrowser


def serve_page(address: str, what: str, browser: bool) -> None:
    """Say where a page is, open it, and wait for Ctrl-C.

    Args:
        address: What a browser opens.
        what: What is on the page.
        browser: Open it in a browser, where there is a screen.
    """
    print(f"{what}: {address}\nCtrl-C ends it. Whoever has the address can use the page.", flush=True)
    if browser and has_screen():
        webbrowser.open(address)
    threading.Event().wait()


def has_screen() -> bool:
    """Whether a browser with a window can be opened here."""
    return sys.platform == "darwin" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
