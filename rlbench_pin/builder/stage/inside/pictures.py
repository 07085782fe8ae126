"""What the five cameras see."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.observation import CAMERAS


def camera_pictures(runtime: Runtime, size: int) -> dict[str, NDArray[np.uint8]]:
    """Return name -> colour picture (size, size, 3) of each camera at this instant."""
    views = {name: replace(runtime.cameras[name].view(), size=(size, size)) for name in CAMERAS}
    shots = {name: runtime.world.render(view, depth=False, mask=False).rgb for name, view in views.items()}
    return {name: picture for name, picture in shots.items() if picture is not None}
