"""Recordings as HTML: strips, plots, numbers and failures, with nothing in them that the names of a scene could break."""

from __future__ import annotations

import re

import numpy as np
import pytest

from rlbench_pin.viewer.readout import conditions_html, failure_html, instant_html, joints_html, now_style, plot_html
from rlbench_pin.viewer.recording import Failure, Segment
from tests.viewer.frames import frame


@pytest.mark.parametrize(
    ("history", "bars"),
    [
        ((False, False, True, True, False), [(2.0, 2.0)]),
        ((True, True, True), [(0.0, 2.0)]),
        ((False, False, True), [(1.0, 1.0)]),
        ((True, False, False, True), [(0.0, 1.0), (2.0, 1.0)]),
        ((False,), []),
        ((), []),
    ],
)
def test_a_strip_shows_when_a_condition_holds(history: tuple[bool, ...], bars: list[tuple[float, float]]) -> None:
    """One bar for each stretch: from where it begins to hold to where it ends, never of no width."""
    html = conditions_html(["cube inside goal"], [False], [[holds] for holds in history])
    drawn = [(float(x), float(w)) for x, w in re.findall(r'<rect x="([\d.]+)" y="0" width="([\d.]+)"', html)]
    assert drawn == bars


def test_marks_say_what_holds_at_the_instant_shown() -> None:
    """Each condition has its own mark."""
    html = conditions_html(["one", "two"], [True, False], [[True, False]] * 3)
    assert re.findall(r'title="([a-z ]+)"', html) == ["holds", "does not hold"]


def test_names_of_a_scene_are_no_markup() -> None:
    """Whatever a task calls its elements, the page shows it as text."""
    name = "<img src=x onerror=alert(1)>"
    texts = [
        conditions_html([name], [True], [[True]]),
        failure_html(Failure(name, name, ((name, name),))),
        instant_html(frame(0), 0, 1, Segment(name, 0, name)),
        plot_html(name, name, np.zeros((3, 7))),
    ]
    assert all("<img" not in text for text in texts)
    assert all("&lt;img" in text for text in texts)


def test_a_plot_has_a_line_for_each_joint_and_its_limits() -> None:
    """Long recordings are thinned out; the first and the last frame stay."""
    values = np.outer(np.linspace(-1.0, 1.0, 1001), np.arange(1.0, 8.0))
    html = plot_html("Positions", "rad", values)
    lines = re.findall(r'<polyline points="([^"]+)"', html)
    assert len(lines) == 7
    assert len(lines[0].split()) <= 240
    assert lines[0].startswith("0,")
    assert lines[0].split()[-1].startswith("1000,")
    assert ">7<" in html
    assert ">-7<" in html


def test_a_joint_that_rests_is_plotted() -> None:
    """No range is no error; one frame alone has no plot."""
    assert plot_html("Torques", "Nm", np.zeros((5, 7))).count("<polyline") == 7
    assert "<polyline" not in plot_html("Torques", "Nm", np.zeros((1, 7)))


def test_numbers_and_instant() -> None:
    """The joints in units, the frame counted from one, and the goal where it is reached."""
    assert "fingers 40.0 + 40.0 mm" in joints_html(frame(3))
    assert "0.300" in joints_html(frame(3))
    said = instant_html(frame(3, (True,)), 3, 10, Segment("waypoint1", 2, "straight"))
    assert "0.15 s &middot; frame 4 of 10 &middot; to waypoint1 (straight)" in said
    assert "goal reached" in said
    assert "goal reached" not in instant_html(frame(3), 3, 10, None)


def test_cursors_stand_at_one_place() -> None:
    """All strips and plots share one style."""
    assert now_style(0.25) == "<style>.rlbench-pin-now{left:25.00%}</style>"
