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
    """A camera: one of the five of observations, one of their mask cameras, or one that a program made.

    The camera's frame has z forward, x to the left, y up. Images show the present instant and come top row first.
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
        """Make a camera; it stays until `remove()`, through resets and tasks.

        * `resolution`: width and height [px]; `view_angle`: field of view of the longer side [deg].
        * `near_clipping_plane`, `far_clipping_plane` [m].
        * `render_mode`: OPENGL3 with shadows, OPENGL without, OPENGL_COLOR_CODED for handles as colours.
        * `explicit_handling`: allow `handle_explicitly`; `perspective_mode`: must be True.
        * `position` (3,) [m], None is the origin; `orientation`: Euler angles (3,) [rad].
        * The rest is accepted and changes nothing.
        """
        if not perspective_mode:
            raise _no_parallel_view()
        planes, mode = (float(near_clipping_plane), float(far_clipping_plane)), _mode(render_mode).name
        sensor = cls(_placed(CameraSettings(_size(resolution), float(view_angle), *planes, mode, explicit_handling)))
        sensor.set_place(position, orientation)
        return sensor

    # Images --------------------------------------------------------------------------------------------------------

    def view(self) -> CameraView:
        """Return its present view, as geometry."""
        camera = self.scene_object
        return self.table.cameras.view(camera.name) if isinstance(camera, CameraObject) else _view(camera.pose, self.camera)

    def handle_explicitly(self) -> None:
        """No effect: images always show the present instant.

        Raises:
            RuntimeError: Explicit handling is off.
        """
        if not self.get_explicit_handling():
            raise RuntimeError(
                "Explicit handling is disabled. Call `set_explicit_handling(1)` first, or call a capture method directly."
            )

    def capture_rgb(self) -> np.ndarray:
        """Take an image: float32 (h, w, 3) in 0..1; mask cameras encode handles in the channels."""
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
        """Measure depth along the axis: float32 (h, w), in 0..1 from near to far plane, or in [m]."""
        view = self.view()
        metres = self.table.world.render(view, rgb=False, mask=False).depth
        assert metres is not None
        return metres if in_meters else normalised_depth(metres, view)

    def capture_pointcloud(self) -> np.ndarray:
        """Return world coordinates of every pixel (h, w, 3) [m]."""
        return self.pointcloud_from_depth(self.capture_depth(in_meters=True))

    def pointcloud_from_depth(self, depth: np.ndarray) -> np.ndarray:
        """Return world coordinates of every pixel (h, w, 3) [m] of a depth image (h, w) [m] of this camera."""
        return self.pointcloud_from_depth_and_camera_params(depth, self.get_matrix(), self.get_intrinsic_matrix())

    @staticmethod
    def pointcloud_from_depth_and_camera_params(depth: np.ndarray, extrinsics: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
        """Return world coordinates of every pixel: extrinsics * inverse(intrinsics) * (u, v, 1) * depth.

        Args:
            depth: (h, w) [m].
            extrinsics: (4, 4) from camera to world.
            intrinsics: (3, 3).

        Returns:
            (h, w, 3) [m].
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
        """All settings."""
        found = self.scene_object
        camera = found.camera if isinstance(found, CameraObject) else self.table.placed[self.element.name].camera
        assert camera is not None, "vision sensors carry settings"
        return camera

    def change(self, **changes: Any) -> None:
        """Change some of the settings; raise CameraError when no image can be captured with them."""
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
        """Set width and height [px]; of a camera of observations, those of the observations."""
        self.change(size=_size(resolution))

    def get_perspective_mode(self) -> PerspectiveMode:
        """Return PERSPECTIVE."""
        return PerspectiveMode.PERSPECTIVE

    def set_perspective_mode(self, perspective_mode: PerspectiveMode) -> None:
        """Accept PERSPECTIVE.

        Raises:
            UnsupportedCall: ORTHOGRAPHIC.
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
        """Refused: there is no parallel view."""
        raise _no_parallel_view()

    def set_orthographic_size(self, ortho_size: float) -> None:
        """Refused: there is no parallel view."""
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
        """Return the size of its window: (0, 0), there is none."""
        return (0, 0)

    def set_windowed_size(self, resolution: Sequence[int] = (0, 0)) -> None:
        """Accepted: there is no window."""

    def get_explicit_handling(self) -> int:
        """Return 1 when `handle_explicitly` may be called."""
        return int(self.camera.explicit_handling)

    def set_explicit_handling(self, value: int) -> None:
        """Allow `handle_explicitly`, or not."""
        if self.element.kind == "placed":
            self.change(explicit_handling=bool(value))

    def get_entity_to_render(self) -> int:
        """Return -1: cameras see everything."""
        return -1

    def set_entity_to_render(self, entity_to_render: Object | int | None) -> None:
        """Accept everything (None or -1).

        Raises:
            UnsupportedCall: One object alone.
        """
        if entity_to_render not in (None, -1):
            raise UnsupportedCall(
                "set_entity_to_render", "cameras see the whole scene.", "Cut objects out of the image by their masks."
            )

    def copy(self) -> VisionSensor:
        """Make another camera with the same settings at the same place."""
        made = VisionSensor(_placed(self.camera))
        made.set_pose(self.get_pose())
        return made

    def remove(self) -> None:
        """Remove it; the five cameras of observations are only switched off.

        Raises:
            PyRepError: It is the mask camera of one of the five cameras.
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
    """Put a camera at the origin of the world."""
    _view(IDENTITY, camera)
    table = Simulator.current().objects
    name = table.free_name("Vision_sensor")
    table.placed[name] = Placed("vision_sensor", IDENTITY.copy(), camera=camera)
    return Element("placed", name)


def _view(pose: np.ndarray, camera: CameraSettings) -> CameraView:
    """Return the view of a camera at a pose (7,), or raise CameraError when no image can be captured."""
    return CameraView(pose.copy(), math.radians(camera.angle), camera.size, camera.near, camera.far)


def _size(resolution: Sequence[int]) -> tuple[int, int]:
    width, height = (int(v) for v in resolution)
    return width, height


def _mode(render_mode: RenderMode | str) -> RenderMode:
    return render_mode if isinstance(render_mode, RenderMode) else RenderMode[str(render_mode).upper()]


def _no_parallel_view() -> UnsupportedCall:
    return UnsupportedCall("an orthographic camera", "images are perspective here.", "Use a small angle from far away.")
