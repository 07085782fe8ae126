"""What cameras see, as small pictures in a page."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from viser import GuiApi


def pictures_html(pictures: Mapping[str, NDArray[np.uint8]]) -> str:
    """Return pictures (h, w, 3) by name, two beside each other, each with its name."""
    cells = "".join(
        f'<figure style="margin:0"><img alt="{name}" style="width:100%;display:block" src="{_address(picture)}">'
        f'<figcaption style="font-size:0.75em">{name}</figcaption></figure>'
        for name, picture in pictures.items()
    )
    return f'<div style="display:grid;grid-template-columns:1fr 1fr;gap:4px;padding:0 0.75em">{cells}</div>'


def _address(picture: NDArray[np.uint8]) -> str:
    """Return a picture as an address that holds it."""
    file = io.BytesIO()
    Image.fromarray(picture).save(file, "JPEG", quality=85)
    return "data:image/jpeg;base64," + base64.b64encode(file.getvalue()).decode()


class CameraPanel:
    """The pictures of the five cameras, which somebody may switch off.

    Args:
        gui: Where they are drawn.
        on_wanted: Called when somebody switches them on.
        wanted: Whether they are on at first.
    """

    def __init__(self, gui: GuiApi, on_wanted: Callable[[], None], wanted: bool = True) -> None:
        self._on_wanted = on_wanted
        self._switch = gui.add_checkbox("Show", wanted, hint="Pictures take a few milliseconds each")
        self._html = gui.add_html("")
        self._switch.on_update(lambda _: self._switched())

    @property
    def wanted(self) -> bool:
        """Whether somebody wants to see them."""
        return bool(self._switch.value)

    def show(self, pictures: Mapping[str, NDArray[np.uint8]]) -> None:
        """Show pictures (h, w, 3) by the names of their cameras."""
        self._html.content = pictures_html(pictures)

    def _switched(self) -> None:
        if self.wanted:
            self._on_wanted()
        else:
            self._html.content = ""
