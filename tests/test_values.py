"""Checks of values where they enter."""

from __future__ import annotations

import copy
import inspect
import pickle
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

from rlbench_pin import control
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
from rlbench_pin.environment.observations.config import ModelObservationConfig
from rlbench_pin.environment.randomization.config import DynamicsRandomizationConfig, VisualRandomizationConfig
from rlbench_pin.errors import InvalidArgument, InvalidValue, RlbenchPinError, TaskEnvironmentError, UnknownName, UnknownSetting
from rlbench_pin.observation import Observation
from rlbench_pin.planning import PlannerConfig, PoseRegion, TorqueLimits
from rlbench_pin.recording.config import ImageConfig, RecordConfig
from rlbench_pin.robot.description import robot_description
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.sim import CameraView, Light, Lighting
from rlbench_pin.spatial import compose, pose_to_se3
from rlbench_pin.values import (
    LARGEST_SEED,
    POSITIVE,
    Settings,
    as_array,
    as_choice,
    as_flag,
    as_image_size,
    as_interval,
    as_number,
    as_pose,
    as_rows,
    as_seed,
    as_vector,
    as_whole,
)

NO_NUMBERS = ("1", b"1", None, True, np.True_, 1j, [1.0], np.array([1.0]), np.datetime64("2026-01-01"), object(), float("nan"))


class Unshowable:
    """An object that refuses to be shown."""

    def __repr__(self) -> str:
        """Raise."""
        raise RuntimeError("no")


@pytest.mark.parametrize("value", [*NO_NUMBERS, float("inf"), -float("inf"), 10**400])
def test_what_is_no_finite_number_is_refused(value: object) -> None:
    """Text, truth values, arrays, dates, NaN and infinity; the error is a ValueError and carries what was given."""
    with pytest.raises(InvalidValue, match="margin has to be a finite number") as caught:
        as_number(value, "margin")
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, RlbenchPinError)
    assert (caught.value.what, caught.value.value) == ("margin", value) or value is not caught.value.value


@pytest.mark.parametrize("value", [1, 1.5, np.float32(1.5), np.int8(3), np.float64(2.0), -0.0])
def test_numbers_of_python_and_numpy_become_floats(value: float) -> None:
    """Whatever their width."""
    assert as_number(value, "x") == float(value)
    assert type(as_number(value, "x")) is float


def test_ranges_are_said() -> None:
    """The message has the range, and the bounds belong to it as it says."""
    assert as_number(0.0, "x", least=0.0) == 0.0
    assert as_number(float("inf"), "x", finite=False) == float("inf")
    with pytest.raises(InvalidValue, match=r"x has to be a finite number > 0\. Got 0\."):
        as_number(0, "x", above=0.0)
    with pytest.raises(InvalidValue, match=r">= 1 and <= 2\. Got 3"):
        as_whole(3, "x", least=1, most=2)


@pytest.mark.parametrize("value", [*NO_NUMBERS, 1.5, 1.0, float("inf")])
def test_what_is_no_whole_number_is_refused(value: object) -> None:
    """1.0 is none either: whoever computes a count says how it is rounded."""
    with pytest.raises(InvalidValue, match="whole number"):
        as_whole(value, "count")


@pytest.mark.parametrize("kind", [np.uint8, np.int8, np.int16, np.uint32, np.int64, np.uint64, int])
def test_whole_numbers_of_any_width_do_not_wrap(kind: Callable[[int], object]) -> None:
    """The largest value of each type can be counted on."""
    largest = int(np.iinfo(kind).max) if kind is not int else 10**30  # type: ignore[type-var]
    number = as_whole(kind(largest), "n")
    assert type(number) is int
    assert number + 1 == largest + 1


def test_seeds_are_what_episode_files_hold() -> None:
    """From 0 to 2^63 - 1."""
    assert as_seed(np.uint8(255)) == 255
    assert as_seed(LARGEST_SEED) == 2**63 - 1
    for seed in (-1, 2**63, np.uint64(2**63), True, 1.5, "1", None):
        with pytest.raises(InvalidArgument, match="seed") as caught:
            as_seed(seed, error=InvalidArgument)
        assert isinstance(caught.value, TaskEnvironmentError)


def test_switches_are_truth_values() -> None:
    """0 and 1 stand for them, other numbers and text do not."""
    assert [as_flag(value, "x") for value in (True, np.False_, 0, 1)] == [True, False, False, True]
    for value in ("no", 2, None, 0.0, [], np.array([True])):
        with pytest.raises(InvalidValue, match="x has to be True or False"):
            as_flag(value, "x")


def test_sizes_of_pictures() -> None:
    """A pair, or one number for both sides."""
    assert as_image_size(64, "size") == (64, 64)
    assert as_image_size([64, np.int16(32)], "size") == (64, 32)
    assert as_image_size(np.array([64, 32]), "size") == (64, 32)
    for size in (0, -1, 64.0, True, "64", "ab", (64,), (64, 64, 3), (64, 0), (64, 1.5), None, (64, 10**9), {64, 32}):
        with pytest.raises(InvalidValue, match="size"):
            as_image_size(size, "size")


def test_intervals_are_in_order() -> None:
    """The lower bound comes first."""
    assert as_interval([0, np.float32(1.0)], "clip") == (0.0, 1.0)
    with pytest.raises(InvalidValue, match="lower bound above"):
        as_interval((1, 0), "clip")
    for value in ((0.0,), "01", None, 1.0, (0.0, float("nan")), (0.0, 1.0, 2.0), (False, True)):
        with pytest.raises(InvalidValue):
            as_interval(value, "clip")


