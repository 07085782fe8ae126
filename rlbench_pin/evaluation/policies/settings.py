"""The settings of a policy as plain data: its action mode and its observations. Results files and messages contain them.

Observations that are not in the data are off. Values that equal their default are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields
from inspect import Parameter, signature
from typing import Any

import numpy as np

from rlbench_pin.control.safety_filter import SafetyConfig
from rlbench_pin.environment.actions import (
    ActionMode,
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    ERJointViaIK,
    GripperJointPosition,
    JointPosition,
    JointPositionActionMode,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
    RelativeFrame,
    SafeArm,
)
from rlbench_pin.environment.observations import ExtraCamera, GaussianNoise, Identity, ModelObservationConfig, ObservationConfig
from rlbench_pin.environment.observations.config import HAND, CameraConfig
from rlbench_pin.errors import RlbenchPinError, nearest_name
from rlbench_pin.evaluation.policies.policy import PolicyOfAnotherArm, PolicySettingsError
from rlbench_pin.observation import CAMERAS
from rlbench_pin.robot.description import SUPPORTED_ROBOTS, robot_description
from rlbench_pin.sim import Light, Lighting
from rlbench_pin.values import as_names, as_whole

LARGEST_IMAGE = 1024
"""Maximum width and height of an image of a policy [px]."""
LARGEST_OBSERVATION = 64_000_000
"""Maximum size of all images of an observation of a policy [bytes]."""


@dataclass(frozen=True)
class PolicySettings:
    """Settings of a policy. All values are JSON data; action modes and noise are those of this package.

    Raises:
        PolicySettingsError: An action mode or an observation does not exist, or has a wrong value (also an InvalidValue). Or an
            image is larger than `LARGEST_IMAGE`, or all images together are larger than `LARGEST_OBSERVATION`.
    """

    action_mode: dict[str, Any]
    """Classes and parameters of the action mode: `mode`, `arm`, `arm_settings`, `gripper`, `gripper_settings`."""
    observation: dict[str, Any] = field(default_factory=dict)
    """Observations: low-dimensional fields, and `cameras` with their products and sizes. Fields left out are off."""
    max_steps: int | None = None
    """Suggested maximum number of actions of an episode; None suggests no number."""
    joint_names: tuple[str, ...] = ()
    """Arm joints that the policy was made for, in order; empty for any arm."""

    def __post_init__(self) -> None:
        """Fill in default values, so that equal settings are equal data."""
        object.__setattr__(self, "action_mode", describe_action_mode(make_action_mode(self.action_mode)))
        object.__setattr__(self, "observation", describe_observations(make_observations(self.observation)))
        _check_images(make_observations(self.observation))
        if self.max_steps is not None:
            as_whole(self.max_steps, "max_steps of a policy", PolicySettingsError, least=1)
        object.__setattr__(self, "joint_names", as_names(self.joint_names, "joint_names of a policy", PolicySettingsError))

    @classmethod
    def of(cls, action_mode: object, obs_config: object, max_steps: object = None, joint_names: object = ()) -> PolicySettings:
        """Return the settings of a policy.

        Args:
            action_mode: An action mode of this package, or its plain data.
            obs_config: Observations of the policy, or their plain data.
            max_steps: Suggested maximum number of actions of an episode, or None.
            joint_names: Arm joints that the policy was made for; empty or None for any arm.

        Raises:
            PolicySettingsError: An argument has another type, or is a custom class of the policy.
        """
        modes = action_mode if isinstance(action_mode, Mapping) else describe_action_mode(action_mode)  # type: ignore[arg-type]
        seen = obs_config if isinstance(obs_config, Mapping) else describe_observations(obs_config)  # type: ignore[arg-type]
        return cls(dict(modes), dict(seen), max_steps, () if joint_names is None else joint_names)  # type: ignore[arg-type]

    @classmethod
    def of_policy(cls, policy: Any) -> PolicySettings:
        """Return the settings of a policy from its attributes; `max_steps` and `joint_names` are optional.

        Raises:
            PolicySettingsError: An attribute cannot be used.
        """
        steps, joints = getattr(policy, "max_steps", None), getattr(policy, "joint_names", ())
        return cls.of(policy.action_mode, policy.obs_config, steps, joints)

    def plain(self) -> dict[str, Any]:
        """Return the settings as plain data, without `joint_names` if they are empty."""
        return {name: value for name, value in asdict(self).items() if name != "joint_names" or value}

    def check_robot(self, robot: str) -> None:
        """Raise PolicyOfAnotherArm if the policy was made for the joints of another arm.

        Args:
            robot: Name of the arm.
        """
        needed = robot_description(robot).arm_joints
        if self.joint_names and self.joint_names != needed:
            owners = tuple(name for name, arm in SUPPORTED_ROBOTS.items() if arm.arm_joints == self.joint_names)
            raise PolicyOfAnotherArm(self.joint_names, robot, owners, needed)

    def make_action_mode(self) -> ActionMode:
        """Return a new action mode."""
        return make_action_mode(self.action_mode)

    def make_obs_config(self) -> ObservationConfig:
        """Return new observation settings."""
        return make_observations(self.observation)


# Action modes -----------------------------------------------------------------------------------------------------------------


ARM_MODES: Mapping[str, type] = {
    kind.__name__: kind
    for kind in (
        JointVelocity, JointPosition, JointTorque, EndEffectorVelocity, EndEffectorPoseViaPlanning, EndEffectorPoseViaIK,
        ERJointViaIK, SafeArm,
    )
}  # fmt: skip
"""Name -> arm mode that a policy may have."""
GRIPPER_MODES: Mapping[str, type] = {kind.__name__: kind for kind in (Discrete, GripperJointPosition)}
"""Name -> gripper mode that a policy may have."""
ACTION_MODES: Mapping[str, type] = {kind.__name__: kind for kind in (MoveArmThenGripper, JointPositionActionMode)}
"""Name -> action mode that a policy may have."""
DEEPEST = 4
"""Maximum number of nested safety filters around an arm mode."""


def describe_action_mode(mode: ActionMode) -> dict[str, Any]:
    """Return an action mode as plain data: its class, the classes of its parts, and all their parameters.

    Raises:
        PolicySettingsError: A part is a custom class of the policy. It would run in the process of the simulation.
    """
    described: dict[str, Any] = {"mode": _name_of(mode, ACTION_MODES, "action mode")}
    if isinstance(mode, MoveArmThenGripper):
        for part, kinds, value in (
            ("arm", ARM_MODES, mode.arm_action_mode),
            ("gripper", GRIPPER_MODES, mode.gripper_action_mode),
        ):
            described[part] = _name_of(value, kinds, f"{part} action mode")
            described[f"{part}_settings"] = _settings_of(value)
    return described


def make_action_mode(described: Mapping[str, Any]) -> ActionMode:
    """Make an action mode from plain data; parameters that are left out have their defaults.

    Raises:
        PolicySettingsError: The data name an unknown mode or parameter, or contain a wrong value.
    """
    kind = _kind_of(_table(described, "action_mode"), "mode", ACTION_MODES)
    if kind is JointPositionActionMode:
        _entries(described, ["mode"], "action_mode")
        return JointPositionActionMode()
    _entries(described, ("mode", "arm", "arm_settings", "gripper", "gripper_settings"), "action_mode")
    parts = [
        _make(_kind_of(described, part, kinds), described.get(f"{part}_settings", {}), f"action_mode.{part}_settings")
        for part, kinds in (("arm", ARM_MODES), ("gripper", GRIPPER_MODES))
    ]
    return MoveArmThenGripper(*parts)


def parameters(kind: type) -> dict[str, Parameter]:
    """Return the parameters that a mode is made with, by name."""
    return {name: p for name, p in signature(kind).parameters.items() if p.kind is not Parameter.VAR_KEYWORD and p.name != "self"}


def _name_of(mode: object, kinds: Mapping[str, type], what: str) -> str:
    name = type(mode).__name__
    if kinds.get(name) is not type(mode):
        hint = f"Use one of {', '.join(kinds)}, and convert the actions of your own mode in the policy's `act`."
        raise PolicySettingsError(f"The {what} of a policy", mode, "has to be one of this package", hint)
    return name


def _settings_of(mode: object) -> dict[str, Any]:
    return {name: _plain_setting(getattr(mode, name)) for name in parameters(type(mode))}


def _plain_setting(value: object) -> Any:
    if isinstance(value, SafetyConfig):
        return asdict(value)
    if isinstance(value, RelativeFrame):
        return "end effector" if value is RelativeFrame.EE else "world"
    if isinstance(value, tuple | list):
        return [_plain_setting(item) for item in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return {"mode": _name_of(value, ARM_MODES, "arm action mode"), "mode_settings": _settings_of(value)}


def _make(kind: type, settings: object, what: str, depth: int = 0) -> Any:
    """Make a part from its class and its parameters."""
    chosen = dict(_entries(settings, parameters(kind), what))
    with _errors_about(what, settings, f"cannot make a {kind.__name__}"):
        return _make_safe_arm(chosen, what, depth) if kind is SafeArm else kind(**chosen)


def _make_safe_arm(chosen: dict[str, Any], what: str, depth: int) -> SafeArm:
    if depth >= DEEPEST:
        raise PolicySettingsError(what, chosen, f"has more than {DEEPEST} safety filters around one mode", "Use one.")
    inner = _entries(chosen.get("mode"), ("mode", "mode_settings"), f"{what}.mode")
    arm = _make(_kind_of(inner, "mode", ARM_MODES), inner.get("mode_settings", {}), f"{what}.mode_settings", depth + 1)
    config = chosen.get("config")
    return SafeArm(arm, None if config is None else SafetyConfig(**_table(config, f"{what}.config")))


def _table(value: object, what: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise PolicySettingsError(what, value, "has to be a table with names as keys")
    return value


def _kind_of(described: Mapping[str, Any], key: str, kinds: Mapping[str, type]) -> type:
    name = described.get(key)
    if not isinstance(name, str) or name not in kinds:
        near = nearest_name(name, tuple(kinds)) if isinstance(name, str) else None
        hint = f"Did you mean '{near}'?" if near else f"Known: {', '.join(kinds)}."
        raise PolicySettingsError(f"action_mode: '{key}'", name, "is not a mode of this package", hint)
    return kinds[name]


# Observations -----------------------------------------------------------------------------------------------------------------


_SPECIAL = ("cameras", "extra_cameras", "model", "lighting")
IDENTITY = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
LEFT_OUT = ("record_gripper_closing", "record_ignore_collisions")
"""Switches of demonstrations, which do not apply to policies."""


def blank_observations() -> ObservationConfig:
    """Return settings with no observations."""
    config = ObservationConfig(joint_poses=False, record_ignore_collisions=False)
    config.set_all(False)
    return config


def describe_observations(config: ObservationConfig) -> dict[str, Any]:
    """Return observation settings as plain data.

    Raises:
        PolicySettingsError: The settings or a noise model are a custom class, which would run in the process of the simulation.
    """
    _own(config, ObservationConfig, "obs_config")
    described = _differences(config, blank_observations(), (*LEFT_OUT, *_SPECIAL, *(f"{name}_camera" for name in CAMERAS)))
    cameras = {name: _camera(camera) for name, camera in config.cameras().items()}
    described.update({"cameras": used} if (used := {name: camera for name, camera in cameras.items() if camera}) else {})
    if config.extra_cameras:
        described["extra_cameras"] = {name: _extra_camera(extra) for name, extra in config.extra_cameras.items()}
    if config.model.is_used:
        described["model"] = {name: value for name, value in asdict(config.model).items() if value}
    if config.lighting != Lighting():
        described["lighting"] = _plain(config.lighting)
    return described


def make_observations(described: Mapping[str, Any]) -> ObservationConfig:
    """Make observation settings from plain data; observations that are left out are off.

    Raises:
        PolicySettingsError: An entry does not exist, or has a wrong value.
    """
    config = blank_observations()
    known = (*(f.name for f in fields(ObservationConfig) if not f.name.endswith("_camera")), "cameras")
    for name, value in _entries(described, known, "observation").items():
        with _errors_about(f"observation: '{name}'", value, "cannot be used"):
            if name == "cameras":
                for camera, entries in _entries(value, CAMERAS, "observation.cameras").items():
                    _fill(config.camera(camera), entries, f"observation.cameras.{camera}")
            elif name == "extra_cameras":
                for camera, entries in _table(value, "observation.extra_cameras").items():
                    config.add_camera(camera, _make_extra_camera(camera, entries))
            else:
                setattr(config, name, _value(name, value))
    with _errors_about("observation: 'cameras'", described.get("cameras"), "cannot be used"):
        config.check()
    return config


def _check_images(config: ObservationConfig) -> None:
    """Raise PolicySettingsError if the images of a policy need too much memory in the process that plays the episode."""
    cameras = {f"observation.cameras.{name}": camera for name, camera in config.cameras().items()}
    cameras |= {f"observation.extra_cameras.{name}.config": extra.config for name, extra in config.extra_cameras.items()}
    cameras = {name: camera for name, camera in cameras.items() if camera.is_used}
    size = 0
    for name, camera in cameras.items():
        width, height = camera.image_size
        if max(width, height) > LARGEST_IMAGE:
            problem = f"is larger than {LARGEST_IMAGE} x {LARGEST_IMAGE} px"
            raise PolicySettingsError(f"{name}.image_size", camera.image_size, problem, "Use a smaller image.")
        mask = 4 if camera.masks_as_one_channel else 12
        size += width * height * (3 * camera.rgb + 4 * camera.depth + 12 * camera.point_cloud + mask * camera.mask)
    if size > LARGEST_OBSERVATION:
        problem = f"have {size / 1e6:.1f} MB per observation; the maximum is {LARGEST_OBSERVATION / 1e6:.0f} MB"
        hint = "Reduce `image_size`, or leave products or cameras out."
        raise PolicySettingsError("The images of observation.cameras and extra_cameras", list(cameras), problem, hint)


# To plain data ----------------------------------------------------------------------------------------------------------------


def _own(value: object, kind: type, what: str) -> None:
    if type(value) is not kind:
        hint = f"Use rlbench_pin's {kind.__name__}, and change the observation in the policy's `act`."
        raise PolicySettingsError(f"{what} of a policy", value, f"has to be a {kind.__name__}, not a subclass", hint)


def _differences(record: object, blank: object, without: tuple[str, ...] = ()) -> dict[str, Any]:
    names = [f.name for f in fields(record) if f.name not in without]  # type: ignore[arg-type]
    pairs = {name: (_plain(getattr(record, name)), _plain(getattr(blank, name))) for name in names}
    return {name: value for name, (value, default) in pairs.items() if value != default}


def _blank_camera() -> CameraConfig:
    return CameraConfig(rgb=False, depth=False, point_cloud=False, mask=False)


def _camera(camera: CameraConfig) -> dict[str, Any]:
    _own(camera, CameraConfig, "A camera")
    return _differences(camera, _blank_camera())


def _extra_camera(extra: ExtraCamera) -> dict[str, Any]:
    _own(extra, ExtraCamera, "An extra camera")
    _check_parent(extra)
    blank = ExtraCamera(pose=IDENTITY)
    return {"pose": _plain(extra.pose), **_differences(extra, blank, ("pose", "config")), "config": _camera(extra.config)}


def _check_parent(extra: ExtraCamera) -> None:
    if extra.parent not in ("world", HAND):
        hint = "A camera on a body of the scene would reveal its pose."
        raise PolicySettingsError(
            "An extra camera of a policy", extra.parent, f"has to be fixed in the world or mounted on the {HAND}", hint
        )


def _plain(value: object) -> Any:
    if value is None or isinstance(value, bool | str | int):
        return value
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, np.ndarray | tuple | list):
        return [_plain(item) for item in value]
    if type(value) is Identity:
        return None
    if type(value) is GaussianNoise:
        return {"variance": value.variance, "min_max_clip": _plain(value.min_max_clip)}
    if type(value) in (Lighting, Light):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value)}  # type: ignore[arg-type]
    raise PolicySettingsError(
        "An observation of a policy", value, "has to have settings of this package", "Apply custom noise in the policy's `act`."
    )


# Back -------------------------------------------------------------------------------------------------------------------------


def _entries(value: object, known: Iterable[str], what: str) -> Mapping[str, Any]:
    """Return a table whose names are among those that are known."""
    table, known = _table(value, what), tuple(known)
    for name in table:
        if name not in known:
            near = nearest_name(name, known)
            hint = f"Did you mean '{near}'?" if near else f"Known: {', '.join(sorted(known)) or 'none'}."
            raise PolicySettingsError(what, name, "has no such entry", hint)
    return table


@contextmanager
def _errors_about(what: str, value: object, problem: str) -> Iterator[None]:
    """Raise errors from plain data as PolicySettingsError."""
    try:
        yield
    except PolicySettingsError:
        raise
    except (RlbenchPinError, TypeError, ValueError, LookupError, ArithmeticError) as error:
        raise PolicySettingsError(what, value, f"{problem}: {error}") from error


def _value(name: str, value: Any) -> Any:
    if name.endswith("_noise"):
        return _noise(value)
    if name == "model":
        return ModelObservationConfig(**_table(value, "observation.model"))
    if name == "lighting":
        return _lighting(_entries(value, tuple(f.name for f in fields(Lighting)), "observation.lighting"))
    return tuple(value) if name == "image_size" and isinstance(value, list) else value


def _noise(value: Any) -> Identity | GaussianNoise:
    if value is None:
        return Identity()
    noise = _entries(value, ("variance", "min_max_clip"), "noise")
    clip = noise.get("min_max_clip")
    ends = None if clip is None else (-math.inf if clip[0] is None else clip[0], math.inf if clip[1] is None else clip[1])
    return GaussianNoise(noise.get("variance", 0.0), ends)


def _lighting(entries: Mapping[str, Any]) -> Lighting:
    made = {name: value for name, value in entries.items() if name == "ambient"}
    if "key" in entries:
        made["key"] = _light(entries["key"])
    if "fills" in entries:
        made["fills"] = tuple(_light(light) for light in entries["fills"])
    return Lighting(**made)


def _light(value: Any) -> Light:
    light: dict[str, Any] = dict(_entries(value, ("direction", "intensity", "color"), "a light"))
    light.update({name: tuple(v) for name, v in light.items() if isinstance(v, list)})
    return Light(**light)


def _fill(camera: CameraConfig, entries: Any, what: str) -> CameraConfig:
    camera.set_all(False)
    for name, value in _entries(entries, tuple(f.name for f in fields(CameraConfig)), what).items():
        with _errors_about(f"observation: '{name}'", value, "cannot be used"):
            setattr(camera, name, _value(name, value))
    return camera


def _make_extra_camera(name: str, entries: Any) -> ExtraCamera:
    what = f"observation.extra_cameras.{name}"
    table = dict(_entries(entries, tuple(f.name for f in fields(ExtraCamera)), what))
    config = _fill(CameraConfig(), table.pop("config", {}), f"{what}.config")
    if "pose" not in table:
        raise PolicySettingsError(what, entries, "needs a 'pose' (7,): x, y, z [m], qx, qy, qz, qw")
    extra = ExtraCamera(**table, config=config)
    _check_parent(extra)
    return extra
