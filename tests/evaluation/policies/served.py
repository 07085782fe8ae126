"""A WebSocket server for tests of policies that are served."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

server = pytest.importorskip("websockets.sync.server")
Handler = Callable[[Any], None]


@contextmanager
def served(handle: Handler, **settings: Any) -> Iterator[int]:
    """A WebSocket server on a free port of this machine."""
    with server.serve(handle, "127.0.0.1", 0, compression=None, close_timeout=0.1, **settings) as running:
        thread = threading.Thread(target=running.serve_forever, daemon=True)
        thread.start()
        yield running.socket.getsockname()[1]
        running.shutdown()
        thread.join(5.0)