def test_words() -> None:
    """One of a list; the nearest is named."""
    assert as_choice("cpu", "renderer", ("cpu", "egl")) == "cpu"
    with pytest.raises(UnknownName, match="Did you mean 'cpu'"):
        as_choice("cppu", "renderer", ("cpu", "egl"))
    with pytest.raises(UnknownName):
        as_choice(["cpu"], "renderer", ("cpu", "egl"))


def test_any_object_can_be_shown() -> None:
    """Long values are cut, and an object that refuses to be shown is named by its class."""
    with pytest.raises(InvalidValue, match="a Unshowable"):
        as_number(Unshowable(), "x")
    with pytest.raises(InvalidValue) as caught:
        as_number("y" * 10_000, "x")
    assert len(str(caught.value)) < 300


HOME = np.array([0.0, 0.5, 1.0])
NO_ARRAYS = {
    "complex": HOME.astype(complex),
    "text": ["0", "0.5", "1"],
    "bytes": np.array([b"0", b"1", b"2"]),
    "dates": np.array(["2026-01-01"] * 3, dtype="datetime64[D]"),
    "spans": np.array([1, 2, 3], dtype="timedelta64[s]"),
    "objects": HOME.astype(object),
    "none": [0.0, None, 1.0],
    "huge": [10**400, 0, 0],
    "masked": np.ma.masked_array(HOME, [True, False, False]),
    "list of masked": [np.ma.masked_array(HOME, [True, False, False])],
    "ragged": [[1.0], [1.0, 2.0]],
    "object": object(),
    "mapping": {"a": 1.0},
    "set": {0.0, 1.0, 2.0},
}


@pytest.mark.parametrize("name", NO_ARRAYS)
def test_what_holds_no_real_numbers_is_refused(name: str) -> None:
    """Nothing is turned into numbers silently, and no warning is raised in place of an error."""
    with pytest.raises(InvalidValue, match="the target"):
        as_array(NO_ARRAYS[name], "the target")


def test_arrays_of_any_number_type_become_float64() -> None:
    """Lists, tuples, float16, integers; an unmasked masked array is an array."""
    for value in ([0, 0.5, 1], (0.0, 0.5, 1.0), HOME.astype(np.float16), np.ma.masked_array(HOME)):
        array = as_vector(value, 3, "q")
        assert array.dtype == np.float64
        np.testing.assert_array_equal(array, HOME)
    assert as_vector(HOME, 3, "q") is HOME


def test_shapes_and_places_are_named() -> None:
    """What was wanted, what was given, and where NaN is."""
    with pytest.raises(InvalidValue, match=r"q has to have shape \(3,\), not \(2,\)"):
        as_vector([0.0, 1.0], 3, "q")
    with pytest.raises(InvalidValue, match=r"NaN or infinity is at 1, 2"):
        as_vector([0.0, float("nan"), float("inf")], 3, "q")
    with pytest.raises(InvalidValue, match=r"\(m, 3\) with at least 2 rows"):
        as_rows([HOME], 3, "path", least=2)
    assert as_rows([HOME, HOME], 3, "path").shape == (2, 3)


def test_poses_have_a_rotation() -> None:
    """A quaternion of norm zero is refused, others are brought to length 1, or refused beyond a tolerance."""
    np.testing.assert_allclose(as_pose([1, 2, 3, 0, 0, 0, 2]), [1, 2, 3, 0, 0, 0, 1])
    with pytest.raises(InvalidValue, match="norm zero"):
        as_pose(np.zeros(7))
    with pytest.raises(InvalidValue, match="norm 2.0000, not 1"):
        as_pose([1, 2, 3, 0, 0, 0, 2], tolerance=1e-3)
    with pytest.raises(InvalidValue):
        as_pose([0, 0, 0, 0, 0, 0, float("inf")])


@pytest.mark.parametrize("pose", [np.zeros(7), np.full(7, np.nan), np.zeros(6), [0.0, 0.0, 0.0], np.zeros((2, 7))])
def test_the_pose_conventions_refuse_what_is_no_pose(pose: np.ndarray) -> None:
    """No NaN comes out of `compose` and its like."""
    with pytest.raises(InvalidValue, match="A pose"):
        pose_to_se3(pose)
    with pytest.raises(InvalidValue):
        compose([0, 0, 0, 0, 0, 0, 1], pose)


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
    """One number is a square image, a list a pair, 1 is True; copies and pickles are the same."""
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


HOSTILE: tuple[object, ...] = (
    None, float("nan"), float("inf"), -1, 0, 1.5, "x", "1", b"1", True, [], {}, object(), 10**400, 2**64, 1j, (1, 0), int,
    np.ma.masked, np.datetime64("now"), np.zeros(3), np.array("x"),
)  # fmt: skip
KINDS: tuple[Callable[..., object], ...] = (
    CameraConfig, CameraView, DynamicsRandomizationConfig, Environment, EndEffectorPoseViaPlanning, EndEffectorVelocity,
    ERJointViaIK, ExtraCamera, GaussianNoise, GripperJointPosition, JointVelocity, Light, Lighting, ObservationConfig,
    ImageConfig, PlannerConfig, PoseRegion, RecordConfig, SafeArm, TorqueLimits, VisualRandomizationConfig,
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
