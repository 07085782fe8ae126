"""Uploads on their way: judged by the size that they declare before anything is kept, and held to it.

A page that sends a file does not stop when it is refused. What it declared is let in and thrown away, so that the page stays
connected; what was not declared ends the connection.
"""

from __future__ import annotations

import asyncio
import math
import time
from dataclasses import dataclass, field
from operator import attrgetter

import viser
from viser import ViserServer, _messages

from rlbench_pin.builder.server.errors import ServerError, UploadRefused
from rlbench_pin.builder.server.guard import GuardedLoop
from rlbench_pin.builder.server.notices import Notices
from rlbench_pin.builder.server.uploads import LARGEST_UPLOAD, check_size
from rlbench_pin.errors import install_hint

MOST_UNFINISHED = 4
"""Uploads that are under way at the same time, of all tabs together."""
MOST_BYTES = 2 * LARGEST_UPLOAD
"""What they may have together [bytes]."""
LARGEST_DRAINED = 4 * 1024**3
"""A refused file of at most so much is let in and thrown away [bytes]; the connection of a larger one is cut."""
STALLED = 30.0
"""An upload of which nothing comes for so long is dropped [s]."""
PARTS_OF_VISER = tuple(
    attrgetter(name)
    for name in (
        "gui._current_file_upload_states",
        "gui._handle_file_transfer_start",
        "gui._handle_file_transfer_part",
        "_websock_server._live_connections",
        "_websock_server",
    )
)
"""What viser does with uploads has no public name: their parts so far, what takes them, the connections of clients."""
CHANNEL_OF_CLIENT = attrgetter("gui._websock_interface")
"""Where messages to one client go."""
_MOST_PARTS = 4096
_ENVELOPE = 1024
_HIDE_AFTER = 0.5


@dataclass
class _Transfer:
    """An upload under way."""

    client: int
    name: str
    size: int
    received: int = 0
    seen: float = field(default_factory=time.monotonic)


class Transfers:
    """Stands between a page and what viser does with its uploads.

    Args:
        server: The page.
        notices: Where refusals are told.

    Raises:
        ServerError: This version of viser takes uploads in another way than the one that is known.
    """

    def __init__(self, server: ViserServer, notices: Notices) -> None:
        self._notices, self._open = notices, dict[str, _Transfer]()
        try:
            self._states, self._begin, self._take, self._connections, sockets = (part(server) for part in PARTS_OF_VISER)
            sockets.unregister_handler(_messages.FileTransferStartUpload, self._begin)
            sockets.unregister_handler(_messages.FileTransferPart, self._take)
        except (AttributeError, AssertionError, ValueError) as error:
            problem = f"viser {viser.__version__} takes uploads in a way that the task builder does not know ({error})"
            raise ServerError(f"{problem}. {install_hint('builder')} installs one that it knows.") from error
        self._clients = server.get_clients
        sockets.register_handler(_messages.FileTransferStartUpload, self._started)
        sockets.register_handler(_messages.FileTransferPart, self._came)

    # In the event loop ------------------------------------------------------------------------------------------------

    def _started(self, client: int, message: _messages.FileTransferStartUpload) -> None:
        """Judge what a page is about to send."""
        if not _is_whole(message) or client not in self._clients():
            self._cut(client)
            return
        name, size = message.filename[:200], message.size_bytes
        self._forget_stalled()
        try:
            check_size(name, size)
            self._check_room(name, size)
            if not size / (8 * 2**20) <= message.part_count <= _MOST_PARTS or message.transfer_uuid in self._open:
                raise UploadRefused(name, f"it would come in {message.part_count} parts", "Load the page again.")
        except UploadRefused as error:
            self._refuse(client, message, error)
            return
        self._grant(client, size, message.part_count)
        self._open[message.transfer_uuid] = _Transfer(client, name, size)
        self._begin(client, message)

    def _came(self, client: int, message: _messages.FileTransferPart) -> None:
        """Take a part of an upload that was let in; what nobody waits for is thrown away."""
        transfer = self._open.get(message.transfer_uuid)
        if transfer is None or transfer.client != client or not isinstance(message.content, bytes):
            return
        transfer.received += len(message.content)
        transfer.seen = time.monotonic()
        if transfer.received > transfer.size:
            self._drop(message.transfer_uuid)
            self._cut(client)
            return
        self._take(client, message)
        if message.transfer_uuid not in self._states:
            del self._open[message.transfer_uuid]

    def _check_room(self, name: str, size: int) -> None:
        """Refuse what is too much beside what is under way."""
        taken = sum(transfer.size for transfer in self._open.values())
        if len(self._open) >= MOST_UNFINISHED or taken + size > MOST_BYTES:
            problem = f"{len(self._open)} uploads with {math.ceil(taken / 2**20)} MB are under way already"
            raise UploadRefused(name, problem, "Send it again when they have come to an end.")

    def _refuse(self, client: int, message: _messages.FileTransferStartUpload, error: UploadRefused) -> None:
        """Tell why; then throw away what comes, or end the connection where that would be too much."""
        is_huge = message.size_bytes > LARGEST_DRAINED
        self._notices.tell("Not uploaded", str(error), bad=True, to=None if is_huge else client, keep=is_huge)
        if is_huge:
            self._cut(client)
            return
        self._grant(client, message.size_bytes, min(message.part_count, _MOST_PARTS))
        self._end_waiting(client, message)

    def _end_waiting(self, client: int, message: _messages.FileTransferStartUpload) -> None:
        """Have the page wait no longer for a file that was refused: its button is free again, its bar of progress goes."""
        channel = CHANNEL_OF_CLIENT(self._clients()[client])
        # To the page an upload is under way while it has fewer bytes than its whole, and done when their share is 1 or more.
        source, transfer = message.source_component_uuid, message.transfer_uuid
        channel.queue_message(_messages.FileTransferPartAck(source, transfer, transferred_bytes=0, total_bytes=-1))
        hide = _messages.RemoveNotificationMessage(f"upload-{transfer}")
        asyncio.get_running_loop().call_later(_HIDE_AFTER, channel.queue_message, hide)

    def _forget_stalled(self) -> None:
        """Drop uploads whose tab is gone, or of which nothing comes."""
        present, now = self._clients(), time.monotonic()
        for key, transfer in list(self._open.items()):
            if transfer.client not in present or key not in self._states or now - transfer.seen > STALLED:
                self._drop(key)

    def _drop(self, key: str) -> None:
        del self._open[key]
        self._states.pop(key, None)

    def _grant(self, client: int, size: int, parts: int) -> None:
        """Let a connection send what it declared."""
        loop, connection = asyncio.get_running_loop(), self._connections.get(client)
        guard = loop.guards.get(connection.remote_address) if isinstance(loop, GuardedLoop) and connection is not None else None
        if guard is not None:
            guard.grant(size + _ENVELOPE * (1 + parts))

    def _cut(self, client: int) -> None:
        """End the connection of a page that sends what it did not declare."""
        loop, connection = asyncio.get_running_loop(), self._connections.get(client)
        if isinstance(loop, GuardedLoop) and connection is not None and connection.remote_address in loop.guards:
            loop.guards[connection.remote_address].cut()


def _is_whole(message: _messages.FileTransferStartUpload) -> bool:
    """Whether the parts of a message are of the kinds that they should be."""
    words = (message.source_component_uuid, message.transfer_uuid, message.filename)
    counts = (message.part_count, message.size_bytes)
    return all(isinstance(word, str) for word in words) and all(isinstance(n, int) and n >= 0 for n in counts)
