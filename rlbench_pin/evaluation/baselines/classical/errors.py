"""What goes wrong when looking."""

from __future__ import annotations

from rlbench_pin.errors import RlbenchPinError


class NothingFound(RlbenchPinError):
    """What an instruction names is not seen, or no recipe is known for it."""
