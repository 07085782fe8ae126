"""What a world was at every frame of a recording, so that it can be looked at again."""

from __future__ import annotations

import numpy as np

from rlbench_pin.builder.pictures import camera_pictures
from rlbench_pin.environment.runtime import Runtime


class Moments:
    """The world at each frame, some thousand bytes each; to be used in the thread that the world belongs to.

    Args:
        runtime: The running task.
    """

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._moments: list[dict[str, np.ndarray]] = []

    def clear(self) -> None:
        """Forget all."""
        self._moments.clear()

    def keep(self) -> None:
        """Keep the world as it is now for the next frame."""
        self._moments.append(self._runtime.world.arrays(exact=False))

    def pictures(self, index: int) -> dict[str, np.ndarray]:
        """Return what the five cameras saw at a frame; empty where the frame is not kept. The world is left at that moment."""
        if not 0 <= index < len(self._moments):
            return {}
        self._runtime.world.set_arrays(self._moments[index])
        return camera_pictures(self._runtime)
