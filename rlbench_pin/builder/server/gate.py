"""What a page may say: new values of the fields that it shows, and nothing that opens the builder to other machines."""

from __future__ import annotations

import math
from operator import attrgetter
from typing import Any

import viser
from viser import ViserServer, _messages

from rlbench_pin.builder.server.errors import ServerError
from rlbench_pin.errors import install_hint

PARTS_OF_VISER = tuple(
    attrgetter(name) for name in ("gui._gui_input_handle_from_uuid", "gui._handle_gui_updates", "_websock_server")
)
"""What viser does with values of fields has no public name: the fields, what takes values, the connections."""


class Gate:
    """Stands between a page and what viser does with what its tabs say.

    Viser would set whatever attribute a message names, and at a message of any tab it would lend the page to the internet by
    a tunnel of its makers.

    Args:
        server: The page.

    Raises:
        ServerError: This version of viser takes values in another way than the one that is known.
    """

    def __init__(self, server: ViserServer) -> None:
        try:
            self._fields, self._take, sockets = (part(server) for part in PARTS_OF_VISER)
            for kind in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
                sockets.unregister_handler(kind)
            sockets.unregister_handler(_messages.GuiUpdateMessage, self._take)
        except (AttributeError, AssertionError, ValueError) as error:
            problem = f"viser {viser.__version__} takes values in a way that the task builder does not know ({error})"
            raise ServerError(f"{problem}. {install_hint('builder')} installs one that it knows.") from error
        sockets.register_handler(_messages.GuiUpdateMessage, self._came)

    async def _came(self, client: int, message: _messages.GuiUpdateMessage) -> None:
        """Take the value of a field, or nothing."""
        field = self._fields.get(message.uuid) if isinstance(message.uuid, str) else None
        if field is None or not isinstance(message.updates, dict) or set(message.updates) != {"value"}:
            return
        if fits(message.updates["value"], field.value, getattr(field, "options", None)):
            await self._take(client, message)


def fits(new: Any, value: Any, options: Any = None) -> bool:
    """Whether a field can take a value.

    Args:
        new: What a page sent.
        value: What the field has.
        options: What it offers; None where anything of the kind of its value may be said.
    """
    if options is not None:
        return isinstance(new, str) and new in options
    if isinstance(value, bool | str):
        return isinstance(new, type(value))
    if isinstance(value, tuple):
        return isinstance(new, list | tuple) and len(new) == len(value) and all(map(fits, new, value))
    is_number = isinstance(value, int | float) and isinstance(new, int | float) and not isinstance(new, bool)
    return is_number and abs(new) < 1e300 and math.isfinite(new)
