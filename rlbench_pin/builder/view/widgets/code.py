"""A file in a field as tall as the page, with numbers of its lines; what is typed stays until it is applied or thrown away."""

from __future__ import annotations

import itertools
from collections.abc import Collection
from html import escape
from urllib.parse import quote

from viser import GuiApi, GuiEvent

from rlbench_pin.builder.view.widgets.items import Code

LINE = 17
"""Height of a line [px]."""
_GUTTER = 40
_NUMBERS = itertools.count()
_STYLE = """<style>
form:has(.{name}) label {{ display: none }}
form:has(.{name}) div:has(> * > label) {{ width: 0 !important; padding: 0 !important }}
form:has(.{name}) textarea {{
  min-height: max(240px, calc(100vh - 300px)) !important; max-height: none !important; resize: vertical;
  font: 12px/{line}px ui-monospace, monospace !important; white-space: pre !important; overflow: auto !important;
  tab-size: 4; padding: 0 6px 0 {pad}px !important;
  background: url("{picture}") 0 0 no-repeat local !important }}
</style><div class="{name}"></div>"""
"""The page knows fields of six lines alone; a background that scrolls with the text carries the numbers."""


class CodeField:
    """A form with one text, `Apply` and `Discard`.

    Args:
        gui: The page.
        item: What it shows.

    Attributes:
        apply: The button that has the text taken over.
        discard: The button that throws away what was typed.
    """

    def __init__(self, gui: GuiApi, item: Code) -> None:
        self._item, self._shown = item, item.value
        self._name = f"code-{next(_NUMBERS)}"
        self._form = gui.add_form(None)
        with self._form:
            self._style = gui.add_html("")
            self._text = gui.add_text(item.label, item.value, multiline=True)
            self._note = gui.add_html("", visible=False)
            self.apply = gui.add_button(f"Apply {item.label}", color="gray")
            self.discard = gui.add_button(f"Discard what was typed in {item.label}", color="gray", visible=False)
        self._text.on_update(self._heard)
        self._draw()

    @property
    def typed(self) -> str:
        """What stands in the field."""
        return self._text.value

    def show(self, item: Code) -> None:
        """Show what the file says now; what was typed and not applied stays, and the field says so."""
        is_typed = self.typed not in (self._shown, item.value)
        self._item = item
        if not is_typed:
            self._shown = item.value
            if self.typed != item.value:
                self._text.value = item.value
        self._draw()

    def take(self, item: Code) -> None:
        """Show what the file says, in place of what was typed."""
        self._text.value = self._shown = item.value
        self._item = item
        self._draw()

    async def _heard(self, event: GuiEvent) -> None:
        self._draw()

    def _draw(self) -> None:
        """Number the lines, and say whether something was typed that is not applied."""
        style = numbered(self._name, self.typed.count("\n") + 1, self._item.marked)
        if style != self._style.content:
            self._style.content = style
        is_typed = self.typed != self._item.value
        if is_typed != self.discard.visible:
            self.discard.visible = self._note.visible = is_typed
            self._item.on_typing(is_typed)
            self.apply.color = "blue" if is_typed else "gray"
        words = _TYPED if self._item.value == self._shown else _OVERTAKEN
        if is_typed and words not in self._note.content:
            self._note.content = f'<div style="padding:2px 10px; font-size:13px; color:#b35900">{escape(words)}</div>'

    def remove(self) -> None:
        """Take it out."""
        self._form.remove()


_TYPED = "Typed, not applied yet: the scene does not know of it, and Save leaves it out."
_OVERTAKEN = (
    "The file was changed while you typed. Apply puts your text in its place (Undo brings it back); Discard shows the file."
)


def numbered(name: str, lines: int, marked: Collection[int]) -> str:
    """Return HTML that makes the text of a form a tall one, with numbers before its lines.

    Args:
        name: Class by which the form is known; no other in the page has it.
        lines: How many lines there are.
        marked: Those that are shown red.
    """
    height = lines * LINE
    rows = [f'<rect width="{_GUTTER - 6}" height="{height}" fill="#f1f3f5"/>']
    for line in range(1, lines + 1):
        color = "#999"
        if line in marked:
            rows.append(f'<rect y="{(line - 1) * LINE}" width="3000" height="{LINE}" fill="#fdd8d3"/>')
            color = "#c0392b"
        rows.append(f'<text x="{_GUTTER - 10}" y="{line * LINE - 4}" fill="{color}">{line}</text>')
    font = "font-family='monospace' font-size='11' text-anchor='end'"
    picture = f"<svg xmlns='http://www.w3.org/2000/svg' width='3000' height='{height}' {font}>{''.join(rows)}</svg>"
    return _STYLE.format(name=name, line=LINE, pad=_GUTTER, picture=f"data:image/svg+xml,{quote(picture)}")


__all__ = ["LINE", "CodeField", "numbered"]
