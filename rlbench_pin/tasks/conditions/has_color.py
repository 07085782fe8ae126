"""A body shows a colour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rlbench_pin.tasks.conditions.condition import Condition

if TYPE_CHECKING:
    from rlbench_pin.sim import Body


class HasColor(Condition):
    """Holds while the visible colour of `body` is exactly `rgb`.

    Args:
        body: The body.
        rgb: Red, green, blue in 0..1.
    """

    def __init__(self, body: Body, rgb: Sequence[float]) -> None:
        self.body, self.rgb = body, np.array(rgb, dtype=float)[:3]

    def met(self) -> bool:
        """Return whether the body shows the colour now."""
        color = self.body.color
        return color is not None and np.allclose(np.asarray(color, dtype=float)[:3], self.rgb, rtol=0.0, atol=1e-9)
