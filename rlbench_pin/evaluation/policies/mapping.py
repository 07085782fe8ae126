"""Mappings of served policies: the keys of observations, and the meaning of the numbers of actions."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, cast

import numpy as np
from PIL import Image, ImageOps
from scipy.spatial.transform import Rotation

from rlbench_pin.environment.actions import (
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    JointPosition,
    JointVelocity,
    MoveArmThenGripper,
)
from rlbench_pin.environment.observations import ObservationConfig
from rlbench_pin.errors import InvalidValue, UnknownName, nearest_name
from rlbench_pin.evaluation.policies.policy import PolicySettingsError
from rlbench_pin.evaluation.policies.settings import LARGEST_IMAGE, blank_observations
from rlbench_pin.observation import CAMERAS, Observation
from rlbench_pin.values import as_array, as_image_size, as_number, as_text, as_whole

_FOLDER = Path(__file__).parent / "mappings"
LONGEST_CHUNK = 1000
"""Maximum number of actions of a chunk that are played before the next request."""

ROTATIONS: Mapping[str, int] = {
    "quaternion_xyzw": 4,
    "quaternion_wxyz": 4,
    "axis_angle": 3,
    "euler_rpy": 3,
    "six_rows": 6,
    "six_columns": 6,
    "six_interleaved": 6,
}
"""Layout of a rotation matrix R (3, 3) -> number of its values. Angles are in [rad]; `euler_rpy` is Rz(yaw) Ry(pitch) Rx(roll).
Six numbers are the first two rows (`six_rows`) or columns (`six_columns`) of R, one after the other; `six_interleaved` are the
first two columns, row by row."""
ARMS: tuple[str, ...] = ("absolute_pose", "delta_pose", "joint_positions", "joint_deltas", "joint_velocities")
"""Meaning of the arm's numbers: a tip pose in the world, its change, joint positions, their changes, or joint velocities."""
PRODUCTS: tuple[str, ...] = ("rgb", "depth", "point_cloud")

_TIP = {f"tip_{layout}": layout for layout in ROTATIONS}


def _tip_rotation(layout: str) -> Callable[[Any], np.ndarray]:
    return lambda pose: encode_rotation(pose[3:], layout)


_STATES: Mapping[str, tuple[str, Callable[[Any], Any]]] = {
    "joint_positions": ("joint_positions", np.asarray),
    "joint_velocities": ("joint_velocities", np.asarray),
    "task_low_dim_state": ("task_low_dim_state", np.asarray),
    "tip_position": ("gripper_pose", lambda pose: pose[:3]),
    "fingers": ("gripper_joint_positions", np.asarray),
    "fingers_mirrored": ("gripper_joint_positions", lambda fingers: np.asarray(fingers) * [1.0, -1.0]),
    "gripper_open": ("gripper_open", lambda value: np.array([float(value)])),
    "gripper_closed": ("gripper_open", lambda value: np.array([1.0 - float(value)])),
    **{name: ("gripper_pose", _tip_rotation(layout)) for name, layout in _TIP.items()},
}
STATES: tuple[str, ...] = tuple(_STATES)
"""Parts of a state vector: `joint_positions` [rad] and `joint_velocities` [rad/s], (n,); `task_low_dim_state`, the poses of
objects of the task; `tip_position` (3,) [m] and the rotation of the tip, `tip_` and its layout; `fingers` (2,) [m], the second
negative in `fingers_mirrored`; `gripper_open` (1,), 1 open and 0 closed; `gripper_closed` (1,), 0 open and 1 closed."""
_FIXED_SIZES = {"tip_position": 3, "fingers": 2, "fingers_mirrored": 2, "gripper_open": 1, "gripper_closed": 1}
STATE_SIZES: Mapping[str, int] = {**_FIXED_SIZES, **{name: ROTATIONS[layout] for name, layout in _TIP.items()}}
"""Part of a state vector -> number of its values. Joints and task states are not in the table, because their sizes differ."""


class MappingError(PolicySettingsError):
    """A mapping cannot be used: a missing file, an unknown key, a wrong value, or a contradiction to the server."""


# Rotations --------------------------------------------------------------------------------------------------------------------


