"""The server refuses requests without its token, under another host name or from another site, and too large uploads."""

from __future__ import annotations

import contextlib
import http.client
import socket
import time
from collections.abc import Iterator

import pytest
import websockets.asyncio.server
import websockets.exceptions
import websockets.sync.client
from viser import ViserServer
from websockets.datastructures import Headers
from websockets.http11 import Request

from rlbench_pin.builder.server import MAX_UPLOAD_SIZE, AccessRules, LocalServer, ServerError
from tests.builder.raw_page import PART, RawPage

TOKEN = "abcdefghijklmnop"
HOST = ("Host", "127.0.0.1:8080")
UPGRADE = ("Upgrade", "websocket")


def _check(target: str, *headers: tuple[str, str]) -> tuple[int, str]:
    """Return the status and the path or location that the rules give a request."""
    request = Request(target, Headers(headers))
    refusal = AccessRules(TOKEN).check(request)
    return (200, request.path) if refusal is None else (int(refusal.status), refusal.location)


@pytest.mark.parametrize(
    "target",
    ["/", "/index.html", f"/{TOKEN[:-1]}/", f"/{TOKEN}x/", f"/x/{TOKEN}/", f"/?{TOKEN}", f"/{TOKEN.upper()}/", "/\udcff/", ""],
)
def test_a_wrong_token_is_refused(target: str) -> None:
    """The path begins with the token."""
    assert _check(target, HOST)[0] == 403


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example:8080", "[::2]:1", "", "evil.example@x", "[::1"])
def test_other_host_names_are_refused(host: str) -> None:
    """A page whose own name points to this machine (DNS rebinding) is refused."""
    assert _check(f"/{TOKEN}/", ("Host", host))[0] == 403


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:9", "file://", "http://[x", "https://localhost:8080"]
)
def test_other_origins_are_refused(origin: str) -> None:
    """The origin has to be the requested host, with and without a websocket."""
    assert _check(f"/{TOKEN}/", HOST, ("Origin", origin))[0] == 403
    assert _check(f"/{TOKEN}/", HOST, UPGRADE, ("Origin", origin))[0] == 403


def test_repeated_or_missing_headers_are_refused() -> None:
    """The host is not guessed."""
    assert _check(f"/{TOKEN}/", HOST, ("Host", "localhost"))[0] == 403
    assert _check(f"/{TOKEN}/")[0] == 403
    assert _check(f"/{TOKEN}/", HOST, *[("Origin", "http://127.0.0.1:8080")] * 2)[0] == 403


def test_the_token_is_removed_from_allowed_requests() -> None:
    """Viser sees the path without it; the page without a slash is redirected."""
    request = (f"/{TOKEN}/a/b.js?c=d", ("Host", "localhost:1"), ("Origin", "http://localhost:1"))
    assert _check(*request) == (200, "/a/b.js?c=d")
    assert _check(f"/{TOKEN}", HOST, UPGRADE) == (200, "/")
    assert _check(f"/{TOKEN}", HOST) == (307, f"/{TOKEN}/")


# A running server ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def server() -> Iterator[LocalServer]:
    """A page on a free port."""
    with LocalServer() as server:
        yield server


