"""What is too large is refused by its declared size, with a message; who sends more than it said is cut; memory stays bounded."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest
from viser import ViserServer

from rlbench_pin.builder.server import LocalServer, ServerError
from rlbench_pin.builder.server.guard import MOST_CONNECTIONS
from rlbench_pin.builder.server.notices import Notices
from rlbench_pin.builder.server.transfers import LARGEST_DRAINED, MOST_UNFINISHED, PARTS_OF_VISER, Transfers
from rlbench_pin.builder.server.uploads import LARGEST_UPLOAD
from tests.builder.server.raw_page import PART, ServerProcess, server_process

MEGABYTE = 2**20
GROWTH = 450 * MEGABYTE
"""What the server may take more than at its begin: two uploads of the largest size on their way, joined, and a queue."""


@pytest.fixture(scope="module")
def server() -> Iterator[ServerProcess]:
    """One server for all tests of this file, which none of them may end."""
    with server_process() as server:
        yield server


def test_a_gigabyte_that_says_so_is_refused_in_the_page(server: ServerProcess) -> None:
    """The message names file, size, limit and next step; the page stays connected, its button is free, nothing is kept."""
    page, other, before = server.page(), server.page(), server.peak()
    assert page.upload("one", 1024 * MEGABYTE, name="statue.obj")
    told = page.told("statue.obj")
    assert all(words in told for words in ("'statue.obj'", "1024 MB", "64 MB", "Reduce it"))
    assert page.is_open()
    time.sleep(0.6)
    assert page.heard("FileTransferPartAck")[-1]["total_bytes"] == -1
    assert page.heard("RemoveNotificationMessage")[-1]["uuid"] == "upload-one"
    assert other.heard("NotificationShowMessage") == []
    assert server.peak() - before < GROWTH
    assert page.upload("two", 3 * MEGABYTE, name="small.obj")
    assert server.took() == f"took small.obj {3 * MEGABYTE}"
    page.close()
    other.close()


def test_a_gigabyte_that_lies_is_cut(server: ServerProcess) -> None:
    """Other tabs are told, and whoever comes back; the server goes on."""
    page, other, before = server.page(), server.page(), server.peak()
    assert not page.upload("lie", 1024 * MEGABYTE, declared=10 * MEGABYTE)
    assert "more than it said" in other.told("cut off")
    back = server.page()
    assert "64 MB" in back.told("cut off")
    assert server.peak() - before < GROWTH
    assert back.upload("good", LARGEST_UPLOAD, name="good.stl")
    assert server.took() == f"took good.stl {LARGEST_UPLOAD}"
    assert back.upload("again", LARGEST_UPLOAD, name="again.stl")
    assert server.took() == f"took again.stl {LARGEST_UPLOAD}"
    other.close()
    back.close()


def test_parts_of_nothing_are_a_flood(server: ServerProcess) -> None:
    """Parts of an upload that nobody declared."""
    page, before = server.page(), server.peak()
    with pytest.raises(Exception, match="close"):
        for index in range(2048):
            page.part("ghost", index, bytes(PART))
    assert server.peak() - before < GROWTH


def test_what_is_far_too_large_is_cut(server: ServerProcess) -> None:
    """It is not even thrown away piece by piece; the reason is there when the tab is back."""
    page = server.page()
    page.begin("huge", LARGEST_DRAINED + 1, 4096, "planet.obj")
    assert page.has_ended()
    assert "4096 MB" in server.page().told("planet.obj")


def test_unfinished_uploads_are_few(server: ServerProcess) -> None:
    """Of many tabs together; a tab that leaves makes room."""
    before = server.peak()
    pages = [server.page() for _ in range(12)]
    for number, page in enumerate(pages):
        page.begin(f"part of {number}", LARGEST_UPLOAD // 2, 64, f"n{number}.obj")
        assert page.is_open()
        for index in range(63):
            page.part(f"part of {number}", index, bytes(PART))
        assert page.is_open()
    for number in range(MOST_UNFINISHED, 12):
        assert "under way already" in pages[number].told(f"n{number}.obj")
    assert server.peak() - before < GROWTH
    for page in pages:
        page.close()
    late = server.page()
    assert late.upload("late", MEGABYTE, name="late.obj")
    assert server.took() == f"took late.obj {MEGABYTE}"


@pytest.mark.parametrize(
    ("size", "parts", "name"),
    [(-1, 1, "a.obj"), ("x", 1, "a.obj"), (1, None, "a.obj"), (1, 1, 7), (2**63, 1, "a.obj")],
)
def test_words_of_other_kinds_are_refused(server: ServerProcess, size: object, parts: object, name: object) -> None:
    """A page does not send such; the connection ends, and the server answers the next one."""
    page = server.page()
    page.begin("odd", size, parts, name)
    assert page.has_ended()
    assert server.page().is_open()


@pytest.mark.parametrize(("size", "parts", "why"), [(0, 0, "empty"), (10, 10**6, "parts"), (LARGEST_UPLOAD, 1, "parts")])
def test_uploads_that_no_page_sends_are_refused(server: ServerProcess, size: int, parts: int, why: str) -> None:
    """Empty files, and millions of parts."""
    page = server.page()
    page.begin("odd", size, parts, "odd.obj")
    assert why in page.told("odd.obj")
    assert page.is_open()
    page.close()


def test_connections_are_counted() -> None:
    """One more than the most is refused, until another has gone."""
    with server_process() as server:
        pages = [server.page() for _ in range(MOST_CONNECTIONS)]
        with pytest.raises(Exception, match="503"):
            server.page()
        pages.pop().close()
        assert server.page().is_open()


def test_another_viser_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A version that names its parts otherwise is an error with the next step, not an upload without bounds."""
    server = ViserServer("127.0.0.1", 0, verbose=False)
    monkeypatch.delattr(type(server.gui), "_handle_file_transfer_start")
    with pytest.raises(ServerError, match="viser .*pip install .* installs one that it knows"):
        Transfers(server, Notices(server))
    server.stop()


def test_viser_has_the_parts_that_uploads_need() -> None:
    """Fails first when a new version of viser is tried."""
    with LocalServer() as server:
        states, begin, take, connections, sockets = (part(server.viser) for part in PARTS_OF_VISER)
        assert (states, connections) == ({}, {})
        assert callable(begin)
        assert callable(take)
        assert callable(sockets.unregister_handler)