def encode_rotation(quaternion: np.ndarray, layout: str) -> np.ndarray:
    """Return a rotation in a layout.

    Args:
        quaternion: x, y, z, w, shape (4,).
        layout: One of `ROTATIONS`. Quaternions have w >= 0, axis-angle vectors a length from 0 to pi [rad].
    """
    rotation = Rotation.from_quat(quaternion)
    if layout.startswith("quaternion"):
        xyzw = rotation.as_quat(canonical=True)
        return xyzw if layout == "quaternion_xyzw" else np.roll(xyzw, 1)
    if layout == "axis_angle":
        return rotation.as_rotvec()
    if layout == "euler_rpy":
        return rotation.as_euler("xyz")
    matrix = rotation.as_matrix()
    return {"six_rows": matrix[:2], "six_columns": matrix[:, :2].T, "six_interleaved": matrix[:, :2]}[layout].ravel()


def decode_rotation(values: np.ndarray, layout: str) -> np.ndarray:
    """Return the quaternion (4,), x, y, z, w with w >= 0, of a rotation in a layout.

    Six numbers are made orthonormal by Gram-Schmidt, the first three numbers first (arXiv 1812.07035).

    Raises:
        ValueError: The numbers are not a rotation: a quaternion or a direction has length 0.
    """
    if layout.startswith("quaternion"):
        rotation = Rotation.from_quat(_unit(values if layout == "quaternion_xyzw" else np.roll(values, -1), "The quaternion"))
    elif layout == "axis_angle":
        rotation = Rotation.from_rotvec(values)
    elif layout == "euler_rpy":
        rotation = Rotation.from_euler("xyz", values)
    else:
        a, b = values.reshape(3, 2).T if layout == "six_interleaved" else values.reshape(2, 3)
        first = _unit(a, "The first direction of a rotation")
        second = _unit(b - (first @ b) * first, "The second direction of a rotation")
        rows = np.stack([first, second, np.cross(first, second)])
        rotation = Rotation.from_matrix(rows if layout == "six_rows" else rows.T)
    return rotation.as_quat(canonical=True)


def _unit(vector: np.ndarray, what: str) -> np.ndarray:
    length = float(np.linalg.norm(vector))
    if not 1e-3 < length < 1e3:
        raise ValueError(f"{what} has length {length:.3g}")
    return vector / length


# Records ----------------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ImageEntry:
    """An image of an observation."""

    camera: str
    """One of the five cameras."""
    product: str = "rgb"
    """`rgb` uint8 (h, w, 3), `depth` float32 (h, w) [m], or `point_cloud` float32 (h, w, 3) in the world [m]."""
    image_size: tuple[int, int] = (256, 256)
    """Width and height of the rendered image [px]."""
    resize: int | None = None
    """Side of the square to which an rgb image is resized [px], bilinear, with black bars if it is not square; None does not
    resize."""

    def __post_init__(self) -> None:
        """Raise InvalidValue or UnknownName for a wrong value."""
        _choose(self.camera, "camera", CAMERAS)
        _choose(self.product, "product", PRODUCTS)
        object.__setattr__(self, "image_size", as_image_size(self.image_size, "image_size"))
        if self.resize is not None:
            as_whole(self.resize, "resize", least=1, most=LARGEST_IMAGE)
            if self.product != "rgb":
                raise InvalidValue(
                    "resize", self.resize, f"is for rgb images, not for '{self.product}'", "Set `image_size` instead."
                )

    @property
    def sent_size(self) -> tuple[int, int]:
        """Width and height of the sent image [px]."""
        return self.image_size if self.resize is None else (self.resize, self.resize)

    def of(self, observation: Observation) -> np.ndarray:
        """Return the image that is sent, (h, w) or (h, w, 3), top row first."""
        image = np.asarray(getattr(observation, f"{self.camera}_{self.product}"))
        if self.resize is None or image.shape[:2] == (self.resize, self.resize):
            return np.ascontiguousarray(image)
        padded = ImageOps.pad(Image.fromarray(image), (self.resize, self.resize), Image.Resampling.BILINEAR)
        return np.asarray(padded)


