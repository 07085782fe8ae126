"""Panels described by plain records."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
from rlbench_pin.builder.view.widgets.panel import Panel
from rlbench_pin.front_door import front_door

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
    "Panel",
    "Picture",
    "Progress",
    "Row",
    "Slider",
    "Upload",
    "Vector",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
