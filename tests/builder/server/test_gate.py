"""What a tab says that no tab of ours would say is not heard."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import pytest
from viser import ViserServer, _messages

from rlbench_pin.builder.server import LocalServer, ServerError
from rlbench_pin.builder.server.gate import PARTS_OF_VISER, Gate, fits
from tests.builder.server.raw_page import RawPage


@pytest.mark.parametrize(
    ("new", "value", "is_taken"),
    [
        (True, False, True), (1, False, False), (None, False, False),
        ("b", "a", True), (1, "a", False), (b"b", "a", False),
        (2, 1.0, True), (2.5, 1, True), (True, 1.0, False), ("2", 1.0, False), (math.nan, 1.0, False), (-math.inf, 1.0, False),
        (10**400, 1.0, False), ([1, 2.5, 3], (0.0, 0.0, 0.0), True), ([1, 2], (0.0, 0.0, 0.0), False),
        ([1, 2, math.nan], (0.0, 0.0, 0.0), False), (3.0, (0.0, 0.0, 0.0), False), ({}, None, False), ([], object(), False),
    ],
)  # fmt: skip
def test_a_value_is_of_the_kind_of_its_field(new: Any, value: Any, is_taken: bool) -> None:
    """And finite, and of the same length."""
    assert fits(new, value) is is_taken


def test_a_choice_is_one_of_its_options() -> None:
    """No other text, nothing else."""
    assert fits("a", "b", ("a", "b"))
    assert not fits("c", "b", ("a", "b"))
    assert not fits(["a"], "b", ("a", "b"))


def test_forged_messages_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """No attribute but the value can be set, no tunnel be opened; the tab stays, and what it may say is heard."""
    shared: list[str] = []
    monkeypatch.setattr(ViserServer, "request_share_url", lambda *args, **keys: shared.append("shared"))
    with LocalServer() as server:
        number = server.viser.gui.add_number("Number", 1.0)
        choice = server.viser.gui.add_dropdown("Choice", ("a", "b"))
        page = RawPage((server.port, server.token), "")

        def update(uuid: Any, **updates: Any) -> None:
            page.say({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates})

        page.say({"type": "ShareUrlRequest"})
        page.say({"type": "ShareUrlDisconnect"})
        for name in ("removed", "update_cb", "sync_cb", "__class__", "label", "nothing"):
            update(number._impl.uuid, **{name: True})
            update(number._impl.uuid, **{name: True, "value": 3.0})
        for value in (None, "x", math.nan, [1], {"a": 1}):
            update(number._impl.uuid, value=value)
            update(choice._impl.uuid, value=value)
        for uuid in ("none", None, 3, ["a"]):
            update(uuid, value=1.0)
        assert page.is_open()
        assert (number.value, choice.value) == (1.0, "a")
        update(number._impl.uuid, value=2.0)
        update(choice._impl.uuid, value="b")
        end = time.monotonic() + 10.0
        while (number.value, choice.value) != (2.0, "b") and time.monotonic() < end:
            time.sleep(0.02)
        assert (number.value, choice.value, number.label, shared) == (2.0, "b", "Number", [])
        page.close()


def _lacks_a_method(server: ViserServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(type(server.gui), "_handle_gui_updates")


def _lacks_a_handler(server: ViserServer, monkeypatch: pytest.MonkeyPatch) -> None:
    PARTS_OF_VISER[2](server).unregister_handler(_messages.ShareUrlRequest)


@pytest.mark.parametrize("change", [_lacks_a_method, _lacks_a_handler])
def test_another_viser_is_told(
    monkeypatch: pytest.MonkeyPatch, change: Callable[[ViserServer, pytest.MonkeyPatch], None]
) -> None:
    """A version that names its parts otherwise is an error with the next step."""
    server = ViserServer("127.0.0.1", 0, verbose=False)
    change(server, monkeypatch)
    with pytest.raises(ServerError, match="viser .*pip install .* installs one that it knows"):
        Gate(server)
    server.stop()
