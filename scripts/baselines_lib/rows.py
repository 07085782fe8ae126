"""The rows of docs/baselines.md: policies, their tasks, and the `rlbench-pin` commands that produce them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain

from rlbench_pin.baselines.classical.recipes import TASKS as CLASSICAL_TASKS
from rlbench_pin.evaluation import task_set

Command = tuple[str, ...]
"""Words behind `rlbench-pin`; `{out}` stands for the folder of the run, `{jobs}` for the number of workers."""
Stage = tuple[Command, ...]
"""Commands that do not need each other."""

CLONED = ("reach_target", "push_button", "close_microwave", "toilet_seat_down", "close_drawer", "lamp_on")
"""Tasks cloned from state and from images."""
SHAPED = ("slide_block_to_target", "take_lid_off_saucepan")
"""Tasks of reinforcement learning with the task's own reward and demonstrations; `reach_target` has no demonstrations."""
SPARSE = ("push_button", "close_drawer")
"""Tasks of reinforcement learning for success alone, with demonstrations."""
TRIED = ("reach_target", *SHAPED, *SPARSE)
"""All that is learned by trial."""
SHOTS = (1, 5, 20)


@dataclass(frozen=True)
class Row:
    """Results files and how they come about.

    Attributes:
        results: Name of a row of the table -> its results file in the folder of the run.
        play: The command that plays the episodes.
        before: What it takes, one stage after the other.
    """

    results: dict[str, str]
    play: Command
    before: tuple[Stage, ...] = ()


def rows() -> dict[str, Row]:
    """Return all rows in the order of the table."""
    return {**bounds(), **cloned(), **keyed(), **by_trial(), **few_shot()}


def bounds() -> dict[str, Row]:
    """Return the planner, no-op, random actions, and the classical baseline: nothing has to be trained."""
    short = ("--max-seconds", "10")
    return {
        "expert": evaluated("expert", "expert", ["all"], 10),
        "noop": evaluated("noop", "noop", ["all"], 10, *short),
        "random": evaluated("random", "random", ["all"], 10, *short),
        "classical": evaluated("classical", "classical", CLASSICAL_TASKS, 20),
    }


def cloned() -> dict[str, Row]:
    """Return behaviour cloning from state and from images."""
    pictures = ("record", *CLONED, "--episodes", "100", "--cameras", "front", "wrist", "--products", "rgb")
    filmed = (*pictures, "--workers", "{jobs}", "--out", "{out}/filmed")
    state = (stored(), trained("cloning", "data", "cloning_state", CLONED, "--steps", "600"))
    by_sight = ("--cameras", "front", "wrist", "--steps", "1000")
    seen = ((filmed,), trained("cloning", "filmed", "cloning_pictures", CLONED, *by_sight))
    return {
        "cloning_state": evaluated("cloning_state", "cloning?folder={out}/models/cloning_state", CLONED, 100, before=state),
        "cloning_pictures": evaluated(
            "cloning_pictures", "cloning?folder={out}/models/cloning_pictures", CLONED, 25, before=seen
        ),
    }


def keyed() -> dict[str, Row]:
    """Return key-frame cloning of the 18 tasks of PerAct from 100 demonstrations of each, by the protocol."""
    training = trained("key-frames", "data", "key_frames", task_set("PERACT18").tasks)
    policy = "key_frames?folder={out}/models/key_frames"
    play = ("evaluate", policy, "--protocol", "peract18", "--workers", "{jobs}", "--out", "{out}/key_frames.json")
    return {"key_frames": Row({"key_frames": "key_frames.json"}, play, (stored(), training))}


def by_trial() -> dict[str, Row]:
    """Return SAC and PPO."""
    found = {}
    for name, alone, helped in (("sac", "20480", "6144"), ("ppo", "40960", "8192")):
        out = ("--out", f"{{out}}/models/{name}")
        taught = ("--demonstrations", "50", "--steps", helped, *out)
        training = [("train", name, "reach_target", "--shaped", "--steps", alone, *out)]
        training += [("train", name, task, "--shaped", *taught) for task in SHAPED]
        training += [("train", name, task, *taught) for task in SPARSE]
        found[name] = evaluated(name, f"{name}:{{out}}/models/{name}", TRIED, 100, before=(tuple(training),))
    return found


def few_shot() -> dict[str, Row]:
    """Return the few-shot learner on the test tasks of two splits."""
    found = {}
    for split, episodes in (("FS10_V1", "25"), ("V1", "10")):
        folder = f"nearest_{split}"
        words = ("--split", split, "--shots", *map(str, SHOTS), "--episodes", episodes, "--time-limit", "120")
        play = ("challenge", "run", "nearest", *words, "--workers", "{jobs}", "--out", f"{{out}}/{folder}")
        found[folder] = Row({f"{folder}_{shots}": f"{folder}/shots_{shots}.json" for shots in SHOTS}, play)
    return found


def stored() -> Stage:
    """Return the command that records 100 demonstrations without images of each task that is cloned."""
    tasks = sorted({*CLONED, *task_set("PERACT18").tasks})
    return (("record", *tasks, "--episodes", "100", "--products", "--workers", "{jobs}", "--out", "{out}/data"),)


def trained(baseline: str, data: str, folder: str, tasks: Iterable[str], *more: str) -> Stage:
    """Return the commands that train a network for each task."""
    words = (f"{{out}}/{data}", "--out", f"{{out}}/models/{folder}", *more)
    return tuple(("train", baseline, *words, "--tasks", task) for task in tasks)


def evaluated(
    name: str, policy: str, tasks: Iterable[str], episodes: int, *more: str, before: Sequence[Stage] = ()
) -> Row:  # fmt: skip
    """Return a row that `rlbench-pin evaluate` plays."""
    words = ("--tasks", *tasks, "--episodes", str(episodes), *more, "--workers", "{jobs}", "--out", f"{{out}}/{name}.json")
    return Row({name: f"{name}.json"}, ("evaluate", policy, *words), tuple(before))


def commands(row: Row) -> Iterable[Command]:
    """Return every command of a row in order."""
    return chain(*row.before, (row.play,))
