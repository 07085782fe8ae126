"""A third-person camera that circles around the work."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rlbench_pin.recording.films.framing import FAR, NEAR, field_of_view, things_to_see
from rlbench_pin.sim import CameraView, World, look_at


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
        return CameraView(pose=look_at(eye, self.center), fov=self.fov, size=self.size, near=NEAR, far=FAR)

    def around(self, world: World) -> Orbit:
        """Return the orbit that has the arm and the whole task of a world in its picture, for the first 1.5 rad."""
        points = things_to_see(world)
        low, high = points.min(axis=0), points.max(axis=0)
        x, y, z = ((low + high) / 2.0).tolist()
        orbit = replace(self, center=(x, y, z))
        turned = (replace(orbit, start=self.start + angle) for angle in np.linspace(0.0, 1.5, 7).tolist())
        return replace(orbit, fov=max(field_of_view(each.view(0), points) for each in turned))

    def picture(self, world: World, frame: int) -> np.ndarray:
        """Picture number `frame` of what happens now, uint8 (h, w, 3)."""
        return world.renderer.image(self.view(frame))
