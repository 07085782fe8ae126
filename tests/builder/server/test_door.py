"""Without its token, under another name or from another site, the builder answers with a refusal alone."""

from __future__ import annotations

import asyncio
import http.client
from collections.abc import Iterator

import pytest
import websockets.exceptions
import websockets.sync.client

from rlbench_pin.builder.server import LocalServer, ServerError
from rlbench_pin.builder.server.door import Door, Refusal
from rlbench_pin.builder.server.guard import BURST, Allowance, GuardedLoop

TOKEN = "abcdefghijklmnop"


def _head(target: str = f"/{TOKEN}/", host: str = "127.0.0.1:8080", *lines: str, method: str = "GET") -> bytes:
    return "\r\n".join([f"{method} {target} HTTP/1.1", f"Host: {host}", *lines, "", ""]).encode()


def _status(head: bytes) -> str:
    answer = Door(TOKEN).judge(head)
    return answer.status[:3] if isinstance(answer, Refusal) else "200"


@pytest.mark.parametrize(
    "target", ["/", "/index.html", f"/{TOKEN[:-1]}/", f"/{TOKEN}x/", f"/x/{TOKEN}/", f"/?{TOKEN}", f"/{TOKEN.upper()}/"]
)
def test_a_wrong_token_is_refused(target: str) -> None:
    """All but the token itself at the begin of the path."""
    assert _status(_head(target)) == "403"


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example:8080", "[::2]:1", "", "evil.example@x", "[::1"])
def test_other_names_of_the_host_are_refused(host: str) -> None:
    """A page that has its own name point here (DNS rebinding) is not answered."""
    assert _status(_head(host=host)) == "403"


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:9", "file://", "http://[x", "https://localhost:8080"]
)
def test_pages_of_other_sites_are_refused(origin: str) -> None:
    """An origin has to be the very address that was asked."""
    assert _status(_head(f"/{TOKEN}/", "127.0.0.1:8080", f"Origin: {origin}")) == "403"


def test_the_right_request_loses_its_token() -> None:
    """What is behind the door sees the path without it."""
    door = Door(TOKEN)
    answer = door.judge(_head(f"/{TOKEN}/a/b.js?c=d", "localhost:1", "Origin: http://localhost:1"))
    assert isinstance(answer, bytes)
    assert answer.startswith(b"GET /a/b.js?c=d HTTP/1.1\r\nHost: localhost:1\r\n")
    asked = door.judge(_head(f"/{TOKEN}", "127.0.0.1:1", "Upgrade: websocket"))
    assert isinstance(asked, bytes)
    assert asked.startswith(b"GET / HTTP/1.1")
    moved = door.judge(_head(f"/{TOKEN}"))
    assert isinstance(moved, Refusal)
    assert moved.location == f"/{TOKEN}/"


@pytest.mark.parametrize("head", [b"\r\n\r\n", b"GET\r\n\r\n", b"GET x HTTP/1.1\r\n\r\n", b"\xff\xfe\x00 / HTTP/2\r\n\r\n"])
def test_what_is_no_request_is_refused(head: bytes) -> None:
    """Bytes of all kinds get an answer."""
    assert _status(head) == "400"


def test_other_methods_and_two_hosts_are_refused() -> None:
    """Nothing is posted, and which host is meant is not guessed."""
    assert _status(_head(method="POST")) == "405"
    assert _status(_head(f"/{TOKEN}/", "127.0.0.1", "Host: localhost")) == "403"


# The server itself -----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def server() -> Iterator[LocalServer]:
    """A page on a free port."""
    with LocalServer() as server:
        yield server


def _ask(server: LocalServer, path: str, **headers: str) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, body


def test_the_page_is_behind_the_token(server: LocalServer, capsys: pytest.CaptureFixture[str]) -> None:
    """The address opens the page; without token there is a message and the next step, and nothing is printed."""
    status, body = _ask(server, f"/{server.token}/")
    assert (status, b"<title>" in body) == (200, True)
    status, body = _ask(server, "/")
    assert (status, b"Open the whole address" in body) == (403, True)
    assert _ask(server, f"/{server.token}/", Host="evil.example")[0] == 403
    assert _ask(server, f"/{server.token}/%2e%2e/%2e%2e/etc/passwd")[0] == 404
    assert capsys.readouterr().out == ""


def test_the_websocket_is_behind_the_token(server: LocalServer) -> None:
    """The page's own connection is judged like the page."""
    connect = websockets.sync.client.connect
    for target, origin in (("", None), ("wrong", None), (server.token, "http://evil.example")):
        with pytest.raises(websockets.exceptions.InvalidStatus, match="403"):
            connect(f"ws://127.0.0.1:{server.port}/{target}", subprotocols=["viser-v1.1.1"], origin=origin)  # type: ignore[arg-type, list-item]
    with connect(f"ws://127.0.0.1:{server.port}/{server.token}", subprotocols=["viser-v1.1.1"]) as connection:  # type: ignore[list-item]
        assert connection.recv(timeout=10)


def test_a_port_in_use_is_told(server: LocalServer) -> None:
    """No other port is taken in silence."""
    with pytest.raises(ServerError, match=str(server.port)):
        LocalServer(server.port)


def test_the_usual_event_loops_stay_without_a_door(server: LocalServer) -> None:
    """What others do in this process is not guarded."""
    loop = asyncio.new_event_loop()
    assert not isinstance(loop, GuardedLoop)
    loop.close()


def test_who_sends_without_end_is_cut_off() -> None:
    """A connection ends while too much streams in, not afterwards; others are not harmed."""
    floods: list[None] = []
    received: list[int] = []

    class Sink(asyncio.Protocol):
        def data_received(self, data: bytes) -> None:
            received.append(len(data))

    async def flood(loop: GuardedLoop) -> None:
        server = await loop.create_server(Sink, "127.0.0.1", 0)
        _, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
        writer.write(_head())
        with pytest.raises(ConnectionError):
            for _ in range(1000):
                writer.write(bytes(1024 * 1024))
                await writer.drain()
        server.close()

    loop = GuardedLoop(Door(TOKEN), lambda peer: floods.append(None))
    loop.run_until_complete(flood(loop))
    loop.close()
    assert len(floods) == 1
    assert sum(received) <= 1.1 * BURST


def test_an_allowance_grows_again() -> None:
    """Small messages over a long time are no flood."""
    allowance = Allowance(burst=10.0, pace=1e9)
    assert all(allowance.take(9) for _ in range(5))
    assert not Allowance(burst=10.0, pace=0.0).take(11)
