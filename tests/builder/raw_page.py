"""A page without a browser: a websocket that says what a tab of viser says, and more than it may."""

from __future__ import annotations

import contextlib
import re
import threading
import time
from typing import Any

import msgspec
import viser
import websockets.exceptions
import websockets.sync.client
import zstandard

PART = 512 * 1024
"""Bytes of one part of an upload, as the page cuts it."""
_CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": (1, 0, 0, 0), "position": (0, 0, 1), "fov": 1.0, "near": 0.1, "far": 10.0,
    "image_height": 9, "image_width": 9, "look_at": (0, 0, 0), "up_direction": (0, 0, 1),
}  # fmt: skip


class RawPage:
    """One tab.

    Args:
        address: Port and token of the server.
        button: The upload button.
    """

    def __init__(self, address: tuple[int, str], button: str) -> None:
        port, token = address
        self._button, self._heard = button, list[dict[str, Any]]()
        self._socket = websockets.sync.client.connect(
            f"ws://127.0.0.1:{port}/{token}", subprotocols=[f"viser-v{viser.__version__}"], max_size=None  # type: ignore[list-item]
        )  # fmt: skip
        self._reader = threading.Thread(target=self._listen, daemon=True)
        self._reader.start()
        self.say(_CAMERA)

    def _listen(self) -> None:
        with contextlib.suppress(websockets.exceptions.ConnectionClosed):
            for raw in self._socket:
                assert isinstance(raw, bytes)
                size = int.from_bytes(raw[8:16], "little")
                inner = zstandard.ZstdDecompressor().decompress(raw[16 : 16 + size])
                self._heard.extend(msgspec.msgpack.decode(inner)["messages"])

    def say(self, message: dict[str, Any]) -> None:
        """Send one message."""
        self._socket.send(msgspec.msgpack.encode(message))

    def begin(self, transfer: str, size: int, parts: int, name: str) -> None:
        """Declare an upload."""
        self.say({
            "type": "FileTransferStartUpload", "source_component_uuid": self._button, "transfer_uuid": transfer,
            "filename": name, "mime_type": "", "part_count": parts, "size_bytes": size,
        })  # fmt: skip

    def part(self, transfer: str, index: int, content: bytes) -> None:
        """Send a part."""
        self.say({
            "type": "FileTransferPart", "source_component_uuid": self._button, "transfer_uuid": transfer,
            "part_index": index, "content": content,
        })  # fmt: skip

    def upload(self, transfer: str, size: int, name: str) -> bool:
        """Send a file of zeros part by part; False when the connection was cut on the way."""
        count = -(-size // PART)
        try:
            self.begin(transfer, size, count, name)
            for index in range(count):
                self.part(transfer, index, bytes(min(PART, size - index * PART)))
            self._socket.ping().wait(60.0)
        except websockets.exceptions.ConnectionClosed:
            return False
        return True

    def press(self, label: str, timeout: float = 60.0) -> None:
        """Press the button that is called so, once it is there."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            found = [m["uuid"] for m in tuple(self._heard) if m.get("props", {}).get("label") == label]
            if found:
                self.say({"type": "GuiUpdateMessage", "uuid": found[-1], "updates": {"value": True}})
                return
            time.sleep(0.05)
        raise AssertionError(f"no button '{label}'")

    def told(self, words: str) -> str:
        """Return the notification that has some words, or fail."""
        return str(self._wait("NotificationShowMessage", "props", words)["body"])

    def updated(self, words: str) -> None:
        """Wait until an element has got some words, or fail."""
        self._wait("GuiUpdateMessage", "updates", words)

    def _wait(self, kind: str, part: str, words: str) -> dict[str, Any]:
        end = time.monotonic() + 20.0
        while time.monotonic() < end:
            for message in tuple(self._heard):
                if message["type"] == kind and re.search(words, str(message[part])):
                    return message[part]
            time.sleep(0.02)
        raise AssertionError(f"no {kind} with '{words}'")

    def is_open(self) -> bool:
        """Whether the connection stands."""
        try:
            return self._socket.ping().wait(20.0)
        except websockets.exceptions.ConnectionClosed:
            return False

    def close(self) -> None:
        """Leave."""
        self._socket.close()
