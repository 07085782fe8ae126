"""How long each operation of the stage may take, and how much memory its process."""

from __future__ import annotations

from dataclasses import dataclass

from rlbench_pin.values import POSITIVE, check_settings, counted, ruled

_TIMES = "start open reset place reach follow paths picture tick trial wait"
_RULES = ruled((POSITIVE, _TIMES), (counted(2**28, 2**50), "memory"))


@dataclass(frozen=True, kw_only=True)
class StageLimits:
    """Times in [s]; what takes longer is ended, and the process with it."""

    start: float = 60.0
    """Until a new process has loaded its libraries."""
    open: float = 20.0
    """To build a task."""
    reset: float = 20.0
    """Between two layouts that are tried for an episode."""
    place: float = 10.0
    """To move what the scene says elsewhere."""
    reach: float = 5.0
    """To look at all waypoints."""
    follow: float = 5.0
    """For one step of the arm after the ghost."""
    paths: float = 60.0
    """To plan the way to one waypoint."""
    picture: float = 20.0
    """For the pictures of all cameras."""
    tick: float = 60.0
    """Between two frames of a demonstration: planning a motion, or one control tick."""
    trial: float = 600.0
    """For one trial of the validator."""
    wait: float = 5.0
    """That an operation waits for one that runs before it is refused."""
    memory: int = 4 * 2**30
    """Bytes of address space that a task may take beyond what the libraries take."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a number that is NaN, of a wrong kind, or not above 0 (also a ValueError)."""
        check_settings(self, _RULES)
