"""What cameras that stand still see of links that stand still, kept from one instant to the next."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView

_KEPT = 12
"""So many cameras are kept."""


@dataclass(frozen=True, eq=False)
class Layer:
    """What one camera sees of some links."""

    nearest: NDArray[np.int64]
    """Key of the nearest triangle of each pixel (h * w,), 0 for none; see `Spans.draw_into`."""
    links: NDArray[np.bool_]
    """Which links are in it (l,)."""


class Layers:
    """Layers of cameras, from the second time on that the same camera looks."""

    def __init__(self) -> None:
        self._layers: OrderedDict[tuple[object, ...], Layer | None] = OrderedDict()
        self._shown = b""

    def of(self, views: Sequence[CameraView], shown: NDArray[np.bool_], still: NDArray[np.bool_]) -> list[Layer | None]:
        """Return the layer of each camera, without links that have moved; None for those that look for the first time.

        Args:
            views: The cameras.
            shown: Whether each triangle is seen (m,).
            still: Whether each link has not moved lately (l,).
        """
        if (now := shown.tobytes()) != self._shown:
            self._shown = now
            self._layers.clear()
        return [self._layer(view, still) for view in views]

    def _layer(self, view: CameraView, still: NDArray[np.bool_]) -> Layer | None:
        layer = self._layers.get(view.key)
        if layer is not None and (layer.links & ~still).any():
            layer.nearest[:], layer.links[:] = 0, False
        elif layer is None and view.key in self._layers:
            layer = Layer(np.zeros(view.size[0] * view.size[1], dtype=np.int64), np.zeros(len(still), dtype=np.bool_))
        self._layers[view.key] = layer
        self._layers.move_to_end(view.key)
        while len(self._layers) > _KEPT:
            self._layers.popitem(last=False)
        return layer
