"""Makes the items of a panel in the browser, and keeps their values."""

from __future__ import annotations

import threading
from collections.abc import Callable, Coroutine
from typing import Any

import numpy as np
from viser import GuiApi, GuiEvent

from rlbench_pin.builder.view.widgets.code import CodeField
from rlbench_pin.builder.view.widgets.items import (
    Button,
    Check,
    Choice,
    Code,
    Entry,
    Fold,
    Item,
    Line,
    Markup,
    Note,
    Number,
    Picture,
    Progress,
    Row,
    Slider,
    Upload,
    Vector,
)

Post = Callable[[Callable[[], None], str], None]
"""Has a function run where edits are made; of several of one kind that wait, the last counts, unless the kind is empty."""
_FIXED: dict[type, tuple[str, ...]] = {
    Button: ("key",),
    Check: ("label", "hint"),
    Number: ("label", "step", "least", "most", "hint"),
    Slider: ("label", "least", "most", "step"),
    Vector: ("label", "step", "hint"),
    Choice: ("label", "hint"),
    Line: ("label",),
    Entry: ("label", "button", "lines"),
    Code: ("label",),
    Picture: ("label",),
    Upload: ("label", "hint"),
    Fold: ("label",),
}
"""What makes an item another one when it changes."""


def shape(item: Item) -> tuple[object, ...]:
    """Return what an item cannot change without being made anew."""
    names = _FIXED.get(type(item), ())
    if isinstance(item, Row):
        return (Row, item.label, *item.presses)
    if isinstance(item, Button) and not item.key:
        names = ("label",)
    return (type(item), *(getattr(item, name) for name in names))


class Widget:
    """One item in the browser.

    Args:
        item: What it shows.
        post: Has a function run where edits are made.
    """

    def __init__(self, item: Item, post: Post) -> None:
        self._item, self._post, self._lock = item, post, threading.Lock()
        self._heard, self._told, self._touched = 0, 0, False
        self._value: Callable[[Item], None] | None = None
        self._removal: Callable[[], None] = _nothing

    def bind(self, remove: Callable[[], None], value: Callable[[Item], None] | None) -> None:
        """Say how it is taken out, and how it takes a new value."""
        self._removal, self._value = remove, value

    def show(self, item: Item) -> None:
        """Take new values; what somebody is changing at this moment, and what says the same as before, stays as it is."""
        with self._lock:
            said, self._item = self._item, item
            busy, touched = self._heard > self._told, self._touched
            self._touched = busy and touched
        if not busy and self._value is not None and (touched or _says(said) != _says(item)):
            self._value(item)

    def remove(self) -> None:
        """Take it out."""
        self._removal()

    def listen(
        self, tell: Callable[[Any, Any], None], *, every: bool = False
    ) -> Callable[[GuiEvent[Any]], Coroutine[Any, Any, None]]:
        """Return what the browser's event calls; own changes are no events.

        Args:
            tell: Run with the item as it is by then, and the value that the event brought.
            every: Each event counts; otherwise the last of those that wait.
        """

        async def heard(event: GuiEvent[Any]) -> None:  # in the event loop, so that values come in order
            if event.client_id is None:
                return
            value = getattr(event.target, "value", None)
            with self._lock:
                self._heard += 1
                number = self._heard

            def told() -> None:
                with self._lock:
                    self._told, self._touched = number, True
                    item = self._item
                tell(item, value)

            self._post(told, "" if every else f"widget {id(self)}")

        return heard


def _says(item: Item) -> object:
    """Return what an item shows that may change; pictures are compared by those who draw them."""
    if isinstance(item, Choice):
        return item.value, item.options
    if isinstance(item, Button):
        return item.label, item.shade, item.disabled
    if isinstance(item, Picture):
        return id(item.pixels)
    if isinstance(item, Code):
        return item.value, item.marked
    name = "text" if isinstance(item, Note) else "html" if isinstance(item, Markup) else "value"
    return getattr(item, "share" if isinstance(item, Progress) else name, None)


def _nothing() -> None:
    """Nothing is to be done."""


def make(gui: GuiApi, item: Item, post: Post) -> Widget:
    """Put an item into the current container."""
    widget = Widget(item, post)
    _MAKERS[type(item)](gui, item, widget)
    return widget


def _assign(handle: Any, name: str, value: object) -> None:
    """Set what differs; `setattr` without a name from outside."""
    if getattr(handle, name) != value:
        match name:
            case "value":
                handle.value = value
            case "label":
                handle.label = value
            case "color":
                handle.color = value
            case "disabled":
                handle.disabled = value
            case "content":
                handle.content = value
            case _:
                handle.options = value


def _note(gui: GuiApi, item: Note, widget: Widget) -> None:
    handle = gui.add_markdown(item.text)
    widget.bind(handle.remove, lambda new: _assign(handle, "content", new.text))  # type: ignore[union-attr]


