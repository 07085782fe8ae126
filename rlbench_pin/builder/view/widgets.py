"""Panels of viser controls, described again at each change: an unchanged control keeps its handle."""

from __future__ import annotations

import contextlib
import itertools
import threading
from collections.abc import Callable, Collection, Iterator, Mapping
from html import escape
from typing import Any, Literal, Protocol
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray
from viser import GuiApi, GuiEvent

Vector3 = tuple[float, float, float]
Color = Literal["blue", "gray", "green", "red", "orange", "dark", "teal"]
"""Colour of a button."""
Sign = Literal["good", "doubtful", "bad", "busy", "unknown"]
"""Meaning of the dot before a line."""
Post = Callable[[Callable[[], None], str], None]
"""Runs a function in the thread of edits; of several waiting ones of the same non-empty kind, only the last runs."""
_SIGN_COLORS: dict[Sign, str] = {
    "good": "#2b9348", "doubtful": "#e08a00", "bad": "#d6302b", "busy": "#2a6fdb", "unknown": "#9aa0a6",
}  # fmt: skip

_GRID = """<div class="two-columns"></div><style>
div:has(> div > .two-columns) { display: grid; grid-template-columns: minmax(0, 1fr) minmax(0, 1fr); align-items: end }
div:has(> .two-columns) { display: none }
div:has(> div > .two-columns) .mantine-Button-root { padding: 0 4px; font-size: 12px }
</style>"""
"""Viser puts the elements of a panel below one another."""


class Container(Protocol):
    """A folder, tab or panel of viser."""

    def __enter__(self) -> object: ...

    def __exit__(self, *args: object) -> object: ...


class Control:
    """One control of a panel.

    Attributes:
        key: Kind, label and whatever else cannot change while the control exists.
        handle: Handle of viser.
        values: What the control shows.
        callback: Receives the values of events.
        children: Controls of a folder.
    """

    def __init__(self, key: tuple[object, ...], values: tuple[object, ...], post: Post) -> None:
        self.key, self.values, self._post = key, values, post
        self.handle: Any = None
        self.callback: Callable[[Any], None] = _ignore
        self.children: Panel | None = None
        self._lock = threading.Lock()
        self._heard, self._handled, self._touched = 0, 0, False

    @property
    def label(self) -> str:
        """The label; empty for controls without one."""
        return str(self.key[1]) if len(self.key) > 1 else ""

    def listen(self, subscribe: Callable[[Any], object], read: Callable[[], object] | None = None, every: bool = False) -> None:
        """Pass events of browsers to the callback, in the thread of edits.

        Args:
            subscribe: Method of a handle that takes a function.
            read: Returns the value to pass, when the callback runs; None passes the value of the event.
            every: Whether each event counts, instead of the last of those that wait.
        """

        async def heard(event: GuiEvent[Any]) -> None:  # in the event loop, which keeps the order of values
            if event.client_id is None:  # the program has set the value
                return
            value = getattr(event.target, "value", None)
            with self._lock:
                self._heard += 1
                number = self._heard

            def handle() -> None:
                with self._lock:
                    self._handled, self._touched = number, True
                    callback = self.callback
                callback(value if read is None else read())

            self._post(handle, "" if every else f"control {id(self)}")

        subscribe(heard)

    def show(
        self, values: tuple[object, ...], callback: Callable[[Any], None], assign: Callable[[], None], keeps_input: bool = False
    ) -> None:
        """Show new values, unless an event of the control waits.

        Args:
            values: What to show.
            callback: Receives the values of events from now on.
            assign: Sets the values of the handle.
            keeps_input: Whether input stays until other values are shown; otherwise the values replace it.
        """
        with self._lock:
            self.callback = callback
            if self._heard > self._handled:
                return
            changed = values != self.values or (self._touched and not keeps_input)
            self.values, self._touched = values, False
        if changed:
            assign()


def _ignore(value: object) -> None:
    pass


