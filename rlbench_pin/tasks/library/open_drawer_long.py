"""Pull out one drawer of a chest of four."""

from __future__ import annotations

from rlbench_pin.tasks.library.open_drawer import OpenDrawer


class OpenDrawerLong(OpenDrawer):
    """The requested one of four drawers must move out by 15 cm."""

    drawers = ("bottom", "lower_middle", "upper_middle", "top")
