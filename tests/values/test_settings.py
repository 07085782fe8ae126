"""Records of settings refuse names that there are not and values that make no sense, when they are made and later."""

from __future__ import annotations

import copy
import pickle
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

from rlbench_pin.control import (
    DifferentialIKConfig,
    GripperConfig,
    OperationalSpaceConfig,
    PoseIKConfig,
    PostureObjective,
    PredictiveConfig,
    SafetyConfig,
    TipObjective,
)
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.environment.observations import CameraConfig, ExtraCamera, GaussianNoise
from rlbench_pin.environment.observations.config import ModelObservationConfig
from rlbench_pin.environment.randomization.config import DynamicsRandomizationConfig, VisualRandomizationConfig
from rlbench_pin.errors import InvalidValue, RlbenchPinError, UnknownName, UnknownSetting
from rlbench_pin.observation import Observation
from rlbench_pin.planning import PlannerConfig
from rlbench_pin.recording.config import RecordConfig
from rlbench_pin.values import POSITIVE, Settings

NEVER = (float("nan"), -1.0, "1", None, [1.0])


@pytest.mark.parametrize(
    ("kind", "names", "more"),
    [
        (SafetyConfig, "dt margin self_margin buffer gain influence recovery_speed limit_margin hold", {}),
        (PoseIKConfig, "position_tolerance rotation_tolerance rotation_weight damping step steps patience starts", {}),
        (GripperConfig, "dt speed lead tolerance stall_time stall_speed slip", {"widest": 0.08, "force": 20.0}),
        (OperationalSpaceConfig, "dt tip_frequency pull turning_pull posture_frequency rotation_weight limit_margin", {}),
        (PredictiveConfig, "dt horizon position_weight slack_weight pairs margin self_margin tolerance iterations", {}),
        (DifferentialIKConfig, "dt limit_margin hold tip posture", {}),
        (TipObjective, "linear_speed angular_speed linear_acceleration position_weight rotation_weight", {}),
        (PostureObjective, "gain weight singular_weight singular_below", {}),
        (
            PlannerConfig,
            "max_velocity max_acceleration jerk_time margin checks ik_starts edge_step check_step attempts elbows",
            {},
        ),
        (ModelObservationConfig, "tip_jacobian gravity world_distances self_distances", {}),
        (RecordConfig, "episodes seed max_attempts max_velocity max_acceleration per_variation", {"tasks": ("reach_target",)}),
    ],
)
def test_frozen_settings_refuse_senseless_values(kind: type[Any], names: str, more: dict[str, object]) -> None:
    """NaN, negative numbers, text and None are named with record and field; so are unknown names."""
    for name in names.split():
        for value in NEVER:
            with pytest.raises(InvalidValue, match=name):
                kind(**{**more, name: value})
    with pytest.raises(AttributeError):
        kind(**more).unknown = 1


@pytest.mark.parametrize(
    ("kind", "change"),
    [(SafetyConfig, {"dt": 0}), (PredictiveConfig, {"horizon": 0}), (PlannerConfig, {"max_velocity": 0.0})],
)
def test_zero_ticks_horizons_and_speeds(kind: type[Any], change: dict[str, object]) -> None:
    """They would divide by zero far away."""
    with pytest.raises(InvalidValue, match="Got 0"):
        kind(**change)


def test_a_misspelt_setting_names_the_one_that_was_meant() -> None:
    """As an AttributeError, too; private names and those of subclasses are free."""
    config = ObservationConfig()
    with pytest.raises(UnknownSetting, match="'rbg'. Did you mean 'rgb'") as caught:
        config.front_camera.rbg = True  # type: ignore[attr-defined]
    assert isinstance(caught.value, AttributeError)
    assert isinstance(caught.value, UnknownName)
    with pytest.raises(UnknownSetting, match="Did you mean 'joint_positions'"):
        config.joint_position = False  # type: ignore[attr-defined]
    with pytest.raises(UnknownSetting, match="Did you mean 'variance'"):
        GaussianNoise(0.1).varianc = 1.0  # type: ignore[attr-defined]
    assert "rbg" not in vars(config.front_camera)
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.name, again.record) == (str(caught.value), "rbg", "CameraConfig")


