"""Press up to four buttons in the requested order."""

from __future__ import annotations

from rlbench_pin.tasks import BUTTON_COLORS
from rlbench_pin.tasks.library.push_buttons import PushButtons


class PushButtons4(PushButtons):
    """One to four of four buttons must go down by 3 mm in the requested order. Their bases have different colours."""

    variations_share_goals = False
    buttons_count = 4
    sequences = tuple(BUTTON_COLORS[first:16:4] for first in range(4))
    variations = 16
