"""Messages in the page: to one tab, to all, and to a tab that comes back after its connection was cut."""

from __future__ import annotations

import time
from collections import deque

from viser import ClientHandle, ViserServer

KEPT = 60.0
"""A message that a tab may have missed is shown to tabs that come so much later [s]."""
_MOST_KEPT = 3


class Notices:
    """Shows messages.

    Args:
        viser: The page.
    """

    def __init__(self, viser: ViserServer) -> None:
        self._viser = viser
        self._kept: deque[tuple[float, str, str]] = deque(maxlen=_MOST_KEPT)
        viser.on_client_connect(self._came)

    def tell(self, title: str, text: str, bad: bool = False, to: int | None = None, keep: bool = False) -> None:
        """Show a message.

        Args:
            title: Its first line.
            text: The rest.
            bad: Whether it is red, and stays longer.
            to: Number of a client; None is all tabs.
            keep: Whether tabs that come in the next minute see it, too.
        """
        if keep:
            self._kept.append((time.monotonic(), title, text))
        for number, client in self._viser.get_clients().items():
            if to in (None, number):
                _show(client, title, text, bad)

    async def _came(self, client: ClientHandle) -> None:
        """Show a tab what it missed."""
        for when, title, text in tuple(self._kept):
            if time.monotonic() - when < KEPT:
                _show(client, title, text, bad=True)


def _show(client: ClientHandle, title: str, text: str, bad: bool) -> None:
    client.add_notification(title, text, auto_close_seconds=20.0 if bad else 5.0, color="red" if bad else "blue")
