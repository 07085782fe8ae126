"""Handles that move and turn one thing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from viser import SceneApi, TransformControlsEvent, TransformControlsHandle

from rlbench_pin.spatial import FloatArray

Phase = Literal["start", "update", "end"]
OnDrag = Callable[[FloatArray, Phase], None]
"""Called with the pose (7,) of the gizmo, and the part of the drag."""
NAME = "/gizmo"
SIZE = 0.14
"""Length of its arrows [m]."""


class Gizmo:
    """Shown where something is selected.

    Args:
        scene: Where to draw.
        on_drag: Called at its begin, while it is dragged, and when it is let go.
    """

    def __init__(self, scene: SceneApi, on_drag: OnDrag) -> None:
        self._on_drag = on_drag
        self._handle: TransformControlsHandle = scene.add_transform_controls(NAME, SIZE, depth_test=False, visible=False)

        async def heard(event: TransformControlsEvent) -> None:  # in the event loop, so that poses come in order
            self._on_drag(_pose_of(self._handle), event.phase)

        self._handle.on_update(heard)

    def show(self, pose: FloatArray | None) -> None:
        """Put it at a world pose (7,); None hides it."""
        self._handle.visible = pose is not None
        if pose is not None:
            self._handle.position = np.array(pose[:3])
            self._handle.wxyz = np.array([pose[6], pose[3], pose[4], pose[5]])


def _pose_of(handle: TransformControlsHandle) -> FloatArray:
    w, x, y, z = handle.wxyz
    return np.array([*handle.position, x, y, z, w], dtype=float)
