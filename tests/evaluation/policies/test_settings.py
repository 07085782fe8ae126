"""What a policy asks for survives the way through plain data, all of it, and nothing of its own comes along."""

from __future__ import annotations

import json
from dataclasses import fields
from inspect import signature
from typing import Any

import numpy as np
import pytest

from rlbench_pin.control import SafetyConfig
from rlbench_pin.environment import (
    CameraConfig,
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    ERJointViaIK,
    ExtraCamera,
    GaussianNoise,
    GripperJointPosition,
    JointPosition,
    JointPositionActionMode,
    JointTorque,
    JointVelocity,
    ModelObservationConfig,
    MoveArmThenGripper,
    ObservationConfig,
    SafeArm,
)
from rlbench_pin.evaluation.policies import PolicySettings, PolicySettingsError
from rlbench_pin.evaluation.policies.settings import (
    ACTION_MODES,
    ARM_MODES,
    GRIPPER_MODES,
    describe_observations,
    make_observations,
)
from rlbench_pin.observation import CAMERAS
from rlbench_pin.sim import Light, Lighting
from tests.evaluation.policies.policies_for_tests import OwnMode

OTHER: dict[str, Any] = {
    "absolute_mode": False, "frame": "end effector", "collision_checking": True, "retry_without_checks": True,
    "commanded_joints": [0], "eps": 0.02, "delta_angle": True, "attach_grasped_objects": False, "detach_before_open": False,
}  # fmt: skip
"""A value of each parameter that is not its default."""


def varied(kind: type) -> Any:
    """Make a mode none of whose parameters has its default."""
    if kind is SafeArm:
        return SafeArm(varied(EndEffectorVelocity), SafetyConfig(margin=0.02, hold="any"))
    return kind(**{name: OTHER[name] for name in signature(kind).parameters})


def through_json(mode: Any, config: ObservationConfig, steps: int | None = None) -> PolicySettings:
    """Return settings after a way through a file, and check that they are the same."""
    before = PolicySettings.of(mode, config, steps)
    after = PolicySettings(**json.loads(json.dumps(vars(before), allow_nan=False)))
    assert after == before
    return after


def parts(mode: Any) -> Any:
    """Return class and settings of a mode and of the modes in it."""
    found = {k: v for k, v in vars(mode).items() if k not in ("counts", "last")}
    return type(mode), {k: parts(v) if type(v) in (*ARM_MODES.values(), *GRIPPER_MODES.values()) else v for k, v in found.items()}


