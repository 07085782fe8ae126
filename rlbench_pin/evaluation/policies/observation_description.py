"""What a policy observes as plain data, and back.

Only what is switched on, or differs from its default, is written; what is left out is off.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, fields
from typing import Any

import numpy as np

from rlbench_pin.environment.observations import ExtraCamera, GaussianNoise, Identity, ModelObservationConfig, ObservationConfig
from rlbench_pin.environment.observations.config import HAND, CameraConfig
from rlbench_pin.errors import RlbenchPinError, nearest_name
from rlbench_pin.evaluation.policies.faults import PolicySettingsError
from rlbench_pin.observation import CAMERAS
from rlbench_pin.sim import Light, Lighting

_SPECIAL = ("cameras", "extra_cameras", "model", "lighting")
IDENTITY = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
LEFT_OUT = ("record_gripper_closing", "record_ignore_collisions")
"""Switches of demonstrations, which policies never see."""


def blank_observations() -> ObservationConfig:
    """Return settings with which nothing is observed."""
    config = ObservationConfig(joint_poses=False, record_ignore_collisions=False)
    config.set_all(False)
    return config


def describe_observations(config: ObservationConfig) -> dict[str, Any]:
    """Return what is observed as plain data.

    Raises:
        PolicySettingsError: A noise model, or the record itself, is of the policy's own; it would run beside the simulation.
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
    """Make the settings from plain data; what is left out is off.

    Raises:
        PolicySettingsError: There is no such entry, or it has a wrong value.
    """
    config = blank_observations()
    known = (*(f.name for f in fields(ObservationConfig) if not f.name.endswith("_camera")), "cameras")
    for name, value in _entries(described, known, "observation").items():
        if name == "cameras":
            for camera, entries in _entries(value, CAMERAS, "observation.cameras").items():
                _made(lambda c=camera, e=entries: _fill(config.camera(c), e, f"observation.cameras.{c}"), name, entries)  # type: ignore[misc]
        elif name == "extra_cameras":
            for camera, entries in _table(value, "observation.extra_cameras").items():
                _made(lambda c=camera, e=entries: config.add_camera(c, _make_extra_camera(c, e)), camera, entries)  # type: ignore[misc]
        else:
            _made(lambda n=name, v=value: setattr(config, n, _value(n, v)), name, value)  # type: ignore[misc]
    _made(config.check, "cameras", described.get("cameras"))
    return config


# To plain data ----------------------------------------------------------------------------------------------------------------


def _own(value: object, kind: type, what: str) -> None:
    if type(value) is not kind:
        hint = f"Use rlbench_pin's {kind.__name__}, and change in the policy's `act` what it observes."
        raise PolicySettingsError(f"{what} of a policy", value, f"has to be a {kind.__name__} itself", hint)


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
        hint = "On a body of the scene it would tell where that is."
        raise PolicySettingsError(
            "An extra camera of a policy", extra.parent, f"stands in the world or rides on the {HAND}", hint
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
        "What a policy observes", value, "has to be settings of this package", "Apply noise of your own in the policy's `act`."
    )


# Back -------------------------------------------------------------------------------------------------------------------------


def _table(value: object, what: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise PolicySettingsError(what, value, "has to be a table with names as keys")
    return value


def _entries(value: object, known: tuple[str, ...], what: str) -> Mapping[str, Any]:
    table = _table(value, what)
    for name in table:
        if name not in known:
            near = nearest_name(name, known)
            raise PolicySettingsError(what, name, "has no such entry", f"Did you mean '{near}'?" if near else "")
    return table


def _made(make: Callable[[], Any], name: str, value: object) -> Any:
    """Call `make`, whose errors are about entry `name`."""
    try:
        return make()
    except PolicySettingsError:
        raise
    except (RlbenchPinError, TypeError, ValueError, LookupError, ArithmeticError) as error:
        raise PolicySettingsError(f"observation: '{name}'", value, f"cannot be used: {error}") from error


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
    ends = None if clip is None else (_end(clip[0], -math.inf), _end(clip[1], math.inf))
    return GaussianNoise(noise.get("variance", 0.0), ends)


def _end(value: Any, infinite: float) -> Any:
    return infinite if value is None else value


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
        _made(lambda n=name, v=value: setattr(camera, n, _value(n, v)), name, value)  # type: ignore[misc]
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
