"""Pages of tasks, datasets and evaluations, without a browser: what they show after what somebody does."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from rlbench_pin.builder.playback.live import DatasetView, LiveRunner, LiveView, TaskView
from rlbench_pin.datasets import DatasetWriter
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import DatasetError
from rlbench_pin.evaluation.run import EvaluationConfig, evaluate
from rlbench_pin.processes import SerialEngine
from rlbench_pin.tasks import Task, find_task

PATIENCE = 120.0
pytestmark = pytest.mark.simulation


@pytest.fixture
def reach_view() -> Iterator[TaskView]:
    """A page of reach_target, loaded."""
    with LiveView.of_task(find_task("reach_target"), seed=3) as page:
        assert page.view.worker.wait(PATIENCE)
        yield page.view


def test_a_task_is_reset_and_demonstrated(reach_view: TaskView) -> None:
    """At first the episode of the seed stands still; its demonstration reaches the goal, and the next seed is another episode."""
    player = reach_view.page.player
    assert len(player.recording.frames) == 1
    first = player.recording.frames[0].poses
    reach_view.demonstrate()
    assert reach_view.worker.wait(PATIENCE)
    assert player.recording.frames[-1].success
    assert [leg.waypoint for leg in player.recording.legs] == ["waypoint0"]
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
    with LiveView.of_task(Broken) as page:
        assert page.view.worker.wait(PATIENCE)
        assert "ZeroDivisionError: in init_task" in page.view.page.words
        page.view.demonstrate()
        assert page.view.worker.wait(PATIENCE)
        assert page.view.page.player.recording.frames == ()


def test_a_dataset_is_looked_through(tmp_path: Path) -> None:
    """Each stored demonstration is played again; numbers beyond the last mean the last."""
    with make_environment(low_dim_config()) as environment:
        demos = environment.get_task("reach_target").get_demos(2, live_demos=True, seed=5)
    for demo in demos:
        DatasetWriter(tmp_path).add(demo)
    with LiveView.of_dataset(tmp_path) as page:
        view: DatasetView = page.view
        assert view.worker.wait(PATIENCE)
        assert len(view.page.player.recording.frames) == len(demos[0])
        view.open("reach_target", 7)
        assert view.worker.wait(PATIENCE)
        assert len(view.page.player.recording.frames) == len(demos[1])
        assert view.page.player.recording.frames[-1].success


def test_a_folder_without_demonstrations_is_refused(tmp_path: Path) -> None:
    """The page is not even opened."""
    with pytest.raises(DatasetError):
        LiveView.of_dataset(tmp_path)


def test_an_evaluation_is_watched_and_comes_out_alike(tmp_path: Path) -> None:
    """Results have the same bytes; what was played is there to be looked at, with the reason of a failure."""
    config = EvaluationConfig(policy="noop", tasks=("reach_target",), episodes=2, max_steps=5)
    evaluate(config, tmp_path / "alone.json", engine=SerialEngine())
    with LiveView.of_evaluation("noop") as page:
        make = partial(LiveRunner, view=page.view)
        evaluate(config, tmp_path / "watched.json", engine=SerialEngine(), make_runner=make)
        shown = page.view.page.player.recording
        assert page.view.episodes[0].endswith(": steps")
    assert (tmp_path / "alone.json").read_bytes() == (tmp_path / "watched.json").read_bytes()
    assert len(page.view.episodes) == 2
    assert len(shown.frames) > 5
    assert shown.failure is not None
    assert "ended after 5 actions" in shown.failure.cause
