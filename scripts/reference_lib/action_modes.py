"""The page about action modes, from the modes themselves and a running environment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby

from reference_lib.docs import doc_of, settings_table, table
from rlbench_pin.environment import (
    ActionMode,
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    Environment,
    ERJointViaIK,
    GripperJointPosition,
    JointPosition,
    JointPositionActionMode,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
    SafeArm,
)
from rlbench_pin.environment.actions import ActionSpec
from rlbench_pin.environment.actions.modes import Mode
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.environment.runtime import TIP_WORKSPACE, Runtime

Variants = Mapping[str, Mode]
"""What is written in Python -> the mode."""

ARM: Variants = {
    "JointVelocity()": JointVelocity(),
    "JointVelocity(absolute_mode=False)": JointVelocity(False),
    "JointPosition()": JointPosition(),
    "JointPosition(absolute_mode=False)": JointPosition(False),
    "JointTorque()": JointTorque(),
    "JointTorque(absolute_mode=False)": JointTorque(False),
    "EndEffectorVelocity()": EndEffectorVelocity(),
    'EndEffectorVelocity(frame="end effector")': EndEffectorVelocity(frame="end effector"),
    "EndEffectorPoseViaPlanning()": EndEffectorPoseViaPlanning(),
    "EndEffectorPoseViaPlanning(absolute_mode=False)": EndEffectorPoseViaPlanning(False),
    'EndEffectorPoseViaPlanning(frame="end effector")': EndEffectorPoseViaPlanning(frame="end effector"),
    "EndEffectorPoseViaIK()": EndEffectorPoseViaIK(),
    "EndEffectorPoseViaIK(absolute_mode=False)": EndEffectorPoseViaIK(False),
    'EndEffectorPoseViaIK(frame="end effector")': EndEffectorPoseViaIK(frame="end effector"),
    "ERJointViaIK()": ERJointViaIK(),
    "ERJointViaIK(absolute_mode=False)": ERJointViaIK(False),
    "SafeArm(JointVelocity())": SafeArm(JointVelocity()),
}
GRIPPER: Variants = {
    "Discrete()": Discrete(),
    "GripperJointPosition()": GripperJointPosition(),
    "GripperJointPosition(absolute_mode=False)": GripperJointPosition(absolute_mode=False),
}
WHOLE: Variants = {
    "MoveArmThenGripper(JointVelocity(), Discrete())": MoveArmThenGripper(JointVelocity(), Discrete()),
    "JointPositionActionMode()": JointPositionActionMode(),
}


def parts() -> dict[str, str]:
    """Return what the page has generated, by marker."""
    with Environment(JointPositionActionMode(), obs_config=low_dim_config()) as environment:
        runtime = environment.get_task("reach_target").runtime
        return {
            "workspace": _workspace(),
            "overview": _overview(runtime),
            "arm": _sections(ARM, runtime),
            "gripper": _sections(GRIPPER, runtime),
            "whole": _sections(WHOLE, runtime),
        }


def _workspace() -> str:
    spans = [f"{axis} {_number(low)} to {_number(high)}" for axis, low, high in zip("xyz", *TIP_WORKSPACE, strict=True)]
    return f"The workspace box of tip targets, in the world frame: {', '.join(spans)} m."


def _overview(runtime: Runtime) -> str:
    rows = []
    for name, mode in {**ARM, **GRIPPER, **WHOLE}.items():
        spec = mode.spec(runtime)
        units = ", ".join(dict.fromkeys(unit for unit in spec.units))
        rows.append((f"`{name}`", str(spec.size), units, spec.frame, _ticks(spec)))
    return table(("Mode", "Numbers", "Units", "Frame", "Ticks"), rows, "lrlll")


def _ticks(spec: ActionSpec) -> str:
    return "as the motion takes" if spec.ticks is None else str(spec.ticks)


def _sections(variants: Variants, runtime: Runtime) -> str:
    by_class: dict[type, list[tuple[str, Mode]]] = {}
    for name, mode in variants.items():
        by_class.setdefault(type(mode), []).append((name, mode))
    return "\n\n".join("\n\n".join(_section(cls, modes, runtime)) for cls, modes in by_class.items())


def _section(cls: type, modes: list[tuple[str, Mode]], runtime: Runtime) -> Iterator[str]:
    yield f"### {cls.__name__}"
    yield doc_of(cls).text
    if settings := settings_table(cls):
        yield settings
    if cls is SafeArm or (issubclass(cls, ActionMode) and cls is not JointPositionActionMode):
        return  # the numbers are those of its parts
    alike: dict[tuple[tuple[str, ...], ...], list[str]] = {}
    for name, mode in modes:
        alike.setdefault(tuple(_rows(mode.spec(runtime))), []).append(f"`{name}`")
    rows = [(", ".join(names), *row) for numbers, names in alike.items() for row in numbers]
    yield table(("Mode", "Numbers", "Unit", "Lowest", "Highest"), rows, "lllrr")


def _rows(spec: ActionSpec) -> Iterator[tuple[str, str, str, str]]:
    """Yield names, unit, lowest, highest; neighbours that differ in their name alone share a row."""
    numbers = zip(spec.names, spec.units, spec.low, spec.high, strict=True)
    for (unit, low, high), group in groupby(numbers, key=lambda n: (n[1], _number(n[2]), _number(n[3]))):
        yield _names([number[0] for number in group]), unit, low, high


def _names(names: Sequence[str]) -> str:
    """Return names of numbers; joints that follow each other by the first and the last."""
    if len(names) > 2 and names[0].rstrip("0123456789") == names[-1].rstrip("0123456789"):
        return f"`{names[0]}` to `{names[-1]}`"
    return ", ".join(f"`{name}`" for name in names)


def _number(value: float) -> str:
    return f"{value:.4g}"