@dataclass(frozen=True)
class ActionLayout:
    """Meaning of the numbers of an action: those of the arm, then the gripper."""

    arm: str
    """Meaning of the arm's numbers, one of `ARMS`. A pose is the position [m], then the rotation."""
    key: str = "actions"
    """Key of the chunk of actions in a reply."""
    rotation: str = "axis_angle"
    """Layout of the rotation of a pose, one of `ROTATIONS`."""
    frame: str = "world"
    """Frame of a `delta_pose`: `world` translates along world axes and rotates about them; `tip` does both in the tip frame."""
    motion: str = "ik"
    """Motion to a pose: `ik` follows joint positions near the current ones, `planning` plans a motion (for key frames)."""
    joints: int = 7
    """Number of joints of the arm, for numbers of joints."""
    scale: float = 1.0
    """Factor of a position to [m], or of joint numbers to [rad] or [rad/s]."""
    rotation_scale: float = 1.0
    """Factor of the rotation of a `delta_pose` to [rad]; for `axis_angle` and `euler_rpy`."""
    clip: float | None = None
    """Arm numbers are clipped to -clip and clip before they are scaled; None does not clip."""
    gripper_open: float = 1.0
    """Number of an open gripper. The gripper opens if the number is nearer to this one than to `gripper_closed`."""
    gripper_closed: float = 0.0
    """Number of a closed gripper."""

    def __post_init__(self) -> None:
        """Raise InvalidValue or UnknownName for a wrong value."""
        _choose(self.arm, "arm", ARMS)
        as_text(self.key, "key")
        _choose(self.rotation, "rotation", tuple(ROTATIONS))
        _choose(self.frame, "frame", ("world", "tip"))
        _choose(self.motion, "motion", ("ik", "planning"))
        as_whole(self.joints, "joints", least=1, most=64)
        for name in ("scale", "rotation_scale"):
            as_number(getattr(self, name), name, above=0.0, most=1e6)
        if self.clip is not None:
            as_number(self.clip, "clip", above=0.0)
        if as_number(self.gripper_open, "gripper_open") == as_number(self.gripper_closed, "gripper_closed"):
            raise InvalidValue("gripper_open", self.gripper_open, "has to differ from gripper_closed", "Change one of them.")
        if self.rotation_scale != 1.0 and (self.arm != "delta_pose" or self.rotation not in ("axis_angle", "euler_rpy")):
            hint = "Leave it out, or change `arm` or `rotation`."
            raise InvalidValue("rotation_scale", self.rotation_scale, "is for a delta_pose with axis_angle or euler_rpy", hint)
        if self.frame == "tip" and self.arm != "delta_pose":
            raise InvalidValue("frame", self.frame, "is for a delta_pose", "Leave it out, or set `arm` to 'delta_pose'.")

    @property
    def is_pose(self) -> bool:
        """Whether the arm's numbers are a pose."""
        return self.arm.endswith("pose")

    @property
    def size(self) -> int:
        """Number of values of an action."""
        return (3 + ROTATIONS[self.rotation] if self.is_pose else self.joints) + 1

    def action_mode(self) -> MoveArmThenGripper:
        """Return the action mode of the actions that `decode` returns."""
        absolute, frame = self.arm == "absolute_pose", cast(Any, "end effector" if self.frame == "tip" else "world")
        if not self.is_pose:
            kind = JointVelocity if self.arm == "joint_velocities" else JointPosition
            return MoveArmThenGripper(kind(self.arm != "joint_deltas"), Discrete())
        if self.motion == "planning":
            return MoveArmThenGripper(EndEffectorPoseViaPlanning(absolute, frame, retry_without_checks=True), Discrete())
        return MoveArmThenGripper(EndEffectorPoseViaIK(absolute, frame), Discrete())

    def decode(self, values: np.ndarray) -> np.ndarray:
        """Return an action of `action_mode`, float64: (8,) for poses, (joints + 1,) for joints.

        Args:
            values: The numbers of the server, finite, shape (size,).

        Raises:
            ValueError: The numbers are not a rotation.
        """
        arm, gripper = np.array(values[:-1], dtype=np.float64), float(values[-1])
        if self.clip is not None:
            arm = np.clip(arm, -self.clip, self.clip)
        is_open = float((gripper - self.gripper_closed) / (self.gripper_open - self.gripper_closed) > 0.5)
        if not self.is_pose:
            return np.append(arm * self.scale, is_open)
        rotation = decode_rotation(arm[3:] * self.rotation_scale, self.rotation)
        return np.concatenate([arm[:3] * self.scale, rotation, [is_open]])


