"""Whatever is given to a constructor, it is taken, or refused by an error of ours that has a text."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from rlbench_pin import control
from rlbench_pin.environment import (
    CameraConfig,
    Discrete,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    Environment,
    ERJointViaIK,
    GaussianNoise,
    GripperJointPosition,
    JointVelocity,
    MoveArmThenGripper,
    ObservationConfig,
    SafeArm,
)
from rlbench_pin.environment.observations import ExtraCamera
from rlbench_pin.environment.randomization.config import DynamicsRandomizationConfig, VisualRandomizationConfig
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.planning import PlannerConfig, PoseRegion, TorqueLimits
from rlbench_pin.recording.config import PictureConfig, RecordConfig
from rlbench_pin.robot.description import robot_description
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.sim import CameraView, Light, Lighting

HOSTILE: tuple[object, ...] = (
    None, float("nan"), float("inf"), -1, 0, 1.5, "x", "1", b"1", True, [], {}, object(), 10**400, 2**64, 1j, (1, 0), int,
    np.ma.masked, np.datetime64("now"), np.zeros(3), np.array("x"),
)  # fmt: skip
KINDS: tuple[Callable[..., object], ...] = (
    CameraConfig, CameraView, DynamicsRandomizationConfig, Environment, EndEffectorPoseViaPlanning, EndEffectorVelocity,
    ERJointViaIK, ExtraCamera, GaussianNoise, GripperJointPosition, JointVelocity, Light, Lighting, ObservationConfig,
    PictureConfig, PlannerConfig, PoseRegion, RecordConfig, SafeArm, TorqueLimits, VisualRandomizationConfig,
    control.CartesianImpedance, control.CartesianMPC, control.ComputedTorque, control.DifferentialIK,
    control.DifferentialIKConfig, control.GripperConfig, control.JointImpedance, control.OperationalSpaceConfig,
    control.OperationalSpaceQP, control.PoseIK, control.PoseIKConfig, control.PostureObjective, control.PredictiveConfig,
    control.SafetyConfig, control.SafetyFilter, control.TipObjective, control.VelocityFollowing,
)  # fmt: skip


@pytest.fixture(scope="module")
def needed() -> dict[str, Any]:
    """Arguments that have no default, by name."""
    model = RobotModel(robot_description("panda"))
    return {
        "model": model, "limits": model.limits, "action_mode": MoveArmThenGripper(JointVelocity(), Discrete()),
        "tasks": ("reach_target",), "widest": 0.08, "force": 20.0, "pose": [0, 0, 0, 0, 0, 0, 1], "fov": 1.0, "size": (8, 8),
        "near": 0.1, "far": 1.0, "direction": (0, 0, 1), "intensity": 0.5, "variance": 0.1, "center": (0, 0, 0, 0, 0, 0, 1),
        "mode": JointVelocity(), "dt": 0.05,
    }  # fmt: skip


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_constructors_take_or_refuse(kind: Callable[..., object], needed: dict[str, Any]) -> None:
    """Every argument with every hostile value: no other error comes out."""
    parameters = inspect.signature(kind).parameters
    given = {name: needed[name] for name, p in parameters.items() if p.default is p.empty and name in needed}
    for name in parameters:
        for value in HOSTILE:
            try:
                kind(**{**given, name: value})
            except RlbenchPinError as error:
                assert len(str(error)) > 10, (name, value)
