"""The commands: what each is for, what it takes and where it lives.

What a command takes is a dataclass of `cli.arguments`, imported when its help is asked for. Its work is a class of the same name
in `cli`, derived from it, whose imports take up to two seconds; it is imported when the command is to run.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass, fields
from typing import Any, Protocol, runtime_checkable


@runtime_checkable
class Subcommand(Protocol):
    """What every command can do."""

    def run(self) -> int:
        """Do it and return the exit code."""
        ...


@dataclass(frozen=True)
class Home:
    """Where a command lives."""

    module: str
    """Module of `rlbench_pin.cli`, and of `rlbench_pin.cli.arguments`."""
    name: str
    """Name of its class in both."""
    summary: str
    """The first sentences of its help, as its docstring has them."""

    def load(self) -> type:
        """Import what the command takes."""
        made: type = getattr(importlib.import_module(f"{ARGUMENTS}.{self.module}"), self.name)
        return made


ARGUMENTS = "rlbench_pin.cli.arguments"


def working(arguments: Any) -> Any:
    """Import the work of a command and return the command with the arguments given; commands among these likewise."""
    kind = type(arguments)
    if not kind.__module__.startswith(f"{ARGUMENTS}."):
        return arguments
    made = getattr(importlib.import_module(kind.__module__.replace(".arguments.", ".")), kind.__name__)
    return made(**{field.name: working(getattr(arguments, field.name)) for field in fields(kind)})


COMMANDS: dict[str, Home] = {
    "list": Home("list_tasks", "ListTasks", "List the tasks, each with a line about it."),
    "demo": Home("demo", "RecordDemos", "Plan demonstrations of one task, write each to an HDF5 episode, and film it."),
    "record": Home(
        "record",
        "Record",
        "Plan demonstrations of tasks and write them to a dataset. Whatever kills it, `--resume` continues where it ended.",
    ),
    "dataset": Home("dataset", "Dataset", "Inspect, verify, merge, rerender and export stored demonstrations."),
    "replay": Home(
        "replay",
        "Replay",
        "Restore the start of stored episodes, repeat their joint-position actions, and say whether they succeed again.",
    ),
    "check": Home(
        "check",
        "Check",
        "Judge tasks: demonstrations succeed and replay, resets repeat and rest, doing nothing and random actions solve nothing.",
    ),
    "view": Home(
        "view",
        "View",
        "Draw a contact sheet: seven cameras at the reset and at four moments of a demonstration. With `--live`, a page instead: "
        "episodes of a task, or the stored demonstrations of a dataset.",
    ),
    "video": Home(
        "video", "Video", "Film demonstrations of one or more tasks: one film per task, or one film of all of them in a grid."
    ),
    "new": Home(
        "new",
        "New",
        "Write a commented pair of files, NAME.py and NAME.toml: a reach that passes `rlbench-pin check --task-file NAME.py`.",
    ),
    "doctor": Home(
        "doctor", "Doctor", "Say what works here: take a picture with each renderer, write a film, name the libraries."
    ),
    "evaluate": Home(
        "evaluation.evaluate",
        "Evaluate",
        "Evaluate a policy on tasks: success with its interval, collisions, limits. Whatever kills it, `--resume` goes on.",
    ),
    "challenge": Home(
        "evaluation.challenge",
        "Challenge",
        "The few-shot challenge: a learner meets unseen tasks with 1, 5 and 20 demonstrations of each, and nothing else.",
    ),
    "serve": Home(
        "evaluation.serve",
        "Serve",
        "Serve a policy at an address until Ctrl-C; `rlbench-pin evaluate` with that address elsewhere evaluates it.",
    ),
    "results": Home(
        "evaluation.results", "ShowResults", "Print tables of results files, compare them episode by episode, draw them."
    ),
    "train": Home(
        "evaluation.train", "Train", "Train a baseline, on demonstrations or by trial. Whatever kills it, `--resume` goes on."
    ),
    "problems": Home(
        "problems",
        "Problems",
        "Write motions of demonstrations as planning problems: arm, obstacles, held bodies, start and goal, as JSON.",
    ),
}
