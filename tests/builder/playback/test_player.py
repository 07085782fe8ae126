"""A player shows what its time line stands at: figures, conditions, joints, and the evidence of a failure."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from viser import ViserServer

from rlbench_pin.builder.contracts import Failure, Frame
from rlbench_pin.builder.playback.player import NEAREST, Player
from rlbench_pin.builder.server import LocalServer
from tests.builder.playback.frames import RED, Notes, frame, recording

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
    assert (notes.marked, notes.ghosts) == ((), {})
    player.seek(9)
    assert notes.marked == ("panda_hand", "cube/base")
    assert list(notes.ghosts) == [NEAREST]
    player.seek(8)
    assert (notes.marked, notes.ghosts) == ((), {})
    player.seek(9)
    player.load(recording())
    assert (notes.marked, notes.ghosts) == ((), {})


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
    """Frames appear as they come; the whole recording brings its legs, and the instant shown stays."""
    whole = recording()
    player.begin(whole.conditions, whole.instruction, follow=True)
    for one in whole.frames[:6]:
        player.add(one)
    player.add_leg(whole.legs[0])
    assert player.timeline.index == 5
    assert len(player.recording.frames) == 6
    player.seek(3)
    player.finish(whole)
    assert (player.timeline.index, player.timeline.last, player.timeline.legs) == (3, 9, (0, 4))
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