@dataclass(frozen=True)
class PolicyMapping:
    """A mapping between our observations and actions and those of a served policy. A dot in a key separates nested maps."""

    source: str
    """Name of the preset, or path of the file."""
    instruction: str
    """Key of the instruction."""
    images: Mapping[str, ImageEntry]
    """Key -> image."""
    states: Mapping[str, tuple[str, ...]]
    """Key -> parts of `STATES`, which are concatenated to one float32 vector."""
    action: ActionLayout
    """Layout of actions."""
    replan: int = 1
    """Number of actions of a chunk that are played before the next request; a shorter chunk is played completely."""
    max_steps: int | None = None
    """Suggested maximum number of actions of an episode; None suggests no number."""

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys of an observation."""
        return (self.instruction, *self.images, *self.states)

    def state_size(self, key: str) -> int | None:
        """Return the size of the state under a key; None if it depends on the arm or the task."""
        sizes = [STATE_SIZES.get(part) for part in self.states[key]]
        return None if None in sizes else sum(size for size in sizes if size is not None)

    def obs_config(self) -> ObservationConfig:
        """Return the observation settings of the mapping."""
        config = blank_observations()
        for parts in self.states.values():
            for part in parts:
                setattr(config, _STATES[part][0], True)
        for image in self.images.values():
            camera = config.camera(image.camera)
            setattr(camera, image.product, True)
            camera.image_size = image.image_size
            camera.depth_in_meters = camera.depth
        return config

    def encode(self, observation: Observation, instruction: str) -> dict[str, Any]:
        """Return an observation with the keys of the server: images, float32 vectors, and the instruction."""
        encoded: dict[str, Any] = {}
        values: dict[str, Any] = {self.instruction: instruction}
        values |= {key: image.of(observation) for key, image in self.images.items()}
        for key, parts in self.states.items():
            found = [_STATES[part][1](getattr(observation, _STATES[part][0])) for part in parts]
            values[key] = np.concatenate(found).astype(np.float32)
        for key, value in values.items():
            *outer, last = key.split(".")
            place = encoded
            for name in outer:
                place = place.setdefault(name, {})
            place[last] = value
        return encoded

    def chunk(self, answer: object, most: int) -> np.ndarray:
        """Return the first actions of a reply, not decoded, shape (up to `most`, size); see `action.decode`.

        Args:
            answer: The reply, a map with the key of the actions; or only the actions, shape (size,) or (horizon, size).
            most: Maximum number of actions; later ones are ignored.

        Raises:
            ValueError: The key is missing, or its value is not an array of this shape with finite numbers.
        """
        layout = self.action
        value: Any = answer.get(layout.key) if isinstance(answer, Mapping) else answer
        if value is None:
            keys = ", ".join(map(str, list(answer)[:8])) if isinstance(answer, Mapping) else "none"
            raise ValueError(f"The reply has no '{layout.key}'; its keys: {keys[:200]}.")
        try:
            chunk = np.atleast_2d(as_array(value, "actions"))
        except InvalidValue as error:
            raise ValueError(f"'{layout.key}' is a {type(value).__name__}, not an array of numbers.") from error
        if chunk.ndim != 2 or len(chunk) == 0 or chunk.shape[1] != layout.size:
            named = f"an action of the mapping '{self.source}' has {layout.size} numbers"
            raise ValueError(f"'{layout.key}' has the shape {np.shape(value)}; {named}.")
        bad = np.argwhere(~np.isfinite(chunk[:most]))
        if len(bad):
            raise ValueError(f"'{layout.key}' has NaN or infinity at index {bad[0].tolist()}.")
        return chunk[:most]


# Files ------------------------------------------------------------------------------------------------------------------------


def mapping_names() -> tuple[str, ...]:
    """Return the names of the presets."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def load_mapping(name: str) -> PolicyMapping:
    """Return a mapping.

    Args:
        name: A preset, such as `droid`, or the path of a TOML file.

    Raises:
        UnknownName: No preset has this name; proposes the nearest name.
        MappingError: The file is missing, or is not a mapping; the error names file, key and value.
    """
    name = as_text(name, "A mapping", MappingError)
    if name.endswith(".toml") or "/" in name:
        path = Path(name)
    elif name in mapping_names():
        path = _FOLDER / f"{name}.toml"
    else:
        raise UnknownName("mapping", name, mapping_names())
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        said = error.strerror if isinstance(error, OSError) else str(error)
        raise MappingError("A mapping", name, f"cannot be read: {said}", f"Presets: {', '.join(mapping_names())}.") from error
    return mapping_of(content, name)


