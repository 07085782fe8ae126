"""`recording.json`: the settings that a dataset was recorded with, checked when they are read."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from rlbench_pin.datasets.manifest import is_texts, is_whole, parse_json, short
from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.errors import EpisodeFileError, RlbenchPinError
from rlbench_pin.recording.config import PictureConfig, RecordConfig
from rlbench_pin.values import as_path

RECORDING = "recording.json"
VERSION = 1
_MOST = 10**9
_MOST_PIXELS = 1 << 14

_Check = Callable[[object], bool]


def read_recording(root: Path | str) -> RecordConfig:
    """Return the settings that a folder was recorded with.

    Raises:
        DatasetError: There are none, or they cannot be read.
    """
    path = as_path(root, "root") / RECORDING
    if not path.exists():
        raise EpisodeFileError(
            path,
            f"'{path}' does not exist, so there is no recording to resume. `rlbench-pin record TASK... --out {root}` begins one.",
        )
    try:
        content = parse_json(path.read_text(encoding="utf-8"))
        if not isinstance(content, dict):
            raise ValueError("it is no table")
        if (version := content.pop("version", None)) != VERSION:
            raise ValueError(f"it has version {short(version)}, this package reads version {VERSION}")
        if not isinstance(content.get("pictures"), dict):
            raise ValueError("it has no table 'pictures'")
        pictures = PictureConfig(**_checked(content.pop("pictures"), _PICTURES))
        config = RecordConfig(**_checked(content, _SETTINGS), pictures=pictures)
        return replace(config, tasks=tuple(map(_stored_name, config.tasks)))
    except (OSError, ValueError, TypeError, RlbenchPinError) as error:
        raise EpisodeFileError(
            path,
            f"'{path}' does not describe a recording: {error}. Delete it, and record with `--resume` again, naming the "
            "tasks and settings: the episodes beside it are found.",
        ) from error


def write_recording(root: Path, config: RecordConfig) -> None:
    """Write the settings, so that `--resume` needs nothing more than the folder."""
    content = {"version": VERSION, **asdict(config)}
    write_whole(root / RECORDING, (json.dumps(content, indent=1) + "\n").encode())


def _stored_name(task: str) -> str:
    """Return the name of a task in a recording; a path to code, as older ones have it, is not followed."""
    name = Path(task).stem
    if not name.isidentifier():
        raise ValueError(f"{task!r} names no task")
    return name


def _checked(settings: dict[str, Any], checks: dict[str, _Check]) -> dict[str, Any]:
    """Return settings with lists as tuples.

    Raises:
        ValueError: One has the wrong type, or is out of its range.
    """
    for name, value in settings.items():
        if name in checks and not checks[name](value):
            raise ValueError(f"{name} = {short(value)}")
    return {name: tuple(value) if isinstance(value, list) else value for name, value in settings.items()}


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _is_flag(value: object) -> bool:
    return isinstance(value, bool)


def _is_limit(value: object) -> bool:
    return type(value) in (int, float) and math.isfinite(value) and value > 0  # type: ignore[arg-type, operator]


def _is_size(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(is_whole(side, 1, _MOST_PIXELS) for side in value)


_PICTURES: dict[str, _Check] = {
    "cameras": is_texts,
    "products": is_texts,
    "image_size": _is_size,
    "renderer": _is_text,
    "render_mode": _is_text,
    "compression": lambda value: value in ("gzip", "lzf"),
}
_SETTINGS: dict[str, _Check] = {
    "tasks": is_texts,
    "episodes": lambda value: is_whole(value, 1, _MOST),
    "per_variation": _is_flag,
    "variations": lambda value: is_whole(value, -1, _MOST),
    "draw_variations": _is_flag,
    "seed": is_whole,
    "max_attempts": lambda value: is_whole(value, 1, _MOST),
    "max_velocity": _is_limit,
    "max_acceleration": _is_limit,
}
