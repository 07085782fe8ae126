"""Pages of tasks, datasets and evaluations, without a browser: what they show after what somebody does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Protocol, TypeVar

import pytest
from viser import ViserServer

from rlbench_pin.datasets import DatasetWriter
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import DatasetError
from rlbench_pin.evaluation.run import EvaluationConfig, evaluate
from rlbench_pin.processes import SerialEngine
from rlbench_pin.tasks import Task, find_task
from rlbench_pin.viewer.live import DatasetView, EvaluationView, LiveRunner, TaskView

PATIENCE = 120.0
pytestmark = pytest.mark.simulation


class View(Protocol):
    """A view of any kind."""

    def close(self) -> None:
        """Stop showing."""


ViewT = TypeVar("ViewT", bound=View)


@contextmanager
def opened(show: Callable[[ViserServer], ViewT]) -> Iterator[ViewT]:
    """Open a page for the duration of a block."""
    server = ViserServer("127.0.0.1", 0, verbose=False)
    try:
        with closing(show(server)) as view:
            yield view
    finally:
        server.stop()


@pytest.fixture
def reach_view() -> Iterator[TaskView]:
    """A page of reach_target, loaded."""
    with opened(lambda server: TaskView(server, find_task("reach_target"), seed=3)) as view:
        assert view.worker.wait(PATIENCE)
        yield view


def test_a_task_is_reset_and_demonstrated(reach_view: TaskView) -> None:
    """At first the episode of the seed stands still; its demonstration reaches the goal, and the next seed is another episode."""
    player = reach_view.page.player
    assert len(player.recording.frames) == 1
    first = player.recording.frames[0].poses
    reach_view.demonstrate()
    assert reach_view.worker.wait(PATIENCE)
    assert player.recording.frames[-1].success
    assert [segment.waypoint for segment in player.recording.segments] == ["waypoint0"]
    reach_view.reset(4)
    assert reach_view.worker.wait(PATIENCE)
    assert reach_view.episode == (4, 0)
    assert len(player.recording.frames) == 1
    assert any(player.recording.frames[0].poses[name].tolist() != pose.tolist() for name, pose in first.items())


def test_what_is_under_way_gives_way(reach_view: TaskView) -> None:
    """Another seed is not kept waiting by a demonstration."""
    reach_view.demonstrate()
    reach_view.reset(9)
    assert reach_view.worker.wait(PATIENCE)
    assert reach_view.episode == (9, 0)
    assert len(reach_view.page.player.recording.frames) == 1


class Broken(Task):
    """A task that cannot be set up."""

    @classmethod
    def scene_file(cls) -> Path:
        """Return a scene that exists."""
        return find_task("reach_target").scene_file()

    def init_task(self) -> None:
        """Raise."""
        raise ZeroDivisionError("in init_task")


def test_a_page_outlives_a_broken_task() -> None:
    """The error is said, and whoever asks again gets it again."""
    with opened(lambda server: TaskView(server, Broken)) as view:
        assert view.worker.wait(PATIENCE)
        assert "ZeroDivisionError: in init_task" in view.page.words
        view.demonstrate()
        assert view.worker.wait(PATIENCE)
        assert view.page.player.recording.frames == ()


def test_a_dataset_is_looked_through(tmp_path: Path) -> None:
    """Each stored demonstration is played again; numbers beyond the last mean the last."""
    with make_environment(low_dim_config()) as environment:
        demos = environment.get_task("reach_target").get_demos(2, live_demos=True, seed=5)
    for demo in demos:
        DatasetWriter(tmp_path).add(demo)
    with opened(lambda server: DatasetView(server, tmp_path)) as view:
        assert view.worker.wait(PATIENCE)
        assert len(view.page.player.recording.frames) == len(demos[0])
        view.open("reach_target", 7)
        assert view.worker.wait(PATIENCE)
        assert len(view.page.player.recording.frames) == len(demos[1])
        assert view.page.player.recording.frames[-1].success


def test_a_folder_without_demonstrations_is_refused(tmp_path: Path) -> None:
    """The page is not even opened."""
    with pytest.raises(DatasetError), opened(lambda server: DatasetView(server, tmp_path)):
        pass


def test_an_evaluation_is_watched_and_comes_out_alike(tmp_path: Path) -> None:
    """Results have the same bytes; what was played is there to be looked at, with the reason of a failure."""
    config = EvaluationConfig(policy="noop", tasks=("reach_target",), episodes=2, max_steps=5, policy_seed_key="key")
    evaluate(config, tmp_path / "alone.json", engine=SerialEngine())
    with opened(EvaluationView) as view:
        make = partial(LiveRunner, view=view)
        evaluate(config, tmp_path / "watched.json", engine=SerialEngine(), make_runner=make)
        shown = view.page.player.recording
        assert view.episodes[0].endswith(": steps")
    assert (tmp_path / "alone.json").read_bytes() == (tmp_path / "watched.json").read_bytes()
    assert len(view.episodes) == 2
    assert len(shown.frames) > 5
    assert shown.failure is not None
    assert "ended after 5 actions" in shown.failure.cause
