"""What the attributes of an episode file say, with the types and ranges that they must have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rlbench_pin.datasets.trust.schema import LARGEST, is_text_map, is_texts, is_whole, short
from rlbench_pin.observation import RandomState

MAX_FRAMES = 10_000_000
"""More frames than any episode has."""
_MOST_VARIATIONS = 2**31 - 1
_LONGEST_NAME = 1000


@dataclass(frozen=True)
class Head:
    """The attributes of an episode."""

    frames: int
    task: str
    variation: int
    attempt: int
    instructions: tuple[str, ...]
    versions: dict[str, str]
    random_seed: int | RandomState | None
    num_reset_attempts: int | None
    describes: bool
    """Whether every frame has the instructions in its `misc`."""


def read_head(attributes: dict[str, Any]) -> Head:
    """Check the attributes of an episode, of which the texts in JSON have been read.

    Raises:
        ValueError: One is missing, or not what it must be; names it and its value.
    """
    task, instructions, versions = (attributes.get(name) for name in ("task", "instructions", "versions"))
    if not isinstance(task, str) or len(task) > _LONGEST_NAME:
        raise ValueError(f"its task is {short(task)}, not a name")
    if not is_texts(instructions):
        raise ValueError(f"its instructions are {short(instructions)}, not a list of texts")
    if not is_text_map(versions):
        raise ValueError(f"its versions are {short(versions)}, not texts by name")
    assert isinstance(instructions, list) and isinstance(versions, dict)
    resets = "num_reset_attempts"
    return Head(
        frames=_whole(attributes, "frames", 1, MAX_FRAMES),
        task=task,
        variation=_whole(attributes, "variation", 0, _MOST_VARIATIONS),
        attempt=_whole(attributes, "attempt"),
        instructions=tuple(instructions),
        versions=versions,
        random_seed=_seed(attributes),
        num_reset_attempts=_whole(attributes, resets) if resets in attributes else None,
        describes=_flag(attributes, "descriptions"),
    )


def _seed(attributes: dict[str, Any]) -> int | RandomState | None:
    if "random_state" in attributes:
        state = attributes["random_state"]
        if not isinstance(state, tuple | list):
            raise ValueError(f"its random_state is {short(state)}, not the state of a generator")
        return tuple(state)
    return _whole(attributes, "random_seed") if "random_seed" in attributes else None


def _whole(attributes: dict[str, Any], name: str, low: int = 0, high: int = LARGEST) -> int:
    value: Any = attributes.get(name)
    plain = value.item() if isinstance(value, np.integer) else value
    if not is_whole(plain, low, high):
        raise ValueError(f"its {name} is {short(plain)}, not a whole number from {low} to {high}")
    return int(plain)


def _flag(attributes: dict[str, Any], name: str) -> bool:
    value = attributes.get(name, False)
    if not isinstance(value, bool | np.bool_):
        raise ValueError(f"its {name} is {short(value)}, neither true nor false")
    return bool(value)
