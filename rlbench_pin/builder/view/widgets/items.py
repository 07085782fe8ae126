"""What a panel consists of, as plain records; it is described anew at every change, and only what differs is drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Vector3 = tuple[float, float, float]
Shade = Literal["blue", "gray", "green", "red", "orange", "dark", "teal"]
"""Colour of a button."""


@dataclass(frozen=True)
class Note:
    """Text in Markdown."""

    text: str
    """What it says."""


@dataclass(frozen=True)
class Markup:
    """Text in HTML; whoever makes it escapes what others wrote."""

    html: str
    """What it says."""


@dataclass(frozen=True)
class Button:
    """Something to press."""

    label: str
    """What stands on it."""
    on_press: Callable[[], None]
    """What it does."""
    shade: Shade = "gray"
    """Its colour."""
    hint: str = ""
    """What is shown when the pointer rests on it."""
    disabled: bool = False
    """Whether it can be pressed."""
    key: str = ""
    """Tells it from others whose label changes; the label when empty."""


@dataclass(frozen=True)
class Check:
    """A switch."""

    label: str
    """What it is about."""
    value: bool
    """Whether it is on."""
    on_change: Callable[[bool], None]
    """Called with the new value."""
    hint: str = ""
    """What is shown when the pointer rests on it."""


@dataclass(frozen=True)
class Number:
    """A number to type."""

    label: str
    """What it is about, with its unit."""
    value: float
    """What it is."""
    on_change: Callable[[float], None]
    """Called with the new value."""
    step: float = 0.01
    """By how much its arrows change it."""
    least: float | None = None
    """Smallest value."""
    most: float | None = None
    """Largest value."""
    hint: str = ""
    """What is shown when the pointer rests on it."""


@dataclass(frozen=True)
class Slider:
    """A number to drag."""

    label: str
    """What it is about, with its unit."""
    value: float
    """What it is."""
    on_change: Callable[[float], None]
    """Called with the new value."""
    least: float
    """Smallest value."""
    most: float
    """Largest value."""
    step: float = 0.001
    """Distance of its values."""


@dataclass(frozen=True)
class Vector:
    """Three numbers to type."""

    label: str
    """What they are, with their unit."""
    value: Vector3
    """What they are now."""
    on_change: Callable[[Vector3], None]
    """Called with the new values."""
    step: float = 0.01
    """By how much the arrows change one."""
    hint: str = ""
    """What is shown when the pointer rests on it."""


@dataclass(frozen=True)
class Choice:
    """One of several."""

    label: str
    """What is chosen."""
    value: str
    """What is chosen now; one of the options."""
    options: tuple[str, ...]
    """What there is."""
    on_change: Callable[[str], None]
    """Called with the new choice."""
    hint: str = ""
    """What is shown when the pointer rests on it."""


@dataclass(frozen=True)
class Line:
    """A text of one line that counts at every letter."""

    label: str
    """What it is about."""
    value: str
    """What it says."""
    on_change: Callable[[str], None]
    """Called with the new text."""


@dataclass(frozen=True)
class Entry:
    """A text that counts when it is finished: with its button, or with Enter."""

    label: str
    """What it is about."""
    value: str
    """What it says."""
    on_commit: Callable[[str], None]
    """Called with the finished text."""
    button: str
    """What stands on its button."""
    lines: bool = False
    """Whether it has several lines."""


@dataclass(frozen=True)
class Code:
    """A file to edit, tall and with numbers of its lines; it counts when it is applied."""

    label: str
    """Name of the file."""
    value: str
    """What it says."""
    on_commit: Callable[[str], None]
    """Called with the text that somebody has typed."""
    on_typing: Callable[[bool], None]
    """Called with whether something is typed that is not applied, when that changes; from any thread."""
    marked: tuple[int, ...] = ()
    """Lines, from 1, in which something is wrong."""


@dataclass(frozen=True)
class Row:
    """Buttons beside one another."""

    label: str
    """What they are about."""
    presses: Mapping[str, Callable[[], None]]
    """What stands on each, and what it does."""


@dataclass(frozen=True)
class Progress:
    """How much is done."""

    share: float
    """From 0 to 1."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture."""

    label: str
    """What it shows."""
    pixels: NDArray[np.uint8]
    """(height, width, 3)."""


@dataclass(frozen=True)
class Upload:
    """A button that takes a file."""

    label: str
    """What stands on it."""
    on_file: Callable[[str, bytes], None]
    """Called with the name and the content of the file."""
    hint: str = ""
    """What is shown when the pointer rests on it."""


@dataclass(frozen=True)
class Fold:
    """Items below a title that folds them away."""

    label: str
    """The title."""
    items: Sequence[Item] = field(default=())
    """What is below it."""
    is_open: bool = True
    """Whether it is open at first."""


Item = (
    Note
    | Markup
    | Button
    | Row
    | Check
    | Number
    | Slider
    | Vector
    | Choice
    | Line
    | Entry
    | Code
    | Progress
    | Picture
    | Upload
    | Fold
)
"""Whatever a panel has."""

__all__ = [
    "Button",
    "Check",
    "Choice",
    "Code",
    "Entry",
    "Fold",
    "Item",
    "Line",
    "Markup",
    "Note",
    "Number",
    "Picture",
    "Progress",
    "Row",
    "Shade",
    "Slider",
    "Upload",
    "Vector",
    "Vector3",
]
