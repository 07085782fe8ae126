"""Geometry of cameras, and their images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.errors import CameraError, InvalidCamera
from rlbench_pin.spatial import FloatArray, matrix_to_pose, pose_to_matrix
from rlbench_pin.values import as_image_size, as_number, as_vector

_NEAR, _FAR = 0.05, 6.0
_MARGIN = 1.06
_NARROWEST, _WIDEST = 0.25, 1.6
"""Optics of `framed`: nearest and farthest distance [m], room beside the points, fields of view [rad]."""


@dataclass(frozen=True, eq=False)
class CameraView:
    """Pose and optics of a camera. The camera frame has z forward, x to the left, y up."""

    pose: FloatArray
    """Pose (7,) in the world."""
    fov: float
    """Field of view of the longer side [rad]."""
    size: tuple[int, int]
    """Width and height [px]."""
    near: float
    """Nearest distance along z that is seen [m]."""
    far: float
    """Farthest distance along z that is seen [m]."""
    shift: ClassVar[float] = 0.0
    """How far the principal point lies to the right of and below half the resolution [px]."""

    def __post_init__(self) -> None:
        for name in ("fov", "near", "far"):
            as_number(getattr(self, name), f"CameraView.{name}", InvalidCamera)
        as_image_size(self.size, "CameraView.size", InvalidCamera)
        if not (0.0 < self.fov < np.pi and 0.0 < self.near < self.far):
            raise CameraError(
                f"A camera needs 0 < fov < pi and 0 < near < far, not {self.fov}, {self.near}, {self.far}. Correct them."
            )

    def intrinsics(self) -> FloatArray:
        """Matrix (3, 3) with negative focal lengths [px]: image u increases along the camera's -x, v along -y.

        f = -longer side / (2 tan(fov / 2)); the principal point is half the resolution.
        """
        return self._intrinsics.copy()

    @cached_property
    def key(self) -> tuple[object, ...]:
        """All parameters of the view, for comparison."""
        return (np.asarray(self.pose, dtype=float).tobytes(), self.fov, tuple(self.size), self.near, self.far, self.shift)

    @cached_property
    def finer(self) -> CameraView:
        """The view at twice the resolution: each pixel of this view is split into two by two."""
        return _FinerView(self.pose, self.fov, (2 * self.size[0], 2 * self.size[1]), self.near, self.far)

    def extrinsics(self) -> FloatArray:
        """Matrix (4, 4) from camera to world coordinates."""
        return self._extrinsics.copy()

    @cached_property
    def _intrinsics(self) -> FloatArray:
        width, height = self.size
        focal = -max(width, height) / (2.0 * np.tan(self.fov / 2.0))
        return np.array([[focal, 0.0, width / 2.0 + self.shift], [0.0, focal, height / 2.0 + self.shift], [0.0, 0.0, 1.0]])

    @cached_property
    def _extrinsics(self) -> FloatArray:
        return pose_to_matrix(self.pose)

    @cached_property
    def to_image(self) -> FloatArray:
        """Matrix (3, 4) from world coordinates to u z, v z and z, where z is the depth."""
        return self._intrinsics @ np.linalg.inv(self._extrinsics)[:3]

    @cached_property
    def from_image(self) -> FloatArray:
        """Matrix (3, 4) from u z, v z, z and 1 to world coordinates."""
        world_camera = self._extrinsics[:3]
        result = world_camera.copy()
        result[:, :3] = world_camera[:, :3] @ np.linalg.inv(self._intrinsics)
        return result

    @cached_property
    def sides(self) -> FloatArray:
        """Planes (5, 4) of the view frustum with a margin of a pixel: products with (x, y, z, 1) are distances to them [m]."""
        (x, y, z), (width, height) = self.to_image, self.size
        planes = np.stack([x + z, width * z - x, y + z, height * z - y, z])
        planes[4, 3] -= self.near
        sides: FloatArray = planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
        return sides

    @cached_property
    def rays(self) -> NDArray[np.float32]:
        """Direction (h * w, 3) in the world of every pixel's ray, of depth 1; read-only."""
        width, height = self.size
        columns, rows = pixel_rays(self)
        local = np.empty((height, width, 3), dtype=np.float32)
        local[..., 0], local[..., 1], local[..., 2] = columns, rows[:, None], 1.0
        world = local.reshape(-1, 3) @ self._extrinsics[:3, :3].T.astype(np.float32)
        world.setflags(write=False)
        return world

    @cached_property
    def gl_view(self) -> list[float]:
        """World to OpenGL camera (x right, y up, z backward), column by column."""
        turn = np.diag([-1.0, 1.0, -1.0, 1.0])
        return np.linalg.inv(self._extrinsics @ turn).T.ravel().tolist()


