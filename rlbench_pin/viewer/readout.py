"""HTML of recordings: conditions over time, plots of the joints, values at one instant, failures, camera images."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator, Mapping, Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from rlbench_pin.spatial import FloatArray
from rlbench_pin.viewer.recording import Failure, Frame, Segment

COLORS = ("#e6194b", "#f58231", "#c9a600", "#3cb44b", "#17a2b8", "#4363d8", "#911eb4", "#808080")
"""Colours of the joints, in order."""
HOLDS, OPEN = "#2e9e44", "#9aa0a6"
"""Colours of a condition that holds and of a condition that does not."""
_NOW = "rlbench-pin-now"
"""CSS class of the cursors."""
_POINTS = 240
"""Maximum number of points of a line in a plot."""
_BOX = "position:relative;margin:2px 0 8px"
_TEXT = "padding:0 0.75em;font-size:0.85em;line-height:1.4"
_CURSOR = f'<div class="{_NOW}" style="position:absolute;top:0;bottom:0;width:2px;margin-left:-1px;background:#ff6d00"></div>'


def now_style(share: float) -> str:
    """Return the style element that places the cursors of all plots of a page at one instant, from 0 (first) to 1 (last)."""
    return f"<style>.{_NOW}{{left:{100.0 * share:.2f}%}}</style>"


def framed(content: str) -> str:
    """Return HTML with the margins of the other elements of a page."""
    return f'<div style="{_TEXT}">{content}</div>'


def conditions_html(texts: Sequence[str], met: Sequence[bool], history: Sequence[Sequence[bool]]) -> str:
    """Return each condition with a mark for the instant shown, and a bar of the time during which it holds; empty for none.

    Args:
        texts: The conditions as text.
        met: Whether each holds at the instant shown.
        history: Whether each holds, frame by frame.
    """
    columns = list(zip(*history, strict=True)) if history else [()] * len(texts)
    return framed("".join(_condition(*parts) for parts in zip(texts, met, columns, strict=True))) if texts else ""


def _condition(text: str, holds: bool, history: Sequence[bool]) -> str:
    """Return one condition with its mark and the bar of the time during which it holds."""
    mark, color, word = ("&#10003;", HOLDS, "holds") if holds else ("&#9675;", OPEN, "does not hold")
    bars = "".join(f'<rect x="{a}" y="0" width="{b - a}" height="1" fill="{HOLDS}"/>' for a, b in _intervals(history))
    strip = (
        f'<svg viewBox="0 0 {max(len(history) - 1, 1)} 1" preserveAspectRatio="none" width="100%" height="10" '
        f'style="display:block;background:{OPEN}40">{bars}</svg>'
    )
    return (
        f'<div class="condition" title="{word}"><b style="color:{color}">{mark}</b> {escape(text)}'
        f'<div style="{_BOX}">{strip}{_CURSOR}</div></div>'
    )


def _intervals(history: Sequence[bool]) -> Iterator[tuple[int, int]]:
    """Yield the first and last frame of each interval in which a condition holds; each interval is at least one frame wide."""
    last, begins = max(len(history) - 1, 1), -1
    for number, holds in enumerate((*history, False)):
        if holds and begins < 0:
            begins = min(number, last - 1)
        elif not holds and begins >= 0:
            yield begins, max(min(number, last), begins + 1)
            begins = -1


def plot_html(title: str, unit: str, values: FloatArray) -> str:
    """Return a plot of one line for each joint over time.

    Args:
        title: Title of the plot.
        unit: Unit of the values.
        values: Values (frames, joints).
    """
    head = f"<div><b>{escape(title)}</b> [{escape(unit)}]</div>"
    if len(values) < 2:
        return framed(head)
    low, high = float(values.min()), float(values.max())
    margin = 0.05 * (high - low) or 1.0
    low, high = low - margin, high + margin
    rows = np.unique(np.linspace(0, len(values) - 1, min(len(values), _POINTS)).round().astype(int))
    places = 100.0 * (high - values) / (high - low)
    lines = "".join(
        _line(rows, 1000.0 * rows / (len(values) - 1), places[:, joint], COLORS[joint % len(COLORS)])
        for joint in range(values.shape[1])
    )
    zero = 100.0 * high / (high - low)
    axis = f'<line x1="0" x2="1000" y1="{zero:.1f}" y2="{zero:.1f}" {_stroke("#9aa0a6", 1)}/>' if 0.0 < zero < 100.0 else ""
    size = 'viewBox="0 0 1000 100" preserveAspectRatio="none" width="100%" height="90" style="display:block"'
    drawn = f"<svg {size}>{axis}{lines}</svg>"
    ticks = _tick(high - margin, "top:0") + _tick(low + margin, "bottom:0")
    return framed(f'{head}<div style="{_BOX};border:1px solid #9aa0a680">{drawn}{ticks}{_CURSOR}</div>')


def _line(rows: NDArray[np.int_], x: FloatArray, y: FloatArray, color: str) -> str:
    """Return an SVG line through the points with coordinates `x` (k,) and `y[rows]` (k,)."""
    points = " ".join(f"{a:.0f},{b:.1f}" for a, b in zip(x, y[rows], strict=True))
    return f'<polyline points="{points}" fill="none" {_stroke(color, 1.5)}/>'


def _stroke(color: str, width: float) -> str:
    return f'stroke="{color}" stroke-width="{width}" vector-effect="non-scaling-stroke"'


def _tick(value: float, place: str) -> str:
    """Return the label of an axis at a CSS position."""
    return f'<span style="position:absolute;left:2px;{place};font-size:10px;opacity:0.8">{value:.3g}</span>'


def joints_html(frame: Frame) -> str:
    """Return the values of the joints at one instant, each joint in the colour of its plots."""
    rows = zip(COLORS, frame.arm, frame.velocities, frame.torques, strict=False)
    cells = "".join(
        f'<tr style="text-align:right"><td style="color:{color}"><b>{number}</b></td>'
        f"<td>{q:.3f}</td><td>{v:.3f}</td><td>{tau:.2f}</td></tr>"
        for number, (color, q, v, tau) in enumerate(rows, start=1)
    )
    opening = " + ".join(f"{1000.0 * finger:.1f}" for finger in frame.fingers)
    head = '<tr style="text-align:right"><th>joint</th><th>rad</th><th>rad/s</th><th>Nm</th></tr>'
    return framed(f'<table style="width:100%;border-collapse:collapse">{head}{cells}</table>fingers {opening} mm')


def instant_html(frame: Frame, index: int, count: int, segment: Segment | None) -> str:
    """Return time, number and segment of the frame that is shown.

    Args:
        frame: The frame that is shown.
        index: Index of the frame.
        count: Number of frames.
        segment: Segment of the frame; None before the first.
    """
    way = "" if segment is None else f" &middot; to {escape(segment.waypoint)}"
    method = f" ({escape(segment.method)})" if segment is not None and segment.method else ""
    goal = f' &middot; <b style="color:{HOLDS}">goal reached</b>' if frame.success else ""
    words = f"{frame.time:.2f} s &middot; frame {index + 1} of {count}{way}{method}{goal}"
    return framed(f'<div class="instant">{words}</div>')


def failure_html(failure: Failure) -> str:
    """Return the cause of a failure, with the links that are in contact."""
    way = f" on the way to {escape(failure.waypoint)}" if failure.waypoint else ""
    pairs = "".join(f"<li>{escape(first)} touches {escape(second)}</li>" for first, second in failure.pairs)
    touching = f"<div>Drawn red at the last instant:</div><ul style='margin:0'>{pairs}</ul>" if pairs else ""
    nearest = "<div>The nearest pose that the tip reaches is drawn amber at the last instant.</div>"
    return framed(
        f'<div class="failure" style="border-left:3px solid #d93025;padding-left:8px"><b>Failed{way}</b>'
        f"<div>{escape(failure.cause)}</div>{touching}{nearest if failure.nearest is not None else ''}</div>"
    )


def images_html(images: Mapping[str, NDArray[np.uint8]]) -> str:
    """Return images (h, w, 3) in a grid of two columns, each with its name as the caption."""
    cells = "".join(
        f'<figure style="margin:0"><img alt="{name}" style="width:100%;display:block" src="{_data_url(image)}">'
        f'<figcaption style="font-size:0.75em">{name}</figcaption></figure>'
        for name, image in images.items()
    )
    return f'<div style="display:grid;grid-template-columns:1fr 1fr;gap:4px;padding:0 0.75em">{cells}</div>'


def _data_url(image: NDArray[np.uint8]) -> str:
    """Return an image (h, w, 3) as the data URL of a JPEG file."""
    file = io.BytesIO()
    Image.fromarray(image).save(file, "JPEG", quality=85)
    return "data:image/jpeg;base64," + base64.b64encode(file.getvalue()).decode()
