"""What is asked of a file before it is believed: checksums, places, types and ranges, and a reader that may die in its place."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.datasets.trust.head import MAX_FRAMES
from rlbench_pin.datasets.trust.inspection import Inspector
from rlbench_pin.datasets.trust.places import check_inside
from rlbench_pin.datasets.trust.schema import is_text_map, is_texts, is_whole, parse_json, short
from rlbench_pin.front_door import front_door

__all__ = ["MAX_FRAMES", "Inspector", "check_inside", "is_text_map", "is_texts", "is_whole", "parse_json", "short"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
