"""The five cameras of observations, as things that can be moved and asked."""

from __future__ import annotations

from dataclasses import replace

from rlbench_pin.compat.things.element import ObjectType, UnsupportedCall
from rlbench_pin.compat.things.names import camera_of
from rlbench_pin.compat.things.placed import CameraSettings
from rlbench_pin.compat.things.thing import Thing
from rlbench_pin.environment import CameraConfig, ObservationConfig
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.sim import CameraView
from rlbench_pin.spatial import FloatArray

COLOR_CODED = "OPENGL_COLOR_CODED"
"""Render mode of cameras that show handles as colours."""


class Cameras:
    """The five cameras of one world.

    Args:
        runtime: The world.
        config: What observations contain; sizes and shadows of the pictures are read and written here.
    """

    def __init__(self, runtime: Runtime, config: ObservationConfig) -> None:
        self._runtime, self.config = runtime, config

    def settings_of(self, name: str) -> CameraConfig:
        """Return the settings of a camera by its name here."""
        config: CameraConfig = getattr(self.config, f"{name}_camera")
        return config

    def view(self, name: str) -> CameraView:
        """Return what a camera sees now."""
        return self._runtime.observer.appearance.moved(name, self._runtime.cameras[name].view())

    def place(self, name: str, pose: FloatArray) -> None:
        """Put a camera at a pose (7,) in the world; the one on the hand keeps its place there. Observations follow."""
        self._runtime.cameras[name].set_pose(pose)


class CameraThing(Thing):
    """One of the five cameras, or its twin that delivers masks and stands at the same place."""

    type: ObjectType = "vision_sensor"

    def __init__(self, cameras: Cameras, known_name: str) -> None:
        self._cameras = cameras
        self.name, self.is_mask = camera_of(known_name)

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) in the world."""
        return self._cameras.view(self.name).pose.copy()

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Move camera and twin."""
        self._cameras.place(self.name, pose)

    @property
    def camera(self) -> CameraSettings:
        """What it sees."""
        view, config = self._cameras.view(self.name), self._cameras.settings_of(self.name)
        mode = COLOR_CODED if self.is_mask else str(config.render_mode).rpartition(".")[2].upper()
        return CameraSettings(view.size, float(view.fov * 180.0 / 3.141592653589793), view.near, view.far, mode, True)

    def set_camera(self, camera: CameraSettings) -> None:
        """Change the size of its pictures, or whether they have shadows.

        Raises:
            UnsupportedCall: Something else is to change.
        """
        before = self.camera
        if replace(before, size=camera.size, render_mode=camera.render_mode) != camera:
            raise UnsupportedCall(
                f"changing angle or planes of camera '{self.name}'",
                "they are the same for all observations.",
                "Make a camera of your own with `VisionSensor.create`.",
            )
        config = self._cameras.settings_of(self.name)
        config.image_size = camera.size
        if not self.is_mask:
            config.render_mode = "opengl3" if camera.render_mode.startswith("OPENGL3") else "opengl"
