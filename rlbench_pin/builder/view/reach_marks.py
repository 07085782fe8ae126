"""The map of what can be reached, as points on the table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from viser import SceneApi

from rlbench_pin.builder.contracts import ReachSpot
from rlbench_pin.spatial import TABLE_HEIGHT

GREEN, RED, GRAY = (60, 180, 75), (220, 50, 47), (120, 120, 120)
"""All waypoints are reached, one is not, the arm at home touches something."""
_ABOVE = 0.003
_NAME = "/reach"


class ReachMarks:
    """Draws a point for each layout that was looked at.

    Args:
        scene: Where to draw.
    """

    def __init__(self, scene: SceneApi) -> None:
        self._scene = scene

    def show(self, spots: Sequence[ReachSpot]) -> None:
        """Show these layouts; none take the map away."""
        if not spots:
            self._scene.remove_by_name(_NAME)
            return
        points = np.array([[spot.place[0], spot.place[1], TABLE_HEIGHT + _ABOVE] for spot in spots])
        colors = np.array([GRAY if not spot.free else GREEN if all(spot.reached) else RED for spot in spots], dtype=np.uint8)
        self._scene.add_point_cloud(_NAME, points, colors, point_size=0.015, point_shape="circle")