def _ask(server: LocalServer, path: str, method: str = "GET", **headers: str) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    connection.request(method, path, headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, body


def test_the_page_is_behind_the_token(server: LocalServer, capsys: pytest.CaptureFixture[str]) -> None:
    """The address opens the page; without the token there is a message with the next step, and nothing is printed."""
    status, body = _ask(server, f"/{server.token}/")
    assert (status, b"<title>" in body) == (200, True)
    status, body = _ask(server, "/")
    assert (status, b"Open the full address" in body) == (403, True)
    assert _ask(server, f"/{server.token}")[0] == 307
    assert _ask(server, f"/{server.token}/", Host="evil.example")[0] == 403
    assert _ask(server, f"/{server.token}/%2e%2e/%2e%2e/etc/passwd")[0] == 404
    assert capsys.readouterr().out == ""


def test_other_methods_are_refused(server: LocalServer) -> None:
    """Only GET is answered with the page."""
    with contextlib.suppress(http.client.HTTPException, ConnectionError):  # answered, or closed
        assert _ask(server, f"/{server.token}/", "POST")[0] == 400


@pytest.mark.parametrize("head", [b"\r\n\r\n", b"GET\r\n\r\n", b"GET x HTTP/1.1\r\n\r\n", b"\xff\xfe\x00 / HTTP/2\r\n\r\n"])
def test_invalid_requests_are_refused(server: LocalServer, head: bytes) -> None:
    """No bytes open the page."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=10) as connection:
        connection.sendall(head)
        assert b"200 OK" not in connection.recv(4096)
    assert _ask(server, f"/{server.token}/")[0] == 200


def test_only_the_loopback_interface_listens(server: LocalServer) -> None:
    """Other addresses of this machine refuse the connection."""
    with pytest.raises(OSError), socket.create_connection(("127.0.0.2", server.port), timeout=5):
        pass


def test_the_websocket_is_behind_the_token(server: LocalServer) -> None:
    """The connection of a tab is checked like the page."""
    connect = websockets.sync.client.connect
    for target, origin in (("", None), ("wrong", None), (server.token, "http://evil.example")):
        with pytest.raises(websockets.exceptions.InvalidStatus, match="403"):
            connect(f"ws://127.0.0.1:{server.port}/{target}", subprotocols=["viser-v1.1.1"], origin=origin)  # type: ignore[arg-type, list-item]
    with connect(f"ws://127.0.0.1:{server.port}/{server.token}", subprotocols=["viser-v1.1.1"]) as connection:  # type: ignore[list-item]
        assert connection.recv(timeout=10)


def test_a_port_in_use_is_an_error(server: LocalServer) -> None:
    """No other port is taken silently."""
    with pytest.raises(ServerError, match=str(server.port)):
        LocalServer(server.port)


def test_other_servers_of_the_process_are_not_checked(server: LocalServer) -> None:
    """`websockets` is as before."""
    assert websockets.asyncio.server.serve.__module__ == "websockets.asyncio.server"


def test_no_tab_opens_a_tunnel(monkeypatch: pytest.MonkeyPatch) -> None:
    """Requests to share the page on the internet are ignored; other messages are heard."""
    shared: list[str] = []
    monkeypatch.setattr(ViserServer, "request_share_url", lambda *args, **keys: shared.append("shared"))
    monkeypatch.setattr(ViserServer, "disconnect_share_url", lambda *args, **keys: shared.append("disconnected"))
    with LocalServer() as server:
        number = server.viser.gui.add_number("Number", 1.0)
        page = RawPage((server.port, server.token), "")
        page.say({"type": "ShareUrlRequest"})
        page.say({"type": "ShareUrlDisconnect"})
        page.say({"type": "GuiUpdateMessage", "uuid": number._impl.uuid, "updates": {"value": 2.0}})
        end = time.monotonic() + 10.0
        while number.value != 2.0 and time.monotonic() < end:
            time.sleep(0.02)
        assert (number.value, shared) == (2.0, [])
        page.close()


def test_the_content_of_a_too_large_upload_is_ignored() -> None:
    """It arrives as an empty file, which the builder refuses; the tab stays connected, and its next file arrives."""
    received: list[tuple[str, int]] = []
    with LocalServer() as server:
        button = server.viser.gui.add_upload_button("Upload")

        @button.on_upload
        async def _(event: object) -> None:
            received.append((button.value.name, len(button.value.content)))

        page = RawPage((server.port, server.token), button._impl.uuid)
        assert page.upload("one", MAX_UPLOAD_SIZE + 1, name="statue.obj")
        assert page.upload("two", 3 * PART, name="small.obj")
        end = time.monotonic() + 20.0
        while len(received) < 2 and time.monotonic() < end:
            time.sleep(0.02)
        assert received == [("statue.obj", 0), ("small.obj", 3 * PART)]
        assert page.is_open()
        page.close()
