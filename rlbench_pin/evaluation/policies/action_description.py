"""Action modes of this package as plain data, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from inspect import Parameter, signature
from typing import Any

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
from rlbench_pin.errors import RlbenchPinError, nearest_name, shown
from rlbench_pin.evaluation.policies.faults import PolicySettingsError

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
WHOLE_MODES: Mapping[str, type] = {kind.__name__: kind for kind in (MoveArmThenGripper, JointPositionActionMode)}
"""Name -> action mode that a policy may have."""
DEEPEST = 4
"""So many safety filters may be around an arm mode."""


def describe_action_mode(mode: ActionMode) -> dict[str, Any]:
    """Return an action mode as plain data: its class, those of its parts, and every parameter they were made with.

    Raises:
        PolicySettingsError: A part is a class of the policy's own. It would run beside the simulation, not with the policy.
    """
    described: dict[str, Any] = {"mode": _name_of(mode, WHOLE_MODES, "action mode")}
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
        PolicySettingsError: The data name no mode, or a parameter that it has not, or one with a wrong value.
    """
    described = _mapping(described, "action_mode")
    kind = _kind_of(described, "mode", WHOLE_MODES)
    wanted = {"mode"} if kind is JointPositionActionMode else {"mode", "arm", "arm_settings", "gripper", "gripper_settings"}
    _refuse_unknown(described, wanted, "action_mode")
    if kind is JointPositionActionMode:
        return JointPositionActionMode()
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
        hint = f"Use one of {', '.join(kinds)}, and translate in the policy's `act` what your own mode would do."
        raise PolicySettingsError(f"The {what} of a policy", mode, "has to be one of this package", hint)
    return name


def _settings_of(mode: object) -> dict[str, Any]:
    return {name: _plain(getattr(mode, name)) for name in parameters(type(mode))} if parameters(type(mode)) else {}


def _plain(value: object) -> Any:
    if isinstance(value, SafetyConfig):
        return asdict(value)
    if isinstance(value, RelativeFrame):
        return "end effector" if value is RelativeFrame.EE else "world"
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return {"mode": _name_of(value, ARM_MODES, "arm action mode"), "mode_settings": _settings_of(value)}


def _make(kind: type, settings: object, what: str, depth: int = 0) -> Any:
    """Make a part from its class and its parameters."""
    chosen = dict(_mapping(settings, what))
    _refuse_unknown(chosen, set(parameters(kind)), what)
    try:
        if kind is SafeArm:
            return _make_safe_arm(chosen, what, depth)
        return kind(**chosen)
    except PolicySettingsError:
        raise
    except (RlbenchPinError, TypeError, ValueError, LookupError, ArithmeticError) as error:
        raise PolicySettingsError(what, settings, f"makes no {kind.__name__}: {error}") from error


def _make_safe_arm(chosen: dict[str, Any], what: str, depth: int) -> SafeArm:
    inner = _mapping(chosen.get("mode"), f"{what}.mode")
    if depth >= DEEPEST:
        raise PolicySettingsError(what, chosen, f"has more than {DEEPEST} safety filters around one mode")
    _refuse_unknown(inner, {"mode", "mode_settings"}, f"{what}.mode")
    arm = _make(_kind_of(inner, "mode", ARM_MODES), inner.get("mode_settings", {}), f"{what}.mode_settings", depth + 1)
    config = chosen.get("config")
    return SafeArm(arm, None if config is None else SafetyConfig(**_mapping(config, f"{what}.config")))


def _mapping(value: object, what: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise PolicySettingsError(what, value, "has to be a table with names as keys")
    return value


def _kind_of(described: Mapping[str, Any], key: str, kinds: Mapping[str, type]) -> type:
    name = described.get(key)
    if not isinstance(name, str) or name not in kinds:
        near = nearest_name(name, tuple(kinds)) if isinstance(name, str) else None
        hint = f"Did you mean '{near}'?" if near else f"Known: {', '.join(kinds)}."
        raise PolicySettingsError(f"action_mode: '{key}'", name, "is no mode of this package", hint)
    return kinds[name]


def _refuse_unknown(given: Mapping[str, Any], known: set[str], what: str) -> None:
    unknown = sorted(set(given) - known)
    if unknown:
        hint = f"Known: {', '.join(sorted(known)) or 'none'}."
        raise PolicySettingsError(what, shown(unknown[0]), "has no such entry", hint)
