"""A time line plays, steps, jumps from leg to leg, and waits for what is still to come."""

from __future__ import annotations

import pytest

from rlbench_pin.builder.playback.timeline import Timeline


@pytest.fixture
def timeline() -> Timeline:
    """Eleven frames in half a second, legs that begin at 0, 4 and 8."""
    made = Timeline()
    made.load([0.05 * i for i in range(11)], [0, 4, 8])
    return made


def test_time_goes_on_at_the_chosen_pace_and_stops_at_the_end(timeline: Timeline) -> None:
    """At 2x a tenth of a second shows four frames more; rests of time are not lost."""
    timeline.pace(2.0)
    timeline.play()
    assert timeline.advance(0.1)
    assert timeline.index == 4
    assert [timeline.advance(0.01) for _ in range(5)] == [False, False, True, False, True]
    assert timeline.index == 6
    timeline.advance(10.0)
    assert (timeline.index, timeline.playing, timeline.share) == (10, False, 1.0)


def test_playing_at_the_end_begins_anew(timeline: Timeline) -> None:
    """Who presses play at the end sees all again; at rest nothing moves."""
    assert not timeline.advance(1.0)
    timeline.seek(99)
    assert timeline.index == 10
    timeline.play()
    assert (timeline.index, timeline.playing) == (0, True)
    timeline.pause()
    assert not timeline.advance(1.0)


def test_steps_and_legs(timeline: Timeline) -> None:
    """Steps stay within the recording; jumps go to where legs begin, then to the ends."""
    timeline.step(-1)
    assert timeline.index == 0
    where = []
    for _ in range(4):
        timeline.jump(1)
        where.append(timeline.index)
    assert where == [4, 8, 10, 10]
    timeline.step(-5)
    assert (timeline.index, timeline.leg) == (5, 1)
    timeline.jump(-1)
    timeline.jump(-1)
    timeline.jump(-1)
    assert (timeline.index, timeline.leg) == (0, 0)


def test_a_recording_under_way_is_waited_for() -> None:
    """At the newest frame time waits; when all is there it ends. What is shown stays when the whole recording is taken over."""
    timeline = Timeline()
    timeline.begin(follow=False)
    assert not timeline.advance(1.0)
    for i in range(3):
        timeline.add(0.05 * i)
    assert timeline.advance(5.0)
    assert (timeline.index, timeline.playing) == (2, True)
    timeline.add(0.15)
    assert not timeline.advance(0.01)
    assert timeline.advance(0.04)
    timeline.complete([0.0, 0.05, 0.1, 0.15, 0.2], [0])
    assert (timeline.index, timeline.playing) == (3, True)
    timeline.advance(1.0)
    assert (timeline.index, timeline.playing) == (4, False)


def test_the_newest_frame_is_followed_until_somebody_looks_elsewhere() -> None:
    """An evaluation is shown as it is played; who steps back stays there."""
    timeline = Timeline()
    timeline.begin(follow=True)
    for i in range(5):
        timeline.add(0.05 * i)
    assert timeline.index == 4
    timeline.step(-2)
    timeline.add(0.25)
    assert (timeline.index, timeline.last) == (2, 5)