def mapping_of(content: Mapping[str, Any], source: str) -> PolicyMapping:
    """Return the mapping in the content of a TOML file.

    Args:
        content: The tables of the file.
        source: Name or path of the file, for errors.

    Raises:
        MappingError: An unknown key, or a wrong value.
    """
    top = _Table(source, "", content, ("about", "instruction", "images", "states", "action", "replan", "max_steps"))
    images = {key: cast(ImageEntry, top.record(f"images.{key}", entry, ImageEntry)) for key, entry in top.table("images").items()}
    states = {key: top.parts(f"states.{key}", value) for key, value in top.table("states").items()}
    if "action" not in content:
        raise MappingError(f"{source}: 'action'", None, "is missing", f"It is a table with `arm`, one of {', '.join(ARMS)}.")
    action = cast(ActionLayout, top.record("action", content["action"], ActionLayout))
    instruction = content.get("instruction", "prompt")
    if not isinstance(instruction, str) or not instruction:
        raise MappingError(
            f"{source}: 'instruction'", instruction, "has to be the key of the instruction, a text", "Example: 'prompt'."
        )
    replan = top.count("replan", content.get("replan", 1), LONGEST_CHUNK)
    steps = content.get("max_steps")
    steps = None if steps is None else top.count("max_steps", steps, 1_000_000)
    mapping = PolicyMapping(source, instruction, images, states, action, replan, steps)
    for key in mapping.keys:
        if mapping.keys.count(key) > 1 or any(other.startswith(f"{key}.") for other in mapping.keys):
            problem = "is the key of two values, or of a value and a map"
            raise MappingError(f"{source}: '{key}'", mapping.keys, problem, "Rename one of the keys.")
    sizes: dict[str, tuple[int, int]] = {}
    for key, image in images.items():
        if sizes.setdefault(image.camera, image.image_size) != image.image_size:
            problem = f"differs from that of another image of the camera '{image.camera}'"
            raise MappingError(f"{source}: 'images.{key}.image_size'", image.image_size, problem, "Use one size, and `resize`.")
    return mapping


@dataclass(frozen=True)
class _Table:
    """A table of a file, and its name for errors."""

    source: str
    name: str
    content: Any
    known: tuple[str, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.content, Mapping):
            raise MappingError(
                f"{self.source}: '{self.name}'", self.content, f"has to be a table with keys of {', '.join(self.known)}"
            )
        for key in self.content:
            if key not in self.known:
                near = nearest_name(key, self.known)
                hint = f"Did you mean '{near}'?" if near else f"Known: {', '.join(self.known)}."
                where = f"{self.name}.{key}" if self.name else key
                raise MappingError(f"{self.source}: '{where}'", self.content[key], "is not a key of a mapping", hint)

    def table(self, key: str) -> Mapping[str, Any]:
        """Return a table with keys of the server."""
        value = self.content.get(key, {})
        if not isinstance(value, Mapping):
            raise MappingError(f"{self.source}: '{key}'", value, "has to be a table, key of the server -> value")
        return value

    def record(self, name: str, value: object, kind: type[ImageEntry] | type[ActionLayout]) -> ImageEntry | ActionLayout:
        """Return a record of the entries of a table."""
        entries = dict(_Table(self.source, name, value, tuple(field.name for field in fields(kind))).content)
        needed = fields(kind)[0].name
        if needed not in entries:
            raise MappingError(f"{self.source}: '{name}.{needed}'", None, "is missing", f"Add `{needed}` to the table.")
        if isinstance(entries.get("image_size"), list):
            entries["image_size"] = tuple(entries["image_size"])
        try:
            return kind(**entries)
        except InvalidValue as error:
            raise MappingError(f"{self.source}: '{name}.{error.what}'", error.value, error.problem, error.hint) from error

    def parts(self, name: str, value: object) -> tuple[str, ...]:
        """Return the parts of a state."""
        if not isinstance(value, list) or not value:
            raise MappingError(f"{self.source}: '{name}'", value, "has to be a list of parts", f"Known: {', '.join(STATES)}.")
        try:
            return tuple(_choose(part, "part", STATES) for part in value)
        except InvalidValue as error:
            raise MappingError(f"{self.source}: '{name}'", error.value, error.problem, error.hint) from error

    def count(self, name: str, value: object, most: int) -> int:
        """Return a count."""
        try:
            return as_whole(value, name, least=1, most=most)
        except InvalidValue as error:
            raise MappingError(f"{self.source}: '{name}'", value, error.problem) from error


def _choose(value: object, what: str, known: Collection[str]) -> str:
    if not isinstance(value, str) or value not in known:
        near = nearest_name(value, known) if isinstance(value, str) else None
        raise InvalidValue(what, value, f"has to be one of {', '.join(known)}", f"Did you mean '{near}'?" if near else "")
    return value
