"""What the five cameras see at this instant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.observation import CAMERAS
from rlbench_pin.sim import Request

SIDE = 160
"""Of a picture [px]."""


def camera_pictures(runtime: Runtime, side: int = SIDE) -> dict[str, NDArray[np.uint8]]:
    """Return what each of the five cameras sees now, pictures (side, side, 3), with the shadows of the settings.

    Args:
        runtime: The running task.
        side: Of a picture [px].
    """
    config = runtime.observer.config
    runtime.world.renderer.lighting = config.lighting
    views = [replace(runtime.cameras[name].view(), size=(side, side)) for name in CAMERAS]
    requests = [
        Request(view, depth=False, mask=False, shadows=config.camera(name).draws_shadows)
        for name, view in zip(CAMERAS, views, strict=True)
    ]
    pictures = runtime.world.renderer.render_all(requests)
    return {name: picture.rgb for name, picture in zip(CAMERAS, pictures, strict=True) if picture.rgb is not None}