def test_subclasses_may_have_more() -> None:
    """Fields of a dataclass, annotated names and properties are known; rules of the base hold."""

    @dataclass
    class Mine(Settings):
        rules: ClassVar[dict[str, Any]] = {"speed": POSITIVE}
        speed: float = 1.0
        label: str = ""

    class Yours(Mine):
        extra: int

        def __init__(self) -> None:
            super().__init__(2.0)
            self.extra, self._hidden = 3, 4

    yours = Yours()
    assert (yours.speed, yours.extra) == (2.0, 3)
    with pytest.raises(InvalidValue, match=r"Yours\.speed"):
        yours.speed = 0.0
    with pytest.raises(UnknownSetting):
        yours.extras = 1  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("name", "value"),
    [("image_size", 0), ("image_size", "64"), ("rgb", "no"), ("depth_noise", 0.1), ("rgb_noise", GaussianNoise), ("mask", None)],
)
def test_cameras_check_what_is_set(name: str, value: object) -> None:
    """When they are made and later; a refused value changes nothing."""
    with pytest.raises(InvalidValue, match=name):
        CameraConfig(**{name: value})  # type: ignore[arg-type]
    camera = CameraConfig()
    before = getattr(camera, name)
    with pytest.raises(InvalidValue, match=name):
        setattr(camera, name, value)
    assert getattr(camera, name) is before


def test_sizes_and_switches_are_kept_as_they_are_used() -> None:
    """One number is a square picture, a list a pair, 1 is True; copies and pickles are the same."""
    camera = CameraConfig(image_size=[64, 32])  # type: ignore[arg-type]
    camera.rgb = 0  # type: ignore[assignment]
    assert (camera.image_size, camera.rgb) == ((64, 32), False)
    camera.image_size = np.int64(48)  # type: ignore[assignment]
    assert camera.image_size == (48, 48)
    assert replace(camera).image_size == copy.deepcopy(camera).image_size == (48, 48)
    config = ObservationConfig(front_camera=camera)
    assert pickle.loads(pickle.dumps(config)).front_camera.image_size == (48, 48)


@pytest.mark.parametrize(
    ("variance", "clip"),
    [(float("nan"), None), (-1.0, None), ("1", None), (True, None), (0.1, (1, 0)), (0.1, (0.0, float("nan"))), (0.1, 1.0)],
)
def test_noise_is_a_deviation_and_bounds_in_order(variance: Any, clip: Any) -> None:
    """NaN would spoil every observation."""
    with pytest.raises(InvalidValue, match="GaussianNoise"):
        GaussianNoise(variance, clip)


def test_records_within_settings() -> None:
    """Cameras, lights, noise and models are records of their kind."""
    for change in (
        {"front_camera": "front"},
        {"lighting": 0.5},
        {"model": {}},
        {"joint_positions_noise": 0.1},
        {"joint_poses": "x"},
    ):
        with pytest.raises(RlbenchPinError, match=next(iter(change))):
            ObservationConfig(**change)  # type: ignore[arg-type]
    assert ObservationConfig(front_camera=None).front_camera.rgb  # type: ignore[arg-type]
    for change in ({"fov": float("nan")}, {"near": -1.0}, {"far": "1"}, {"config": None}, {"fov": 4.0}):
        with pytest.raises(InvalidValue, match=next(iter(change))):
            ExtraCamera(**{"pose": [0, 0, 0, 0, 0, 0, 1], **change})


def test_randomization() -> None:
    """Factors are positive and in order, names are lists."""
    for change in (
        {"mass": (1.0, 0.5)},
        {"gains": (float("nan"), 1.0)},
        {"friction": 1.0},
        {"whitelist": "cup"},
        {"damping": (0, 1)},
    ):
        with pytest.raises(RlbenchPinError, match=next(iter(change))):
            DynamicsRandomizationConfig(**change)  # type: ignore[arg-type]
    for change in ({"light": float("nan")}, {"camera_shift": -1.0}, {"textures": "yes"}, {"blacklist": "cup"}):
        with pytest.raises(RlbenchPinError, match=next(iter(change))):
            VisualRandomizationConfig(**change)  # type: ignore[arg-type]


def test_observations_stay_open() -> None:
    """They are data: programs put on them what they like."""
    observation = Observation()
    observation.anything = 1  # type: ignore[attr-defined]
    assert observation.anything == 1  # type: ignore[attr-defined]
