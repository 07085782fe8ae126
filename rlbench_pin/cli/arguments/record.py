"""What `rlbench-pin record TASK...` takes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

import tyro

from rlbench_pin.cli.process.words import (
    AnyTasks,
    Cameras,
    Compression,
    EngineName,
    MaybeBool,
    MaybeInt,
    MaybePath,
    OnlyTasks,
    Products,
    RenderMode,
    Size,
)
from rlbench_pin.observation import CAMERAS

DEFAULT_OUT = Path("out/dataset")

_PAIR = re.compile(r"\d+,\d+")
_BOOLEANS = ("true", "false")


@dataclass(frozen=True)
class KnownNames:
    """Flags of RLBench's generators, taken in the place of ours. Underscores are as good as hyphens, lists may have commas."""

    tasks: OnlyTasks = ()
    """As the task names themselves."""
    save_path: MaybePath = None
    """As `--out`."""
    processes: MaybeInt = None
    """As `--workers`."""
    episodes_per_task: MaybeInt = None
    """As `--episodes` with `--per-variation`; with `--all-variations True` as `--episodes` alone."""
    all_variations: MaybeBool = None
    """True spreads the episodes of a task over its variations, as `record` does; False counts them for each variation."""

    @property
    def are_used(self) -> bool:
        """Whether any of them was given."""
        return any(getattr(self, f.name) not in (None, ()) for f in fields(self))


@dataclass(frozen=True)
class Record:
    """Plan demonstrations of tasks and write them to a dataset. Whatever kills it, `--resume` continues where it ended."""

    tasks: tyro.conf.Positional[AnyTasks] = ()
    """Task names, as `rlbench-pin list` prints them, with spaces or commas between them, `all`, or task files; with `--resume`
    alone, those recorded before."""
    episodes: int = 10
    """Episodes of each task, spread evenly over its variations."""
    per_variation: bool = False
    """Count episodes for each variation."""
    variations: int = -1
    """Number of variations of a task, at most; -1 is all."""
    seed: int = 0
    """Seed of the recording. The same seed gives the same files, however many workers there are."""
    workers: int = 1
    """Worker processes; with 0 this process does the work."""
    engine: EngineName = "processes"
    """What does the work: processes of this machine, or a Ray cluster."""
    resume: bool = False
    """Go on with what the folder holds."""
    trust_task_files: bool = False
    """Run the task files that the folder keeps, where tasks are not installed and their files not named. Read them first."""
    image_size: Size = (128, 128)
    """Width and height of the pictures [px]."""
    cameras: Cameras = CAMERAS
    """Cameras whose pictures are stored."""
    products: Products = ("rgb", "depth", "mask")
    """What each camera delivers, of rgb, depth, mask and point_cloud; nothing after `--products` for no pictures."""
    compression: Compression = "gzip"
    """`gzip` is small, `lzf` is fast."""
    max_attempts: int = 10
    """Tries for each episode."""
    renderer: RenderMode = "opengl3"
    """`opengl3` draws shadows, `opengl` is faster without."""
    arm_max_velocity: float = 1.0
    """Cap on the speed of motions along the joint-space path [rad/s]."""
    arm_max_acceleration: float = 4.0
    """Cap on how fast that speed changes [rad/s^2]."""
    out: Path = DEFAULT_OUT
    """Folder of the dataset."""
    json: bool = False
    """Print the report as JSON."""
    known: tyro.conf.OmitArgPrefixes[KnownNames] = field(default_factory=KnownNames)
    """Flags of other generators."""


def spelled_out(arguments: Sequence[str]) -> list[str]:
    """Return the arguments of `record` as its parser wants them.

    `--image_size=128,128` becomes two numbers, and `--all_variations` without a value is true.
    """
    result: list[str] = []
    words = [part for argument in arguments for part in _split(argument)]
    for index, word in enumerate(words):
        following = words[index + 1].lower() if index + 1 < len(words) else ""
        flag = result[-1].replace("_", "-") if result else ""
        if flag == "--image-size" and _PAIR.fullmatch(word):
            result += word.split(",")
        elif flag == "--all-variations" and word.lower() in _BOOLEANS:
            result.append(word.capitalize())
        else:
            result.append(word)
        if word.replace("_", "-") == "--all-variations" and following not in _BOOLEANS:
            result.append("True")
    return result


def _split(argument: str) -> list[str]:
    """Cut `--flag=value` of the flags that are rewritten."""
    flag, equals, value = argument.partition("=")
    return [flag, value] if equals and flag.replace("_", "-") in ("--image-size", "--all-variations") else [argument]
