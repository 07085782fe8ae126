"""The builder's page, served on this machine to whoever has its address."""

from __future__ import annotations

import asyncio
import contextlib
import io
import secrets
import threading
from collections.abc import Iterator
from types import TracebackType

from viser import ViserServer

from rlbench_pin.builder.server.door import LOCAL_NAMES, Door
from rlbench_pin.builder.server.errors import ServerError
from rlbench_pin.builder.server.gate import Gate
from rlbench_pin.builder.server.guard import BURST, GuardedLoops, Peer
from rlbench_pin.builder.server.notices import Notices
from rlbench_pin.builder.server.transfers import Transfers
from rlbench_pin.builder.server.uploads import LARGEST_UPLOAD
from rlbench_pin.values import as_text, as_whole

LOCAL = "127.0.0.1"
"""Where it listens, unless told otherwise."""
_FLOOD = (
    f"It sent more than it said, or more than {BURST // 2**20} MB beside its uploads; nothing of that was kept. "
    f"A file may have {LARGEST_UPLOAD // 2**20} MB. Load the page again if it does not come back by itself."
)
_STARTING = threading.Lock()


class LocalServer:
    """A page of viser behind a random token; without it, nothing is answered but a refusal.

    Args:
        port: Where it listens; 0 takes a free one.
        host: Address of this machine on which it listens. Another than 127.0.0.1 lets other machines ask.
        title: What the page is called.

    Attributes:
        viser: The page.
        notices: Messages in it.
        token: What the address begins with.

    Raises:
        ServerError: The port is in use, or viser is of an unknown version.
    """

    def __init__(self, port: int = 0, host: str = LOCAL, title: str = "Task builder") -> None:
        self._host, wanted = as_text(host, "host"), as_whole(port, "port", least=0, most=65535)
        self.token = secrets.token_urlsafe(24)
        self._floods = 0
        names = dict.fromkeys((*LOCAL_NAMES, self._host))
        with _guarded(GuardedLoops(Door(self.token, tuple(names)), self._count_flood)):
            self.viser = ViserServer(self._host, wanted, title, verbose=False)
        self.notices = Notices(self.viser)
        try:
            Gate(self.viser)
            Transfers(self.viser, self.notices)
        except ServerError:
            self.stop()
            raise
        if wanted not in (0, self.port):
            self.stop()
            raise ServerError(f"Port {wanted} is in use. Give another, or 0 for any that is free.")

    def _count_flood(self, peer: Peer) -> None:
        self._floods += 1
        self.notices.tell("A tab was cut off", _FLOOD, bad=True, keep=True)

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self.viser.get_port())

    @property
    def floods(self) -> int:
        """How many connections were cut because they sent too much."""
        return self._floods

    @property
    def address(self) -> str:
        """What a browser opens."""
        return f"http://{self._host}:{self.port}/{self.token}/"

    def stop(self) -> None:
        """Close the page and all connections."""
        with contextlib.redirect_stdout(io.StringIO()):
            self.viser.stop()

    def __enter__(self) -> LocalServer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        self.stop()


@contextlib.contextmanager
def _guarded(loops: GuardedLoops) -> Iterator[None]:
    """Put the event loop that a server makes for itself behind a door; what it prints lacks the token, and is not shown."""
    with _STARTING, contextlib.redirect_stdout(io.StringIO()):
        usual = asyncio.get_event_loop_policy()
        asyncio.set_event_loop_policy(loops)
        try:
            yield
        finally:
            asyncio.set_event_loop_policy(usual)