def _markup(gui: GuiApi, item: Markup, widget: Widget) -> None:
    handle = gui.add_html(item.html)
    widget.bind(handle.remove, lambda new: _assign(handle, "content", new.html))  # type: ignore[union-attr]


def _button(gui: GuiApi, item: Button, widget: Widget) -> None:
    handle = gui.add_button(item.label, color=item.shade, hint=item.hint or None, disabled=item.disabled)
    handle.on_click(widget.listen(lambda now, _: None if now.disabled else now.on_press(), every=True))

    def show(new: Any) -> None:
        _assign(handle, "label", new.label)
        _assign(handle, "color", new.shade)
        _assign(handle, "disabled", new.disabled)

    widget.bind(handle.remove, show)


def _check(gui: GuiApi, item: Check, widget: Widget) -> None:
    handle = gui.add_checkbox(item.label, item.value, hint=item.hint or None)
    _input(handle, widget)


def _number(gui: GuiApi, item: Number, widget: Widget) -> None:
    handle = gui.add_number(item.label, float(item.value), step=item.step, min=item.least, max=item.most, hint=item.hint or None)
    _input(handle, widget)


def _slider(gui: GuiApi, item: Slider, widget: Widget) -> None:
    value = min(max(float(item.value), item.least), item.most)
    _input(gui.add_slider(item.label, item.least, item.most, item.step, value), widget)


def _vector(gui: GuiApi, item: Vector, widget: Widget) -> None:
    _input(gui.add_vector3(item.label, item.value, step=item.step, hint=item.hint or None), widget)


def _line(gui: GuiApi, item: Line, widget: Widget) -> None:
    _input(gui.add_text(item.label, item.value), widget)


def _choice(gui: GuiApi, item: Choice, widget: Widget) -> None:
    handle: Any = gui.add_dropdown(item.label, item.options, initial_value=item.value, hint=item.hint or None)
    handle.on_update(widget.listen(lambda now, value: now.on_change(value)))

    def show(new: Any) -> None:
        _assign(handle, "options", new.options)
        _assign(handle, "value", new.value)

    widget.bind(handle.remove, show)


def _entry(gui: GuiApi, item: Entry, widget: Widget) -> None:
    form = gui.add_form(None)
    with form:
        text = gui.add_text(item.label, item.value, multiline=item.lines)
        button = gui.add_button(item.button, color="gray")
    commit = widget.listen(lambda now, _: now.on_commit(text.value), every=True)
    button.on_click(commit)
    form.on_submit(commit)
    shown = [item.value]

    def show(new: Any) -> None:
        if new.value != shown[0]:  # what is being typed stays until something else is to be shown
            shown[0] = new.value
            _assign(text, "value", new.value)

    widget.bind(form.remove, show)


def _code(gui: GuiApi, item: Code, widget: Widget) -> None:
    field = CodeField(gui, item)
    field.apply.on_click(widget.listen(lambda now, _: now.on_commit(field.typed), every=True))
    field.discard.on_click(widget.listen(lambda now, _: field.take(now), every=True))
    widget.bind(field.remove, field.show)  # type: ignore[arg-type]


def _row(gui: GuiApi, item: Row, widget: Widget) -> None:
    handle = gui.add_button_group(item.label, tuple(item.presses))
    handle.on_click(widget.listen(lambda now, value: now.presses[value](), every=True))
    widget.bind(handle.remove, None)


def _progress(gui: GuiApi, item: Progress, widget: Widget) -> None:
    handle = gui.add_progress_bar(100.0 * item.share)
    widget.bind(handle.remove, lambda new: _assign(handle, "value", 100.0 * new.share))  # type: ignore[union-attr]


def _picture(gui: GuiApi, item: Picture, widget: Widget) -> None:
    handle = gui.add_image(item.pixels, label=item.label, format="jpeg", jpeg_quality=85)
    shown = [item.pixels]

    def show(new: Any) -> None:
        if new.pixels is not shown[0] and not np.array_equal(new.pixels, shown[0]):
            shown[0] = handle.image = new.pixels

    widget.bind(handle.remove, show)


def _upload(gui: GuiApi, item: Upload, widget: Widget) -> None:
    handle = gui.add_upload_button(item.label, hint=item.hint or None)
    handle.on_upload(widget.listen(lambda now, file: now.on_file(file.name, file.content), every=True))
    widget.bind(handle.remove, None)


def _input(handle: Any, widget: Widget) -> None:
    """Have an input tell its value, and take new ones."""
    handle.on_update(widget.listen(lambda now, value: now.on_change(value)))
    widget.bind(handle.remove, lambda new: _assign(handle, "value", new.value))  # type: ignore[union-attr]


_MAKERS: dict[type, Callable[[GuiApi, Any, Widget], None]] = {
    Note: _note,
    Markup: _markup,
    Button: _button,
    Check: _check,
    Number: _number,
    Slider: _slider,
    Vector: _vector,
    Line: _line,
    Choice: _choice,
    Entry: _entry,
    Code: _code,
    Row: _row,
    Progress: _progress,
    Picture: _picture,
    Upload: _upload,
}
