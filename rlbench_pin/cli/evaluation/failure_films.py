"""Films of failures: the same episodes again, from their seeds and by the same policy."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tqdm import tqdm

from rlbench_pin.cli.process.files import check_folder
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.evaluation.results.records import EpisodeRecord, Results
from rlbench_pin.evaluation.run import EpisodeItem, EpisodeRunner, EvaluationConfig, plan_episodes
from rlbench_pin.recording import VideoRecorder


def film_failures(config: EvaluationConfig, results: Results, count: int, folder: Path) -> Iterator[Path]:
    """Play the first failures of each task again, and yield a film of each as it is made.

    Args:
        config: What was evaluated.
        results: What came of it.
        count: Failures of each task.
        folder: Where films go: `<task>_<seed>_<how it ended>.mp4`.
    """
    check_folder(folder)
    records = {record.key: record for record in results.episodes}
    items = plan_episodes(config)
    chosen: list[tuple[EpisodeItem, EpisodeRecord]] = []
    for task in results.tasks:
        of_task = [(item, records[item.name, item.variation, item.seed]) for item in items if item.name == task]
        chosen += [(item, record) for item, record in of_task if not record.success][:count]
    with EpisodeRunner(config) as runner, tqdm(total=len(chosen), unit="film", desc="films") as bar:
        for item, record in chosen:
            path = folder / f"{item.name}_{item.seed}_{record.end}.mp4"
            runner.play(item, lambda task, path=path: _filmed(task, path))  # type: ignore[misc]
            bar.update()
            if path.exists():
                yield path


@contextmanager
def _filmed(task: TaskEnvironment, path: Path) -> Iterator[None]:
    """VideoRecorder the block, also when a fault ends it."""
    with VideoRecorder(task, path.parent) as film:
        try:
            yield
        finally:
            film.keep(path)
