"""A body shows a colour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rlbench_pin.tasks.conditions.condition import Condition
from rlbench_pin.tasks.conditions.parts import Colored, as_part
from rlbench_pin.values import as_vector

if TYPE_CHECKING:
    from rlbench_pin.sim import Body


class HasColor(Condition):
    """Holds while the visible colour of `body` is exactly `rgb`.

    Args:
        body: The body.
        rgb: Red, green, blue in 0..1.
    """

    def __init__(self, body: Body, rgb: Sequence[float]) -> None:
        self.body = as_part(body, Colored, "body", "a body, such as `self.world.body(name)`")
        self.rgb = np.array(as_vector(rgb, 3, "rgb", most=1.0))

    def met(self) -> bool:
        """Return whether the body shows the colour now."""
        color = self.body.color
        return color is not None and np.allclose(np.asarray(color, dtype=float)[:3], self.rgb, rtol=0.0, atol=1e-9)