@dataclass(frozen=True, eq=False)
class _FinerView(CameraView):
    """A view from `CameraView.finer`."""

    shift: ClassVar[float] = 0.5

    def __post_init__(self) -> None:
        """Skip the checks, which were done for the coarser view."""


@dataclass(frozen=True, eq=False)
class Images:
    """Images of a camera, top row first; None where not requested."""

    rgb: NDArray[np.uint8] | None
    """(h, w, 3)."""
    depth: NDArray[np.float32] | None
    """Distance along the optical axis [m], (h, w)."""
    mask: NDArray[np.int32] | None
    """Ids of `World.masks`, 0 where nothing is seen, (h, w)."""


def look_at(eye: Sequence[float] | FloatArray, target: Sequence[float] | FloatArray) -> FloatArray:
    """Return the pose (7,) of a camera at `eye` [m] that looks at `target` [m]: z forward, x left, y up.

    Raises:
        CameraError: Both are the same point, or an argument is not a point.
    """
    eye, target = as_vector(eye, 3, "eye", InvalidCamera), as_vector(target, 3, "target", InvalidCamera)
    forward = np.subtract(target, eye)
    if not np.linalg.norm(forward) > 1e-9:
        raise CameraError(f"A camera cannot look from {eye.tolist()} at {target.tolist()}: choose two different points.")
    forward = forward / np.linalg.norm(forward)
    up = np.array([0.0, 0.0, 1.0]) if abs(forward[2]) < 0.999 else np.array([1.0, 0.0, 0.0])
    up = up - up.dot(forward) * forward
    up = up / np.linalg.norm(up)
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([np.cross(up, forward), up, forward])
    matrix[:3, 3] = eye
    return matrix_to_pose(matrix)


def field_of_view(view: CameraView, points: FloatArray) -> float:
    """Return the smallest field of view of the longer side with points (n, 3) in the image of a camera [rad]."""
    across = np.abs(_slopes(view, points)).max(axis=0) * max(view.size) / np.array(view.size)
    return float(np.clip(2.0 * np.arctan(_MARGIN * across.max()), _NARROWEST, _WIDEST))


def framed(eye: Sequence[float] | FloatArray, points: FloatArray, size: tuple[int, int]) -> CameraView:
    """Return the camera at a pose whose image contains points (n, 3) as large as possible."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    view = CameraView(pose=look_at(eye, middle), fov=_WIDEST, size=size, near=_NEAR, far=_FAR)
    for _ in range(4):
        slopes = _slopes(view, points)
        center = (slopes.min(axis=0) + slopes.max(axis=0)) / 2.0
        aim = view.extrinsics()[:3] @ [*center, 1.0, 1.0]
        view = replace(view, pose=look_at(eye, aim))
    return replace(view, fov=field_of_view(view, points))


def _slopes(view: CameraView, points: FloatArray) -> FloatArray:
    """Return the slopes (n, 2) of points (n, 3) to the left and up from the optical axis; no point may be behind the camera."""
    local = (points - view.pose[:3]) @ view.extrinsics()[:3, :3]
    return local[:, :2] / np.maximum(local[:, 2:], _NEAR)


def pixel_rays(view: CameraView) -> tuple[FloatArray, FloatArray]:
    """Return camera x (w,) of each column and y (h,) of each row at depth 1."""
    width, height = view.size
    k = view.intrinsics()
    return (np.arange(width) - k[0, 2]) / k[0, 0], (np.arange(height) - k[1, 2]) / k[1, 1]


def projection_matrix(view: CameraView, hardware: bool = False) -> list[float]:
    """Return the OpenGL projection, column by column, with the same ray for each pixel (u, v) as `intrinsics`.

    TinyRenderer draws row v in row v - 1; OpenGL samples at the centre of pixels.
    """
    width, height = view.size
    focal = -view.intrinsics()[0, 0]
    near, far = view.near, view.far
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = 2.0 * focal / width, 2.0 * focal / height
    right, down = (0.5, 0.5) if hardware else (0.0, 1.0)
    matrix[0, 2], matrix[1, 2] = -2.0 * (right + view.shift) / width, 2.0 * (down + view.shift) / height
    matrix[2, 2], matrix[2, 3] = -(far + near) / (far - near), -2.0 * far * near / (far - near)
    matrix[3, 2] = -1.0
    return matrix.T.ravel().tolist()
