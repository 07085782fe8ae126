"""Paths around obstacles: found, shortened, smoothed.

`around.path_around`, which joins the parts, is not imported here: it needs the settings of `planning.plan`, and these name the
algorithms of this package.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.planning.search.connect import Connector
from rlbench_pin.planning.search.sampling import ALGORITHMS, Algorithm, sample_path
from rlbench_pin.planning.search.simplify import leave_out, shorten

__all__ = [
    "ALGORITHMS",
    "Algorithm",
    "Connector",
    "leave_out",
    "sample_path",
    "shorten",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
