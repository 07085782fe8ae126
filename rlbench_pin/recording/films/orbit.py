"""A third-person camera that circles around the work."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.sim import CameraView, World, look_at

_NEAR, _FAR = 0.05, 6.0


@dataclass(frozen=True)
class Orbit:
    """A circle above the table, inside the room."""

    size: tuple[int, int] = (1280, 720)
    """Width and height [px]."""
    step: float = 0.005
    """Angle between two pictures [rad]."""
    start: float = 1.0
    """First angle, from straight ahead of the robot towards its left [rad]."""
    center: tuple[float, float, float] = (0.12, 0.0, 1.22)
    """What it looks at [m]."""
    radius: float = 1.6
    """Distance from the centre, seen from above [m]."""
    height: float = 1.75
    """Height above the floor [m]."""
    fov: float = 1.15
    """Field of view of the longer side [rad]."""

    def view(self, frame: int) -> CameraView:
        """Return the camera of picture number `frame`."""
        angle = self.start + frame * self.step
        x, y, _ = self.center
        eye = (x + self.radius * float(np.cos(angle)), y + self.radius * float(np.sin(angle)), self.height)
        return CameraView(pose=look_at(eye, self.center), fov=self.fov, size=self.size, near=_NEAR, far=_FAR)

    def picture(self, world: World, frame: int) -> np.ndarray:
        """Picture number `frame` of what happens now, uint8 (h, w, 3)."""
        return world.renderer.picture(self.view(frame))
