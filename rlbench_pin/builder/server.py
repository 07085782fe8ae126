"""The web server of the builder: a viser page on this machine; its address contains a random token."""

from __future__ import annotations

import contextlib
import hmac
import http
import io
import secrets
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import Any
from urllib.parse import urlsplit

import msgspec
import websockets.asyncio.server
from viser import ViserServer
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response
from websockets.typing import Data

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.values import as_whole

_HOST = "127.0.0.1"
"""Address to listen on."""
LOCAL_NAMES = (_HOST, "localhost", "::1")
"""Names of this machine. A page that points another name here (DNS rebinding) is refused."""
MAX_UPLOAD_SIZE = 64 * 1024 * 1024
"""Size of an uploaded file at most [bytes]."""
_STARTING = threading.Lock()


class ServerError(RlbenchPinError):
    """The server cannot start."""


@dataclass(frozen=True)
class Refusal:
    """An HTTP answer in place of the page."""

    status: http.HTTPStatus
    message: str
    """The reason and the next step."""
    location: str = ""
    """Target of a redirection."""


@dataclass(frozen=True)
class AccessRules:
    """Checks Host, Origin and token of every HTTP request, also of those that open a websocket."""

    token: str
    """First part of the path."""

    def check(self, request: Request) -> Refusal | None:
        """Remove the token from the path of an allowed request; return why another one is refused."""
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        if len(hosts) != 1 or _split(f"//{hosts[0]}").hostname not in LOCAL_NAMES:
            return Refusal(http.HTTPStatus.FORBIDDEN, f"The builder accepts only the host names {', '.join(LOCAL_NAMES)}.")
        if len(origins) > 1 or any(_site(origin) != hosts[0].lower() for origin in origins):
            message = "The request comes from a page of another site. Open the address in a new tab."
            return Refusal(http.HTTPStatus.FORBIDDEN, message)
        target = request.path.removeprefix("/")
        given = target.partition("/")[0].partition("?")[0]
        if not hmac.compare_digest(given.encode(errors="replace"), self.token.encode()):
            message = "The address has no valid token. Open the full address that the builder printed."
            return Refusal(http.HTTPStatus.FORBIDDEN, message)
        rest = target[len(given) :]
        if not rest and "Upgrade" not in request.headers:
            return Refusal(http.HTTPStatus.TEMPORARY_REDIRECT, "The address ends with a slash.", f"/{self.token}/")
        request.path = rest if rest.startswith("/") else f"/{rest}"
        return None


def _split(address: str) -> Any:
    try:
        return urlsplit(address)
    except ValueError:
        return urlsplit("")


def _site(origin: str) -> str:
    """Return host and port of an origin in lower case; empty for anything but HTTP."""
    parts = _split(origin)
    return str(parts.netloc.lower()) if parts.scheme in ("http", "https") else ""


class _Connection(ServerConnection):
    """A websocket of a tab. It ignores requests for a tunnel to the internet, and the content of too large uploads."""

    async def recv(self, decode: bool | None = None) -> Data:  # type: ignore[override]
        """Return the next message that the page may handle."""
        while True:
            raw = await super().recv(decode)
            if isinstance(raw, str):  # viser sends and takes only binary messages
                return raw
            message = msgspec.msgpack.decode(raw)
            kind = message.get("type")
            if kind == "FileTransferStartUpload" and message["size_bytes"] > MAX_UPLOAD_SIZE:
                # As an empty file it ends at once in the tab, and its parts are ignored; the receiver refuses empty files.
                return msgspec.msgpack.encode({**message, "size_bytes": 0, "part_count": 0})
            if kind not in ("ShareUrlRequest", "ShareUrlDisconnect"):
                return raw


class LocalServer:
    """A viser page whose address contains a random token; a request without the token is refused.

    Args:
        port: TCP port; 0 is any free port.
        title: Title of the page.

    Attributes:
        viser: The page.
        token: First part of the path of the address.

    Raises:
        ServerError: The port is in use.
    """

    def __init__(self, port: int = 0, title: str = "Task builder") -> None:
        wanted = as_whole(port, "port", least=0, most=65535)
        self.token = secrets.token_urlsafe(24)
        rules = AccessRules(self.token)
        with _STARTING, contextlib.redirect_stdout(io.StringIO()), _checked_by(rules):  # viser prints an address without token
            self.viser = ViserServer(_HOST, wanted, title, verbose=False)
        if wanted not in (0, self.port):
            self.stop()
            raise ServerError(f"Port {wanted} is in use. Give another port, or 0 for a free one.")

    @property
    def port(self) -> int:
        """The TCP port."""
        return int(self.viser.get_port())

    @property
    def address(self) -> str:
        """The address for a browser."""
        return f"http://{_HOST}:{self.port}/{self.token}/"

    def stop(self) -> None:
        """Close the page and all connections."""
        with contextlib.redirect_stdout(io.StringIO()):
            self.viser.stop()

    def __enter__(self) -> LocalServer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        self.stop()


@contextlib.contextmanager
def _checked_by(rules: AccessRules) -> Iterator[None]:
    """Have servers that start meanwhile check their requests. Viser has no hook for this; it calls `serve` by its public name."""
    serve = websockets.asyncio.server.serve

    def checked_serve(*args: Any, process_request: Any, **keys: Any) -> Any:
        def checked(connection: ServerConnection, request: Request) -> Response | None:
            if (refusal := rules.check(request)) is None:
                return process_request(connection, request)  # type: ignore[no-any-return]
            response = connection.respond(refusal.status, f"{refusal.message}\n")
            response.headers["Cache-Control"] = "no-store"
            if refusal.location:
                response.headers["Location"] = refusal.location
            return response

        return serve(*args, process_request=checked, create_connection=_Connection, **keys)

    websockets.asyncio.server.serve = checked_serve  # type: ignore[assignment, misc]
    try:
        yield
    finally:
        websockets.asyncio.server.serve = serve  # type: ignore[misc]