@pytest.mark.parametrize("gripper", GRIPPER_MODES.values(), ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("arm", ARM_MODES.values(), ids=lambda kind: kind.__name__)
def test_every_mode_with_every_parameter(arm: type, gripper: type) -> None:
    """Made again, a mode has the classes and the parameters that it had, whether defaults or not."""
    plain = MoveArmThenGripper(SafeArm(JointVelocity()) if arm is SafeArm else arm(), gripper())
    for mode in (MoveArmThenGripper(varied(arm), varied(gripper)), plain):
        again = through_json(mode, ObservationConfig()).make_action_mode()
        assert parts(again) == parts(mode)


def test_the_modes_are_all_that_there_are() -> None:
    """A mode that is added to the package is added to the description too."""
    known = {*ARM_MODES.values(), *GRIPPER_MODES.values()}
    assert known == {
        JointVelocity, JointPosition, JointTorque, EndEffectorVelocity, EndEffectorPoseViaPlanning, EndEffectorPoseViaIK,
        ERJointViaIK, SafeArm, Discrete, GripperJointPosition,
    }  # fmt: skip
    assert set(ACTION_MODES.values()) == {MoveArmThenGripper, JointPositionActionMode}
    again = through_json(JointPositionActionMode(), ObservationConfig(), 12)
    assert type(again.make_action_mode()) is JointPositionActionMode and again.max_steps == 12


@pytest.mark.parametrize(
    "mode",
    [OwnMode(JointVelocity(), Discrete()), MoveArmThenGripper(type("Mine", (JointVelocity,), {})(), Discrete()),
     MoveArmThenGripper(SafeArm(type("Mine", (JointVelocity,), {})()), Discrete()), None, "JointVelocity"],
)  # fmt: skip
def test_modes_of_others_are_refused(mode: Any) -> None:
    """They would run beside the simulation; the error says what to do instead."""
    with pytest.raises(PolicySettingsError, match="Use one of"):
        PolicySettings.of(mode, ObservationConfig())


@pytest.mark.parametrize(
    ("described", "says"),
    [
        ({}, "is not a mode"),
        ({"mode": "MoveArmThenGriper"}, "Did you mean 'MoveArmThenGripper'"),
        ({"mode": "MoveArmThenGripper", "arm": "JointVelocity", "gripper": "Discreet"}, "Did you mean 'Discrete'"),
        ({"mode": "MoveArmThenGripper", "arm": "JointVelocity", "arm_settings": {"speed": 1}, "gripper": "Discrete"}, "speed"),
        ({"mode": "MoveArmThenGripper", "arm": "ERJointViaIK", "arm_settings": {"eps": -1}, "gripper": "Discrete"}, "eps"),
        ({"mode": "MoveArmThenGripper", "arm": "SafeArm", "gripper": "Discrete"}, "table"),
        ({"mode": "JointPositionActionMode", "arm": "JointVelocity"}, "no such entry"),
        ([], "table"),
        ("JointVelocity", "table"),
    ],
)
def test_wrong_plain_data_of_modes_are_refused(described: Any, says: str) -> None:
    """Whoever serves a policy may send anything."""
    with pytest.raises(PolicySettingsError, match=says):
        PolicySettings(described)


def everything() -> ObservationConfig:
    """Return settings none of which has its default."""
    config = ObservationConfig()
    config.set_all(True)
    config.joint_velocities, config.joint_poses = False, False
    config.front_camera = CameraConfig(
        rgb=False, image_size=(64, 32), render_mode="opengl", antialiasing=True, masks_as_one_channel=False, depth_in_meters=True,
        rgb_noise=GaussianNoise(0.1), depth_noise=GaussianNoise(0.01, (0.0, np.inf)),
    )  # fmt: skip
    config.joint_positions_noise = GaussianNoise(0.02, (-1.0, 1.0))
    config.model = ModelObservationConfig(tip_jacobian=True, world_distances=3)
    config.lighting = Lighting(key=Light((1.0, 0.0, 1.0), 0.4, (1.0, 0.9, 0.8)), fills=(), ambient=0.4)
    pose = np.array([1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0])
    config.add_camera("mine", ExtraCamera(pose=pose, fov=0.5, near=0.1, far=2.0, parent="hand", config=CameraConfig(depth=False)))
    return config


def blank() -> ObservationConfig:
    """Return settings with which nothing is observed."""
    config = ObservationConfig(joint_poses=False)
    config.set_all(False)
    return config


@pytest.mark.parametrize("make", [ObservationConfig, everything, blank])
def test_observations_are_what_they_were(make: Any) -> None:
    """Every field of the settings and of each camera comes back, but for the switches of demonstrations."""
    config = make()
    again = through_json(JointPositionActionMode(), config).make_obs_config()
    for field in fields(ObservationConfig):
        if not field.name.startswith("record_"):
            assert values(getattr(again, field.name)) == values(getattr(config, field.name)), field.name


def values(thing: Any) -> Any:
    """Return a thing as something that can be compared."""
    if isinstance(thing, np.ndarray | tuple | list):
        return [values(item) for item in thing]
    if isinstance(thing, dict):
        return {name: values(item) for name, item in thing.items()}
    state = getattr(thing, "__dict__", None)
    return thing if state is None else (type(thing).__name__, {name: values(item) for name, item in state.items()})


def test_little_is_written_where_little_is_observed() -> None:
    """The data say what is on; a policy of another environment can write them by hand."""
    described = {"joint_positions": True, "cameras": {"front": {"rgb": True, "image_size": [64, 64]}}}
    config = make_observations(described)
    assert describe_observations(config) == described
    assert config.front_camera.rgb and not config.front_camera.depth and not config.wrist_camera.is_used


class OwnNoise:
    """Noise that would run beside the simulation."""

    def apply(self, value: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Double it."""
        return 2.0 * value


def test_observations_of_others_are_refused() -> None:
    """Noise models, and subclasses of the settings."""
    config = ObservationConfig()
    config.joint_positions_noise = OwnNoise()
    with pytest.raises(PolicySettingsError, match="custom noise"):
        PolicySettings.of(JointPositionActionMode(), config)
    with pytest.raises(PolicySettingsError, match="ObservationConfig, not a subclass"):
        PolicySettings.of(JointPositionActionMode(), type("Mine", (ObservationConfig,), {})())


@pytest.mark.parametrize(
    ("described", "says"),
    [
        ({"joint_position": True}, "Did you mean 'joint_positions'"),
        ({"joint_positions": "on"}, "joint_positions"),
        ({"cameras": {"frnt": {}}}, "Did you mean 'front'"),
        ({"cameras": {"front": {"image_size": [0, 5]}}}, "image_size"),
        ({"cameras": {"front": {"image_size": [10**6, 10**6]}}}, "image_size"),
        ({"cameras": {"front": {"rgb": True, "render_mode": "crayons"}}}, "crayons"),
        ({"cameras": []}, "table"),
        ({"lighting": {"ambient": 7.0}}, "ambient"),
        ({"model": {"tip_jacobian": "yes"}}, "tip_jacobian"),
        ({"joint_positions_noise": {"variance": -1.0}}, "variance"),
        ({"joint_positions_noise": {"min_max_clip": [1]}}, "joint_positions_noise"),
        ({"extra_cameras": {"a": {}}}, "pose"),
        ({"extra_cameras": {"a": {"pose": [0, 0, 0, 0, 0, 0, 1], "parent": "drawer"}}}, "reveal its pose"),
        ({1: 2}, "names as keys"),
    ],
)
def test_wrong_plain_data_of_observations_are_refused(described: Any, says: str) -> None:
    """Each by an error of ours that says where."""
    with pytest.raises(PolicySettingsError, match=says):
        PolicySettings({"mode": "JointPositionActionMode"}, described)


LARGE = {name: {"rgb": True, "depth": True, "point_cloud": True, "mask": True, "image_size": [1024, 1024]} for name in CAMERAS}


@pytest.mark.parametrize(
    ("described", "says"),
    [
        ({"cameras": {"front": {"rgb": True, "image_size": [1025, 8]}}}, r"observation.cameras.front.image_size.*1024"),
        ({"extra_cameras": {"a": {"pose": [0, 0, 0, 0, 0, 0, 1], "config": {"mask": True, "image_size": [8, 4096]}}}},
         r"observation.extra_cameras.a.config.image_size.*4096"),
        ({"cameras": LARGE}, r"observation.cameras.*120.6 MB.*64 MB.*image_size"),
    ],
)  # fmt: skip
def test_a_policy_may_not_size_the_memory_of_the_runner(described: Any, says: str) -> None:
    """The error names the setting and the limit; below the limit, and where no image is made, there is none."""
    with pytest.raises(PolicySettingsError, match=says):
        PolicySettings({"mode": "JointPositionActionMode"}, described)
    two = {name: LARGE[name] for name in list(LARGE)[:2]}
    PolicySettings({"mode": "JointPositionActionMode"}, {"cameras": {**two, "wrist": {"image_size": [2048, 2048]}}})


@pytest.mark.parametrize("steps", [0, -1, 1.5, True, "7"])
def test_wrong_numbers_of_steps_are_refused(steps: Any) -> None:
    """The suggestion is a whole number from 1 on."""
    with pytest.raises(PolicySettingsError, match="max_steps"):
        PolicySettings.of(JointPositionActionMode(), ObservationConfig(), steps)
