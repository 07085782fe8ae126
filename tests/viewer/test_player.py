"""A player and its timeline: figures, conditions, joints, and the evidence of a failure at the frame that is shown."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from viser import ViserServer

from rlbench_pin.builder.server import LocalServer
from rlbench_pin.viewer.player import NEAREST, Player, Timeline
from rlbench_pin.viewer.recording import Failure, Frame
from tests.viewer.frames import RED, Notes, frame, recording


@pytest.fixture
def timeline() -> Timeline:
    """Eleven frames in half a second, segments that begin at 0, 4 and 8."""
    made = Timeline()
    made.load([0.05 * i for i in range(11)], [0, 4, 8])
    return made


def test_time_goes_on_at_the_chosen_pace_and_stops_at_the_end(timeline: Timeline) -> None:
    """At 2x a tenth of a second shows four frames more; rests of time are not lost."""
    timeline.speed = 2.0
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
    timeline.toggle()
    assert not timeline.advance(1.0)


def test_steps_and_segments(timeline: Timeline) -> None:
    """Steps stay within the recording; jumps go to where segments begin, then to the ends."""
    timeline.seek(timeline.index - 1)
    assert timeline.index == 0
    where = []
    for _ in range(4):
        timeline.jump(1)
        where.append(timeline.index)
    assert where == [4, 8, 10, 10]
    timeline.seek(timeline.index - 5)
    assert (timeline.index, timeline.segment) == (5, 1)
    timeline.jump(-1)
    timeline.jump(-1)
    timeline.jump(-1)
    assert (timeline.index, timeline.segment) == (0, 0)


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
    timeline.seek(timeline.index - 2)
    timeline.add(0.25)
    assert (timeline.index, timeline.last) == (2, 5)


FAILURE = Failure(
    "Every configuration that reaches the goal touches something.",
    "waypoint1",
    (("panda_hand", "cube/base"),),
    np.array([0.4, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]),
)


@pytest.fixture(scope="module")
def page() -> Iterator[ViserServer]:
    """A page on this machine, without a browser."""
    with LocalServer() as server:
        yield server.viser


@pytest.fixture
def notes() -> Notes:
    """What the player moves."""
    return Notes()


@pytest.fixture
def player(page: ViserServer, notes: Notes) -> Iterator[Player]:
    """A player that shows nothing yet."""
    made = Player(page.gui, notes)
    yield made
    made.close()


def test_a_recording_is_shown_from_its_beginning(player: Player, notes: Notes) -> None:
    """The figures stand as in the first frame, then as in the one that somebody goes to."""
    player.load(recording())
    assert notes.joints.tolist() == [0.0] * 7
    assert notes.bodies == {"cube"}
    player.seek(7)
    assert notes.joints == pytest.approx(np.full(7, 0.7))
    assert notes.moved["cube/base"][0] == pytest.approx(0.07)
    assert notes.colors == {"cube/base": RED}
    player.seek(2)
    assert notes.colors == {}


def test_a_failure_is_drawn_at_the_last_instant(player: Player, notes: Notes) -> None:
    """What touches is red and the nearest pose a ghost there, and nowhere else; another recording has none of it."""
    player.load(replace(recording(), failure=FAILURE))
    assert (notes.marked, notes.ghost_poses) == ((), {})
    player.seek(9)
    assert notes.marked == ("panda_hand", "cube/base")
    assert list(notes.ghost_poses) == [NEAREST]
    player.seek(8)
    assert (notes.marked, notes.ghost_poses) == ((), {})
    player.seek(9)
    player.load(recording())
    assert (notes.marked, notes.ghost_poses) == ((), {})


def test_bodies_come_and_go(player: Player, notes: Notes) -> None:
    """A body that an episode adds or removes is seen while it is there."""
    frames = (frame(0, bodies=("cube",)), frame(1, bodies=("cube", "drop")), frame(2, bodies=("drop",)))
    player.load(replace(recording(), frames=frames))
    seen = []
    for index in range(3):
        player.seek(index)
        seen.append(set(notes.bodies))
    assert seen == [{"cube"}, {"cube", "drop"}, {"drop"}]


def test_time_goes_on_in_a_thread(page: ViserServer, notes: Notes) -> None:
    """Played, every instant is told; at the end it rests."""
    told: list[int] = []

    def tell(index: int, shown: Frame) -> None:
        told.append(index)

    player = Player(page.gui, notes, tell)
    try:
        player.load(recording(), play=True)
        end = time.monotonic() + 20.0
        while player.timeline.playing and time.monotonic() < end:
            time.sleep(0.01)
    finally:
        player.close()
    assert told[0] == 0
    assert told[-1] == 9
    assert told == sorted(told)


def test_what_is_simulated_now_is_followed_and_then_taken_over(player: Player, notes: Notes) -> None:
    """Frames appear as they come; the whole recording brings its segments, and the instant shown stays."""
    whole = recording()
    player.begin(whole.conditions, whole.instruction, follow=True)
    for one in whole.frames[:6]:
        player.add(one)
    player.add_segment(whole.segments[0])
    assert player.timeline.index == 5
    assert len(player.recording.frames) == 6
    player.seek(3)
    player.finish(whole)
    assert (player.timeline.index, player.timeline.last, player.timeline.segments) == (3, 9, (0, 4))
    assert notes.joints == pytest.approx(np.full(7, 0.3))


def test_an_empty_recording_is_shown_as_such(player: Player, notes: Notes) -> None:
    """Nothing moves, and the controls do not fail."""
    player.load(replace(recording(), frames=()))
    player.timeline.play()
    player.seek(3)
    assert player.timeline.index == 0
    assert notes.moved == {}


def test_what_comes_after_the_end_is_not_shown(player: Player, notes: Notes) -> None:
    """A stretch that is still being computed may go on for a while: nothing is drawn into a page that has been left."""
    whole = recording()
    player.load(whole, play=True)
    player.close()
    before = notes.moved
    player.begin(whole.conditions, whole.instruction, follow=True)
    player.add(whole.frames[5])
    player.finish(whole)
    assert notes.moved == before
    assert len(player.recording.frames) == 10