class Panel:
    """Controls below one another.

    Args:
        gui: The page.
        container: Where the controls are.
        post: Runs functions in the thread of edits.

    Attributes:
        controls: The current controls.
    """

    def __init__(self, gui: GuiApi, container: Container, post: Post) -> None:
        self._gui, self._container, self._post = gui, container, post
        self.controls: list[Control] = []
        self._next = 0

    @contextlib.contextmanager
    def update(self) -> Iterator[Panel]:
        """Describe all controls, in order. From the first that differs from the current ones on, they are made again."""
        self._next = 0
        with self._container:
            yield self
        self._remove_from(self._next)

    def _remove_from(self, number: int) -> None:
        for control in reversed(self.controls[number:]):
            control.handle.remove()
        del self.controls[number:]

    def _control(self, key: tuple[object, ...], values: tuple[object, ...], make: Callable[[Control], Any]) -> Control:
        """Return the next control, which is made when the current one has another key."""
        if self._next == len(self.controls) or self.controls[self._next].key != key:
            self._remove_from(self._next)
            control = Control(key, values, self._post)
            control.handle = make(control)
            self.controls.append(control)
        self._next += 1
        return self.controls[self._next - 1]

    # Output ----------------------------------------------------------------------------------------------------------

    def note(self, text: str) -> None:
        """Show Markdown text."""
        control = self._control(("note",), (text,), lambda _: self._gui.add_markdown(text))

        def assign() -> None:
            control.handle.content = text

        control.show((text,), _ignore, assign)

    def html(self, html: str) -> None:
        """Show HTML; the caller escapes foreign text."""
        control = self._control(("html",), (html,), lambda _: self._gui.add_html(html))

        def assign() -> None:
            control.handle.content = html

        control.show((html,), _ignore, assign)

    def sign(self, sign: Sign, text: str, bold: str = "") -> None:
        """Show a line with a coloured dot; the bold text comes first."""
        strong = f"<b>{escape(bold)}</b> " if bold else ""
        dot = f'<span style="color:{_SIGN_COLORS[sign]}; font-size:15px">&#9679;</span>'
        self.html(f'<div style="padding:2px 8px; font-size:13px; line-height:1.4">{dot} {strong}{escape(text)}</div>')

    def progress(self, share: float) -> None:
        """Show a progress bar, from 0 to 1."""
        control = self._control(("progress",), (share,), lambda _: self._gui.add_progress_bar(100.0 * share))

        def assign() -> None:
            control.handle.value = 100.0 * share

        control.show((share,), _ignore, assign)

    def image(self, label: str, pixels: NDArray[np.uint8]) -> None:
        """Show an image (height, width, 3)."""
        key, values = ("image", label), (pixels.tobytes(),)
        control = self._control(key, values, lambda _: self._gui.add_image(pixels, label=label, format="jpeg", jpeg_quality=85))

        def assign() -> None:
            control.handle.image = pixels

        control.show(values, _ignore, assign)

    # Buttons ---------------------------------------------------------------------------------------------------------

    def button(
        self, label: str, press: Callable[[], None], color: Color = "gray", hint: str = "", disabled: bool = False, key: str = ""
    ) -> None:
        """Show a button. With a key, its label may change while it exists."""
        values = (label, color, disabled)

        def make(control: Control) -> Any:
            handle = self._gui.add_button(label, color=color, hint=hint or None, disabled=disabled)
            control.listen(handle.on_click, every=True)
            return handle

        def assign() -> None:
            handle.label, handle.color, handle.disabled = values

        control = self._control(("button", key or label), values, make)
        handle = control.handle
        control.show(values, _ignore if disabled else lambda _: press(), assign)

    def button_row(self, label: str, presses: Mapping[str, Callable[[], None]]) -> None:
        """Show buttons beside one another, by their labels."""

        def make(control: Control) -> Any:
            handle = self._gui.add_button_group(label, tuple(presses))
            control.listen(handle.on_click, every=True)
            return handle

        control = self._control(("button row", label, *presses), (), make)
        control.show((), lambda word: presses[word](), lambda: None)

    def upload(self, label: str, receive: Callable[[str, bytes], None]) -> None:
        """Show a button that takes a file; `receive` gets its name and content."""

        def make(control: Control) -> Any:
            handle = self._gui.add_upload_button(label)
            control.listen(handle.on_upload, every=True)
            return handle

        control = self._control(("upload", label), (), make)
        control.show((), lambda file: receive(file.name, file.content), lambda: None)

    # Input -----------------------------------------------------------------------------------------------------------

    def _input(self, key: tuple[object, ...], value: object, change: Callable[[Any], None], add: Callable[[], Any]) -> None:
        """Show an input whose handle has a `value`."""

        def make(control: Control) -> Any:
            handle = add()
            control.listen(handle.on_update)
            return handle

        def assign() -> None:
            control.handle.value = value

        control = self._control(key, (value,), make)
        control.show((value,), change, assign)

    def checkbox(self, label: str, value: bool, change: Callable[[bool], None], hint: str = "") -> None:
        """Show a switch."""
        key = ("checkbox", label, hint)
        self._input(key, value, change, lambda: self._gui.add_checkbox(label, value, hint=hint or None))

    def number(
        self,
        label: str,
        value: float,
        change: Callable[[float], None],
        step: float = 0.01,
        low: float | None = None,
        high: float | None = None,
        hint: str = "",
    ) -> None:
        """Show a field for a number."""

        def add() -> Any:
            return self._gui.add_number(label, float(value), step=step, min=low, max=high, hint=hint or None)

        self._input(("number", label, step, low, high, hint), value, change, add)

    def slider(self, label: str, value: float, change: Callable[[float], None], low: float, high: float) -> None:
        """Show a slider with steps of 0.001."""
        inside = min(max(float(value), low), high)
        key = ("slider", label, low, high)
        self._input(key, value, change, lambda: self._gui.add_slider(label, low, high, 0.001, inside))

    def vector(self, label: str, value: Vector3, change: Callable[[Vector3], None], step: float = 0.01, hint: str = "") -> None:
        """Show fields for three numbers."""
        key = ("vector", label, step, hint)
        self._input(key, value, change, lambda: self._gui.add_vector3(label, value, step=step, hint=hint or None))

    def text(self, label: str, value: str, change: Callable[[str], None]) -> None:
        """Show a field for one line; every letter is a change."""
        self._input(("text", label), value, change, lambda: self._gui.add_text(label, value))

    def dropdown(self, label: str, value: str, options: tuple[str, ...], change: Callable[[str], None], hint: str = "") -> None:
        """Show a choice of one of several options."""

        def make(control: Control) -> Any:
            handle: Any = self._gui.add_dropdown(label, options, initial_value=value, hint=hint or None)
            control.listen(handle.on_update)
            return handle

        def assign() -> None:
            if tuple(control.handle.options) != options:
                control.handle.options = options
            control.handle.value = value

        control = self._control(("dropdown", label, hint), (value, options), make)
        control.show((value, options), change, assign)

    def entry(self, label: str, value: str, commit: Callable[[str], None], button: str, multiline: bool = False) -> None:
        """Show a text that is committed with a button or Enter."""

        def make(control: Control) -> Any:
            form = self._gui.add_form(None)
            with form:
                field = self._gui.add_text(label, value, multiline=multiline)
                press = self._gui.add_button(button, color="gray")
            control.listen(press.on_click, lambda: field.value, every=True)
            control.listen(form.on_submit, lambda: field.value, every=True)
            return _Entry(form, field)

        def assign() -> None:
            control.handle.text.value = value

        control = self._control(("entry", label, button, multiline), (value,), make)
        control.show((value,), commit, assign, keeps_input=True)

    def code(
        self,
        label: str,
        value: str,
        commit: Callable[[str], None],
        typing: Callable[[bool], None],
        marked: tuple[int, ...] = (),
    ) -> None:
        """Show a file to edit; see `CodeField`.

        Args:
            label: Name of the file.
            value: Content of the file.
            commit: Receives the typed text.
            typing: Called with whether text is typed and not applied, when that changes; from any thread.
            marked: Lines with problems, from 1.
        """

        def make(control: Control) -> CodeField:
            field = CodeField(self._gui, label, value, typing, marked)
            control.listen(field.apply.on_click, lambda: field.typed, every=True)

            async def discard(event: GuiEvent[Any]) -> None:
                self._post(field.discard_typed, "")

            field.discard.on_click(discard)
            return field

        control = self._control(("code", label), (value, marked), make)
        field: CodeField = control.handle
        control.show((value, marked), commit, lambda: field.show(value, marked))

    # Nesting ---------------------------------------------------------------------------------------------------------

    @contextlib.contextmanager
    def folder(self, label: str, is_open: bool = True) -> Iterator[Panel]:
        """Show a folder, and describe its controls."""
        control = self._control(("folder", label), (), lambda _: self._gui.add_folder(label, expand_by_default=is_open))
        if control.children is None:
            control.children = Panel(self._gui, control.handle, self._post)
        with control.children.update() as children:
            yield children

    @contextlib.contextmanager
    def grid(self, label: str) -> Iterator[Panel]:
        """Show a folder whose controls are in two columns, and describe them."""
        with self.folder(label) as folder:
            folder.html(_GRID)
            yield folder


