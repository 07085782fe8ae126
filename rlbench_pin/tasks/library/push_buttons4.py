"""Press up to four buttons in the asked order."""

from __future__ import annotations

from rlbench_pin.tasks import BUTTON_COLORS
from rlbench_pin.tasks.library.push_buttons import PushButtons


class PushButtons4(PushButtons):
    """One to four of four buttons, which differ by the colours of their bases, must go down 3 mm in the asked order."""

    variations_share_goals = False
    buttons_count = 4
    sequences = tuple(BUTTON_COLORS[first:16:4] for first in range(4))
    variations = 16
