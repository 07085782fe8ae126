"""A line with a coloured dot before it: good, doubtful, bad, at work, not known."""

from __future__ import annotations

from html import escape
from typing import Literal

from rlbench_pin.builder.view.widgets.items import Markup

Sign = Literal["good", "doubtful", "bad", "busy", "unknown"]
"""What the dot says."""
_COLORS: dict[Sign, str] = {"good": "#2b9348", "doubtful": "#e08a00", "bad": "#d6302b", "busy": "#2a6fdb", "unknown": "#9aa0a6"}

NOTHING = Markup("")
"""Stands where a line may be, so that what follows keeps its place."""


def sign(kind: Sign, text: str, strong: str = "") -> Markup:
    """Return a line with a dot.

    Args:
        kind: What the dot says.
        text: What the line says.
        strong: What stands before it in bold.
    """
    bold = f"<b>{escape(strong)}</b> " if strong else ""
    dot = f'<span style="color:{_COLORS[kind]}; font-size:15px">&#9679;</span>'
    return Markup(f'<div style="padding:2px 8px; font-size:13px; line-height:1.4">{dot} {bold}{escape(text)}</div>')