class _Entry:
    """A form with one text."""

    def __init__(self, form: Any, text: Any) -> None:
        self.remove, self.text = form.remove, text


# Files ---------------------------------------------------------------------------------------------------------------

LINE = 17
"""Height of a line of a file [px]."""
_GUTTER = 40
_NUMBERS = itertools.count()
_TYPED = "Typed, but not applied: it is not in the scene, and Save does not include it."
_OVERTAKEN = "The file has changed while you typed. Apply replaces it by your text (Undo restores it); Discard shows the file."
_STYLE = """<style>
form:has(.{name}) label {{ display: none }}
form:has(.{name}) div:has(> * > label) {{ width: 0 !important; padding: 0 !important }}
form:has(.{name}) textarea {{
  min-height: max(240px, calc(100vh - 300px)) !important; max-height: none !important; resize: vertical;
  font: 12px/{line}px ui-monospace, monospace !important; white-space: pre !important; overflow: auto !important;
  tab-size: 4; padding: 0 6px 0 {pad}px !important;
  background: url("{image}") 0 0 no-repeat local !important }}
</style><div class="{name}"></div>"""
"""Viser's text fields have six lines. A background image that scrolls with the text shows the line numbers."""


class CodeField:
    """A form with the text of a file, its line numbers, `Apply` and `Discard`. Typed text stays until one of them is pressed.

    Attributes:
        apply: The button that applies the typed text.
        discard: The button that shows the file again.
    """

    def __init__(self, gui: GuiApi, label: str, value: str, typing: Callable[[bool], None], marked: tuple[int, ...] = ()) -> None:
        self._file, self._shown, self._marked, self._typing = value, value, marked, typing
        self._name = f"code-{next(_NUMBERS)}"
        self._form = gui.add_form(None)
        with self._form:
            self._style = gui.add_html("")
            self._text = gui.add_text(label, value, multiline=True)
            self._note = gui.add_html("", visible=False)
            self.apply = gui.add_button(f"Apply {label}", color="gray")
            self.discard = gui.add_button(f"Discard the typed text in {label}", color="gray", visible=False)

        async def heard(event: GuiEvent[Any]) -> None:
            self._draw()

        self._text.on_update(heard)
        self.remove = self._form.remove
        self._draw()

    @property
    def typed(self) -> str:
        """The text in the field."""
        return self._text.value

    @property
    def warning(self) -> str:
        """Warning about typed text that is not applied; empty when there is none."""
        return self._note.content if self._note.visible else ""

    def show(self, value: str, marked: tuple[int, ...] = ()) -> None:
        """Show the file; typed text that is not applied stays, with a warning."""
        is_typed = self.typed not in (self._shown, value)
        self._file, self._marked = value, marked
        if is_typed:
            self._draw()
        else:
            self.discard_typed()

    def discard_typed(self) -> None:
        """Show the file in place of the typed text."""
        self._shown = self._file
        self._text.value = self._file
        self._draw()

    def _draw(self) -> None:
        style = line_numbers(self._name, self.typed.count("\n") + 1, self._marked)
        if style != self._style.content:
            self._style.content = style
        is_typed = self.typed != self._file
        if is_typed != self.discard.visible:
            self.discard.visible = self._note.visible = is_typed
            self._typing(is_typed)
            self.apply.color = "blue" if is_typed else "gray"
        words = _TYPED if self._file == self._shown else _OVERTAKEN
        if is_typed and words not in self._note.content:
            self._note.content = f'<div style="padding:2px 10px; font-size:13px; color:#b35900">{escape(words)}</div>'


