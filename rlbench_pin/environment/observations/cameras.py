"""Cameras of a runtime: the poses of the known ones, and a way to put each elsewhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from rlbench_pin.environment.observations.config import HAND, CameraConfig, ObservationConfig
from rlbench_pin.errors import CameraError, InvalidCamera
from rlbench_pin.observation import CAMERAS
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.sim import CameraView, World, look_at
from rlbench_pin.spatial import FloatArray, above_table, compose, relative, se3_to_pose
from rlbench_pin.values import as_vector

# name -> (position [m], point looked at [m], field of view [rad], near [m], far [m]); they stand with the table
_FIXED = {
    "left_shoulder": ((-0.175, 0.2, above_table(1.228)), (0.37, 0.10, above_table(0.048)), np.radians(40.0), 0.01, 3.2),
    "right_shoulder": ((-0.175, -0.2, above_table(1.228)), (0.37, -0.10, above_table(0.048)), np.radians(40.0), 0.01, 3.2),
    "overhead": ((-0.175, 0.0, above_table(1.678)), (0.22, 0.0, above_table(0.0)), np.radians(40.0), 0.01, 3.3),
    "front": ((1.35, 0.0, above_table(0.828)), (0.15, 0.0, above_table(0.268)), np.radians(40.0), 0.01, 4.5),
}
_WRIST = (np.radians(60.0), 0.01, 3.5)


_POSES = {name: look_at(eye, target) for name, (eye, target, *_rest) in _FIXED.items()}


def camera_view(name: str, config: CameraConfig, world: World, robot: RobotDescription) -> CameraView:
    """Return the view of camera `name` at this instant."""
    if name == "wrist":
        fov, near, far = _WRIST
        pose = compose(world.robot.link_pose(robot.hand_link), robot.camera_pose)
        return CameraView(pose=pose, fov=fov, size=config.image_size, near=near, far=far)
    return _fixed_view(name, tuple(config.image_size))


@lru_cache(maxsize=32)
def _fixed_view(name: str, size: tuple[int, int]) -> CameraView:
    """View of a camera that stands still; one object, so that its rays are computed once."""
    _eye, _target, fov, near, far = _FIXED[name]
    return CameraView(pose=_POSES[name], fov=fov, size=size, near=near, far=far)


_UNIT = 1e-3
"""How far the norm of a quaternion may be from 1."""
_DUST = 1e-12
"""From where on it is divided by its norm, so that other poses come back as they were given."""


class CameraPlaces:
    """The cameras that were put elsewhere, with their poses (7,) in what they ride on; one for all tasks of an `Environment`."""

    def __init__(self) -> None:
        self._poses: dict[str, FloatArray] = {}

    def pose(self, name: str) -> FloatArray | None:
        """Return where a camera was put, None when it stands where its settings say."""
        return self._poses.get(name)

    def put(self, name: str, pose: FloatArray) -> None:
        """Put a camera at `pose` (7,) in what it rides on."""
        self._poses[name] = pose.copy()

    def put_back(self, name: str) -> None:
        """Let a camera stand where its settings say."""
        self._poses.pop(name, None)


@dataclass(frozen=True)
class Camera:
    """One camera of a runtime.

    Domain randomization of camera poses comes on top of what is set here.
    """

    name: str
    """Its name, such as `front`."""
    cameras: Cameras
    """All cameras of the runtime."""

    @property
    def config(self) -> CameraConfig:
        """What it delivers."""
        return self.cameras.config.camera(self.name)

    @property
    def parent(self) -> str:
        """What it rides on: `world`, `hand`, or a body, link or frame of the scene."""
        return self.cameras.parent(self.name)

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) in the world at this instant: z forward, x left, y up."""
        return np.array(self.view().pose, dtype=float)

    @property
    def moved(self) -> bool:
        """Whether it was put elsewhere."""
        return self.cameras.places.pose(self.name) is not None

    def view(self) -> CameraView:
        """Return what it sees at this instant, for `World.render`."""
        return self.cameras.view(self.name)

    def set_pose(self, pose: Sequence[float] | FloatArray) -> None:
        """Put it at a pose; the next observation is taken from there. It goes on riding on what it rides on.

        No reset, state or other task undoes this; `reset_pose` does.

        Args:
            pose: Pose (7,) in the world: z forward, x left, y up. `look_at` makes one.

        Raises:
            CameraError: It is no pose.
        """
        self.cameras.move(self.name, _checked(self.name, pose))

    def reset_pose(self) -> None:
        """Put it back where its settings say."""
        self.cameras.places.put_back(self.name)


class Cameras:
    """The five cameras and the extra ones of a runtime, by name.

    Args:
        world: What they look at.
        robot: The arm that carries the wrist camera.
        config: Their settings; read at each call.
        places: Where the moved ones stand.
    """

    def __init__(self, world: World, robot: RobotDescription, config: ObservationConfig, places: CameraPlaces) -> None:
        self.config, self.places = config, places
        self._world, self._robot = world, robot
        self._views: dict[str, CameraView] = {}

    def __iter__(self) -> Iterator[str]:
        return iter((*CAMERAS, *self.config.extra_cameras))

    def __len__(self) -> int:
        return len(CAMERAS) + len(self.config.extra_cameras)

    def __getitem__(self, name: str) -> Camera:
        self.config.camera(name)  # raises UnknownName
        return Camera(name, self)

    def parent(self, name: str) -> str:
        """Return what a camera rides on: `world`, `hand`, or a body, link or frame of the scene."""
        if name in self.config.extra_cameras:
            return self.config.extra_cameras[name].parent
        return HAND if name == "wrist" else "world"

    def carrier_pose(self, name: str) -> FloatArray:
        """Return the pose (7,) in the world of what a camera rides on."""
        parent = self.parent(name)
        if parent == "world":
            return np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        if parent == HAND:
            return np.array(self._world.robot.link_pose(self._robot.hand_link), dtype=float)
        return se3_to_pose(self._world.placement(parent))

    def move(self, name: str, pose: FloatArray) -> None:
        """Put a camera at a pose (7,) in the world; it goes on riding on what it rides on."""
        self.places.put(name, pose if self.parent(name) == "world" else relative(pose, self.carrier_pose(name)))

    def view(self, name: str) -> CameraView:
        """Return what a camera sees at this instant."""
        extra = self.config.extra_cameras.get(name)
        if extra is None:
            view = camera_view(name, self.config.camera(name), self._world, self._robot)
        else:
            view = extra.view(self._world, self._robot)
        local = self.places.pose(name)
        if local is None:
            return view
        pose = local.copy() if self.parent(name) == "world" else compose(self.carrier_pose(name), local)
        return self._same_or(name, replace(view, pose=pose))

    def _same_or(self, name: str, view: CameraView) -> CameraView:
        """Return the last view of a moved camera when it is still true, so that its rays are computed once."""
        last = self._views.get(name)
        if last is None or last.key != view.key:
            self._views[name] = view
        return self._views[name]


def _checked(name: str, pose: Sequence[float] | FloatArray) -> FloatArray:
    values = as_vector(pose, 7, f"The pose of camera '{name}'", InvalidCamera).copy()
    norm = float(np.linalg.norm(values[3:]))
    if abs(norm - 1.0) > _UNIT:
        raise CameraError(
            f"The quaternion of camera '{name}' has norm {norm:.4f}. Divide it by its norm; the order is x, y, z, w."
        )
    if abs(norm - 1.0) > _DUST:
        values[3:] /= norm
    return values
