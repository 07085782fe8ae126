"""A door in front of every connection of an asyncio server: nothing reaches the server before its request was judged."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any, cast

from websockets.asyncio.server import ServerConnection

from rlbench_pin.builder.server.door import Door, Refusal

LARGEST_HEAD = 16 * 1024
"""Request line and headers at most [bytes]."""
PATIENCE = 10.0
"""A request has so long to come in [s]."""
BURST = 16 * 1024 * 1024
"""A connection may send so much at once [bytes]: both texts of a task, and more; an upload is granted apart, by its size."""
PACE = 256 * 1024
"""A connection may send so much a second in the long run [bytes/s]; a page that turns its camera sends a fiftieth."""
LARGEST_MESSAGE = 8 * 1024 * 1024
"""One message of a page at most [bytes]; an upload comes in parts of half a megabyte."""
MOST_CONNECTIONS = 128
"""At the same time; a tab needs one, and a few more while it loads."""
Peer = tuple[object, ...]
"""Address of the other end of a connection."""
OnFlood = Callable[[Peer], None]
"""Called when a connection is cut because it sent too much."""


class Allowance:
    """How much a connection may still send.

    Args:
        burst: At once [bytes].
        pace: What is added every second [bytes].
    """

    def __init__(self, burst: float = BURST, pace: float = PACE) -> None:
        self._burst, self._pace, self._left, self._seen = burst, pace, float(burst), time.monotonic()

    def take(self, size: int) -> bool:
        """Take note of what came in, and say whether that was within bounds."""
        now = time.monotonic()
        self._left = min(max(self._burst, self._left), self._left + self._pace * (now - self._seen)) - size
        self._seen = now
        return self._left >= 0.0

    def grant(self, size: int) -> None:
        """Allow so much more [bytes], once."""
        self._left += size


class Guard(asyncio.Protocol):
    """Stands between one connection and the protocol behind it.

    Args:
        door: The rules.
        behind: Makes the protocol behind the door, once somebody may come in.
        guards: Those of all open connections, by the address of the other end.
        on_flood: Called when a connection is cut because it sent too much.
    """

    def __init__(
        self, door: Door, behind: Callable[[], asyncio.BaseProtocol], guards: dict[Peer, Guard], on_flood: OnFlood
    ) -> None:
        self._door, self._make, self._guards, self._on_flood = door, behind, guards, on_flood
        self._peer: Peer = ()
        self._inner: asyncio.Protocol | None = None
        self._transport: asyncio.Transport | None = None
        self._head, self._allowance = b"", Allowance()
        self._timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Wait for the head of a request, not for long."""
        self._transport = cast(asyncio.Transport, transport)
        self._peer = tuple(transport.get_extra_info("peername"))
        self._guards[self._peer] = self
        self._timer = asyncio.get_running_loop().call_later(PATIENCE, self._transport.abort)

    def data_received(self, data: bytes) -> None:
        """Judge the head of the request; pass everything on once it was let in."""
        assert self._transport is not None
        if self._transport.is_closing():
            return
        if not self._allowance.take(len(data)):
            self.cut()
        elif self._inner is not None:
            self._inner.data_received(data)
        else:
            self._head += data
            self._judge(self._transport)

    def grant(self, size: int) -> None:
        """Let the connection send so much more than others [bytes], once."""
        self._allowance.grant(size)

    def cut(self) -> None:
        """End the connection, which sent too much."""
        if self._transport is not None and not self._transport.is_closing():
            self._transport.abort()
            self._on_flood(self._peer)

    def _judge(self, transport: asyncio.Transport) -> None:
        head, end, body = self._head.partition(b"\r\n\r\n")
        if len(head) > LARGEST_HEAD:
            self._refuse(transport, Refusal("431 Request Header Fields Too Large", "The request is too long."))
        elif end and len(self._guards) > MOST_CONNECTIONS:
            message = f"{MOST_CONNECTIONS} connections are open. Close some tabs."
            self._refuse(transport, Refusal("503 Service Unavailable", message))
        elif end:
            answer = self._door.judge(head + end)
            if isinstance(answer, Refusal):
                self._refuse(transport, answer)
            else:
                self._let_in(transport, answer + body)

    def _refuse(self, transport: asyncio.Transport, refusal: Refusal) -> None:
        transport.write(refusal.response())
        transport.close()

    def _let_in(self, transport: asyncio.Transport, data: bytes) -> None:
        self._stop_waiting()
        self._head = b""
        self._inner = cast(asyncio.Protocol, self._make())
        if isinstance(self._inner, ServerConnection):
            self._inner.protocol.max_message_size = LARGEST_MESSAGE
        self._inner.connection_made(transport)
        self._inner.data_received(data)

    def _stop_waiting(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def eof_received(self) -> bool | None:
        """Tell the protocol behind."""
        return None if self._inner is None else self._inner.eof_received()

    def connection_lost(self, exc: Exception | None) -> None:
        """Tell the protocol behind."""
        self._stop_waiting()
        if self._guards.get(self._peer) is self:
            del self._guards[self._peer]
        if self._inner is not None:
            self._inner.connection_lost(exc)

    def pause_writing(self) -> None:
        """Tell the protocol behind."""
        if self._inner is not None:
            self._inner.pause_writing()

    def resume_writing(self) -> None:
        """Tell the protocol behind."""
        if self._inner is not None:
            self._inner.resume_writing()


class GuardedLoop(asyncio.SelectorEventLoop):
    """An event loop whose servers stand behind a door.

    Args:
        door: The rules.
        on_flood: Called when a connection is cut because it sent too much.

    Attributes:
        guards: Those of all open connections, by the address of the other end.
    """

    def __init__(self, door: Door, on_flood: OnFlood) -> None:
        super().__init__()
        self._door, self._on_flood = door, on_flood
        self.guards: dict[Peer, Guard] = {}

    async def create_server(self, protocol_factory: Any, *args: Any, **keys: Any) -> asyncio.Server:
        """Open a server as any loop does, with a guard for each of its connections."""

        def guarded() -> Guard:
            return Guard(self._door, protocol_factory, self.guards, self._on_flood)

        return await super().create_server(guarded, *args, **keys)


class GuardedLoops(asyncio.DefaultEventLoopPolicy):
    """Makes event loops whose servers stand behind a door.

    Args:
        door: The rules.
        on_flood: Called when a connection is cut because it sent too much.
    """

    def __init__(self, door: Door, on_flood: OnFlood) -> None:
        super().__init__()
        self._door, self._on_flood = door, on_flood

    def new_event_loop(self) -> asyncio.AbstractEventLoop:
        """Return a loop behind the door."""
        return GuardedLoop(self._door, self._on_flood)