def line_numbers(name: str, lines: int, marked: Collection[int]) -> str:
    """Return HTML that makes the text of a form tall, and numbers its lines.

    Args:
        name: Class of the form, unique in the page.
        lines: Number of lines.
        marked: Lines shown in red.
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
    image = f"<svg xmlns='http://www.w3.org/2000/svg' width='3000' height='{height}' {font}>{''.join(rows)}</svg>"
    return _STYLE.format(name=name, line=LINE, pad=_GUTTER, image=f"data:image/svg+xml,{quote(image)}")


# Order of events in the browser --------------------------------------------------------------------------------------

PAUSE = 70
"""Pause between two events [ms]. Viser's page sends only the last of the events within 50 ms."""
_DELAY_PRESSES = """
if (!window.pressesWait) {
  window.pressesWait = true;
  const buttons = 'button, [role=option], input[type=checkbox]', sliders = '[role=slider], .mantine-Slider-root';
  const replayed = new WeakSet();
  let free = 0;
  const wait = () => { free = Math.max(free, performance.now() + PAUSE); };
  const slide = (event) => { if (event.target.closest?.(sliders)) wait(); };
  document.addEventListener('input', wait, true);
  for (const kind of ['pointermove', 'pointerup', 'keydown']) document.addEventListener(kind, slide, true);
  document.addEventListener('click', (event) => {
    const pressed = event.target.closest?.(buttons);
    if (!pressed) return;
    if (replayed.delete(pressed)) return;
    const now = performance.now();
    if (now >= free) { wait(); return; }
    event.preventDefault();
    event.stopImmediatePropagation();
    const label = pressed.innerText;
    setTimeout(() => {
      const same = pressed.isConnected ? [pressed] : [...document.querySelectorAll(buttons)].filter((b) => b.innerText === label);
      if (same.length !== 1) return;
      replayed.add(same[0]);
      same[0].click();
      replayed.delete(same[0]);
    }, free - now);
    free += PAUSE;
  }, true);
}
"""
"""Enter in a field presses the hidden button of its form, which waits as well. A button that is made again while a press waits is
found by its label, if the label is unique."""


def delay_presses(gui: GuiApi) -> None:
    """Delay a press shortly after another event, which the page would send in place of that event."""
    script = escape(_DELAY_PRESSES.replace("PAUSE", str(PAUSE)))
    gui.add_html(f'<img src="data:," alt="" style="display:none" onerror="{script}">')  # HTML runs scripts as event handlers only
