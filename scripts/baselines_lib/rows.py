"""The rows of docs/baselines.md: policies, their tasks, and the commands of `rlbench-pin` that bring them about."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain

from rlbench_pin.evaluation import task_set
from rlbench_pin.tasks import library_names

Command = tuple[str, ...]
"""Words behind `rlbench-pin`; `{out}` stands for the folder of the run, `{jobs}` for the number of workers."""

STATE_TASKS = ("reach_target", "push_button", "close_microwave", "toilet_seat_down", "close_drawer", "lamp_on")
"""What is cloned from state and from pictures."""


@dataclass(frozen=True)
class Row:
    """Results files and how they come about.

    Attributes:
        results: Name of a row of the table -> its results file in the folder of the run.
        play: The command that plays the episodes.
        before: What it takes: stages, one after the other, of commands that do not need each other.
    """

    results: dict[str, str]
    play: Command
    before: tuple[tuple[Command, ...], ...] = ()


def built(name: str) -> tuple[str, ...]:
    """Return the tasks of a set that are built."""
    return tuple(task for task in task_set(name).tasks if task in library_names())


def evaluated(
    name: str, policy: str, tasks: Iterable[str], episodes: int, *more: str, before: Sequence[Sequence[Command]] = ()
) -> Row:
    """Return a row that `rlbench-pin evaluate` plays."""
    file = f"{name}.json"
    play = (
        "evaluate",
        policy,
        "--tasks",
        *tasks,
        "--episodes",
        str(episodes),
        *more,
        "--workers",
        "{jobs}",
        "--out",
        f"{{out}}/{file}",
    )
    return Row({name: file}, play, tuple(tuple(stage) for stage in before))


def recorded(tasks: Iterable[str]) -> Command:
    """Return the command that records 100 demonstrations of each task without pictures, which training draws by itself."""
    return ("record", *tasks, "--episodes", "100", "--products", "--workers", "{jobs}", "--out", "{out}/data")


def trained(baseline: str, folder: str, tasks: Iterable[str], *more: str) -> tuple[Command, ...]:
    """Return the commands that train a network for each task on the demonstrations."""
    words = ("{out}/data", "--out", f"{{out}}/models/{folder}", *more)
    return tuple(("train", baseline, *words, "--tasks", task) for task in tasks)


def rows() -> dict[str, Row]:
    """Return all rows in the order of the table; what comes first is needed by none of the others."""
    key_frame_tasks = built("PERACT18")
    every = sorted({*STATE_TASKS, *key_frame_tasks})
    data = (recorded(every),)
    low = ("--max-seconds", "10")
    found = {
        "expert": evaluated("expert", "expert", ["all"], 10),
        "rest": evaluated("rest", "rest", ["all"], 10, *low),
        "random": evaluated("random", "random", ["all"], 10, *low),
    }
    for shots in (20, 100):
        folder = f"key_frames_{shots}"
        training = trained("key-frames", folder, key_frame_tasks, "--demos", str(shots))
        policy = f"key_frames?folder={{out}}/models/{folder}"
        found[folder] = evaluated(folder, policy, key_frame_tasks, 25, before=(data, training))
    return found


def commands(row: Row) -> Iterable[Command]:
    """Return every command of a row in order."""
    return chain(*row.before, (row.play,))
