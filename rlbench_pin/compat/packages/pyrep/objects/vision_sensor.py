"""Cameras that capture images on request."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from pyrep.const import PerspectiveMode, RenderMode
from pyrep.errors import PyRepError, UnsupportedCall
from pyrep.objects.object import Object
from rlbench_pin.compat.objects import CameraSettings, Element, ObjectType, Placed
from rlbench_pin.compat.objects.scene_objects import COLOR_CODED, CameraObject
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment.observations.observe import normalised_depth, spread_mask
from rlbench_pin.sim import CameraView
from rlbench_pin.spatial import IDENTITY


class VisionSensor(Object):
    """A camera: one of the five observation cameras, one of their mask cameras, or a camera that a program created.

    The frame of the camera has z forward, x to the left and y up. Images show the current state, with the top row first.
    """

    kinds: ClassVar[tuple[ObjectType, ...]] = ("vision_sensor",)

    @classmethod
    def create(
        cls,
        resolution: Sequence[int],
        explicit_handling: bool = False,
        perspective_mode: bool = True,
        show_volume_not_detecting: bool = True,
        show_volume_detecting: bool = True,
        passive: bool = False,
        use_local_lights: bool = False,
        show_fog: bool = True,
        near_clipping_plane: float = 1e-2,
        far_clipping_plane: float = 10.0,
        view_angle: float = 60.0,
        ortho_size: float = 1.0,
        sensor_size: float | None = None,
        render_mode: RenderMode = RenderMode.OPENGL3,
        position: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
    ) -> VisionSensor:
        """Create a camera; it exists until `remove()`, also after resets and in other tasks.

        * `resolution`: width and height [px]; `view_angle`: field of view of the longer side [deg].
        * `near_clipping_plane`, `far_clipping_plane`: distances of the clipping planes [m].
        * `render_mode`: OPENGL3 with shadows, OPENGL without, OPENGL_COLOR_CODED for handles as colours.
        * `explicit_handling`: allow `handle_explicitly`; `perspective_mode`: must be True.
        * `position` (3,) [m], None is the origin; `orientation`: Euler angles (3,) [rad].
        * All other arguments have no effect.
        """
        if not perspective_mode:
            raise _no_parallel_view()
        planes, mode = (float(near_clipping_plane), float(far_clipping_plane)), _mode(render_mode).name
        sensor = cls(_placed(CameraSettings(_size(resolution), float(view_angle), *planes, mode, explicit_handling)))
        sensor.set_place(position, orientation)
        return sensor

    # Images --------------------------------------------------------------------------------------------------------

    def view(self) -> CameraView:
        """Return pose, field of view, size and clipping planes of the camera."""
        camera = self.scene_object
        return self.table.cameras.view(camera.name) if isinstance(camera, CameraObject) else _view(camera.pose, self.camera)

    def handle_explicitly(self) -> None:
        """No effect: images always show the current state.

        Raises:
            RuntimeError: Explicit handling is off.
        """
        if not self.get_explicit_handling():
            raise RuntimeError(
                "Explicit handling is disabled. Call `set_explicit_handling(1)` first, or call a capture method directly."
            )

    def capture_rgb(self) -> np.ndarray:
        """Return an image, float32 (h, w, 3) from 0 to 1; mask cameras encode handles in the channels."""
        world, mode = self.table.world, self.camera.render_mode
        if mode == COLOR_CODED:
            mask = world.render(self.view(), rgb=False, depth=False).mask
            assert mask is not None
            return spread_mask(mask)
        world.renderer.lighting = self.table.runtime.observer.appearance.lighting or self.table.cameras.config.lighting
        image = world.render(self.view(), depth=False, mask=False, shadows=mode.startswith("OPENGL3"), antialiasing=True).rgb
        assert image is not None
        return image.astype(np.float32) / np.float32(255.0)

    def capture_depth(self, in_meters: bool = False) -> np.ndarray:
        """Return the depth along the optical axis, float32 (h, w), from 0 (near plane) to 1 (far plane), or in [m]."""
        view = self.view()
        metres = self.table.world.render(view, rgb=False, mask=False).depth
        assert metres is not None
        return metres if in_meters else normalised_depth(metres, view)

    def capture_pointcloud(self) -> np.ndarray:
        """Return the world coordinates of each pixel (h, w, 3) [m]."""
        return self.pointcloud_from_depth(self.capture_depth(in_meters=True))

    def pointcloud_from_depth(self, depth: np.ndarray) -> np.ndarray:
        """Return the world coordinates (h, w, 3) [m] of each pixel of a depth image (h, w) [m] of this camera."""
        return self.pointcloud_from_depth_and_camera_params(depth, self.get_matrix(), self.get_intrinsic_matrix())

    @staticmethod
    def pointcloud_from_depth_and_camera_params(depth: np.ndarray, extrinsics: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
        """Return the world coordinates of each pixel: extrinsics * inverse(intrinsics) * (u, v, 1) * depth.

        Args:
            depth: Depth image (h, w) [m].
            extrinsics: Matrix from camera to world coordinates (4, 4).
            intrinsics: Matrix from camera to pixel coordinates (3, 3).

        Returns:
            World coordinates (h, w, 3) [m].
        """
        height, width = depth.shape
        columns, rows = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
        pixels = np.stack([columns, rows, np.ones_like(columns)], axis=-1) @ np.linalg.inv(intrinsics).T
        points: np.ndarray = (pixels * depth[..., None]) @ np.asarray(extrinsics)[:3, :3].T + np.asarray(extrinsics)[:3, 3]
        return points

    def get_intrinsic_matrix(self) -> np.ndarray:
        """Return the intrinsics (3, 3) with negative focal lengths [px]."""
        return self.view().intrinsics()

    # Settings --------------------------------------------------------------------------------------------------------

    @property
    def camera(self) -> CameraSettings:
        """All settings of the camera."""
        found = self.scene_object
        camera = found.camera if isinstance(found, CameraObject) else self.table.placed[self.element.name].camera
        assert camera is not None, "vision sensors carry settings"
        return camera

    def change(self, **changes: Any) -> None:
        """Change some of the settings; raise CameraError if they are invalid."""
        camera, name = replace(self.camera, **changes), self.element.name
        _view(IDENTITY, camera)
        found = self.scene_object
        if isinstance(found, CameraObject):
            found.set_camera(camera)
        else:
            self.table.placed[name] = replace(self.table.placed[name], camera=camera)

    def get_resolution(self) -> list[int]:
        """Return width and height [px]."""
        return list(self.camera.size)

    def set_resolution(self, resolution: Sequence[int]) -> None:
        """Set width and height [px]; for an observation camera this also changes the observations."""
        self.change(size=_size(resolution))

    def get_perspective_mode(self) -> PerspectiveMode:
        """Return PERSPECTIVE."""
        return PerspectiveMode.PERSPECTIVE

    def set_perspective_mode(self, perspective_mode: PerspectiveMode) -> None:
        """No effect for PERSPECTIVE, the only available mode.

        Raises:
            UnsupportedCall: The mode is ORTHOGRAPHIC.
        """
        if perspective_mode != PerspectiveMode.PERSPECTIVE:
            raise _no_parallel_view()

    def get_perspective_angle(self) -> float:
        """Return the field of view of the longer side [deg]."""
        return self.camera.angle

    def set_perspective_angle(self, angle: float) -> None:
        """Set the field of view of the longer side [deg]."""
        self.change(angle=float(angle))

    def get_orthographic_size(self) -> float:
        """Raise UnsupportedCall: there is no orthographic projection."""
        raise _no_parallel_view()

    def set_orthographic_size(self, ortho_size: float) -> None:
        """Raise UnsupportedCall: there is no orthographic projection."""
        raise _no_parallel_view()

    def get_near_clipping_plane(self) -> float:
        """Return the near plane [m]."""
        return self.camera.near

    def set_near_clipping_plane(self, near_clipping: float) -> None:
        """Set the near plane [m]."""
        self.change(near=float(near_clipping))

    def get_far_clipping_plane(self) -> float:
        """Return the far plane [m]."""
        return self.camera.far

    def set_far_clipping_plane(self, far_clipping: float) -> None:
        """Set the far plane [m]."""
        self.change(far=float(far_clipping))

    def get_render_mode(self) -> RenderMode:
        """Return the render mode."""
        return RenderMode[self.camera.render_mode]

    def set_render_mode(self, render_mode: RenderMode) -> None:
        """Set the render mode."""
        self.change(render_mode=_mode(render_mode).name)

    def get_windowed_size(self) -> Sequence[int]:
        """Return (0, 0): there is no window."""
        return (0, 0)

    def set_windowed_size(self, resolution: Sequence[int] = (0, 0)) -> None:
        """No effect: there is no window."""

    def get_explicit_handling(self) -> int:
        """Return 1 if `handle_explicitly` is allowed, otherwise 0."""
        return int(self.camera.explicit_handling)

    def set_explicit_handling(self, value: int) -> None:
        """Set whether `handle_explicitly` is allowed; no effect for observation cameras, where it always is."""
        if self.element.kind == "placed":
            self.change(explicit_handling=bool(value))

    def get_entity_to_render(self) -> int:
        """Return -1: images show all objects."""
        return -1

    def set_entity_to_render(self, entity_to_render: Object | int | None) -> None:
        """No effect for all objects (None or -1).

        Raises:
            UnsupportedCall: The argument is a single object.
        """
        if entity_to_render not in (None, -1):
            raise UnsupportedCall(
                "set_entity_to_render", "cameras see the whole scene.", "Cut objects out of the image by their masks."
            )

    def copy(self) -> VisionSensor:
        """Create a camera with the same settings at the same pose."""
        made = VisionSensor(_placed(self.camera))
        made.set_pose(self.get_pose())
        return made

    def remove(self) -> None:
        """Remove the camera; an observation camera is only disabled.

        Raises:
            PyRepError: The camera is the mask camera of an observation camera.
        """
        camera = self.scene_object
        if not isinstance(camera, CameraObject):
            super().remove()
        elif camera.is_mask:
            raise PyRepError(f"'{self.get_name()}' belongs to its camera. Disable masks in the observation config.")
        else:
            self.table.cameras.settings_of(camera.name).set_all(False)
        self._removed = True


def _placed(camera: CameraSettings) -> Element:
    """Create a camera at the origin of the world, and return it."""
    _view(IDENTITY, camera)
    table = Simulator.current().objects
    name = table.free_name("Vision_sensor")
    table.placed[name] = Placed("vision_sensor", IDENTITY.copy(), camera=camera)
    return Element("placed", name)


def _view(pose: np.ndarray, camera: CameraSettings) -> CameraView:
    """Return the view of a camera at a pose (7,), or raise CameraError for invalid settings."""
    return CameraView(pose.copy(), math.radians(camera.angle), camera.size, camera.near, camera.far)


def _size(resolution: Sequence[int]) -> tuple[int, int]:
    width, height = (int(v) for v in resolution)
    return width, height


def _mode(render_mode: RenderMode | str) -> RenderMode:
    return render_mode if isinstance(render_mode, RenderMode) else RenderMode[str(render_mode).upper()]


def _no_parallel_view() -> UnsupportedCall:
    return UnsupportedCall("an orthographic camera", "images are perspective here.", "Use a small angle from far away.")
