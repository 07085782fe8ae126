"""A mapping sends what it says, reads actions exactly, and names file, key and value of what is wrong in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rlbench_pin.environment.actions import (
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    JointPosition,
    JointVelocity,
    RelativeFrame,
    calculate_delta_pose,
)
from rlbench_pin.errors import UnknownName
from rlbench_pin.evaluation.policies import MappingError, PolicySettings, load_mapping, mapping_names
from rlbench_pin.evaluation.policies.mapping import (
    ARMS,
    ROTATIONS,
    STATES,
    ActionLayout,
    ImageEntry,
    decode_rotation,
    encode_rotation,
    mapping_of,
)
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import IDENTITY, euler_to_quaternion, pose_to_matrix

TOP = np.array([1.0, 0.0, 0.0, 0.0])
"""Quaternion of a gripper that points down: a half turn about x."""
LEAST: dict[str, Any] = {"action": {"arm": "delta_pose"}}


def quaternions(count: int = 200) -> np.ndarray:
    """Random rotations, and half turns, at which signs are easily wrong."""
    drawn = np.random.default_rng(0).normal(size=(count, 4))
    drawn /= np.linalg.norm(drawn, axis=1, keepdims=True)
    return np.concatenate([drawn, np.eye(4), -np.eye(4)])


@pytest.mark.parametrize("layout", ROTATIONS)
@pytest.mark.filterwarnings("ignore:Gimbal lock")
def test_a_rotation_comes_back_in_every_layout(layout: str) -> None:
    """Encoded and decoded it is the same rotation, x, y, z, w with w >= 0."""
    for q in quaternions():
        values = encode_rotation(q, layout)
        back = decode_rotation(values, layout)
        assert values.shape == (ROTATIONS[layout],)
        assert back[3] >= 0.0 and np.isclose(np.linalg.norm(back), 1.0, atol=1e-12)
        assert abs(back @ q) == pytest.approx(1.0, abs=1e-9)


def test_layouts_are_those_of_the_literature() -> None:
    """A turn by 0.3 rad about z, in each layout, against numbers written by hand."""
    q, c, s = euler_to_quaternion(0.0, 0.0, 0.3), np.cos(0.3), np.sin(0.3)
    half = [np.sin(0.15), np.cos(0.15)]
    for layout, wanted in (
        ("quaternion_xyzw", [0, 0, half[0], half[1]]),
        ("quaternion_wxyz", [half[1], 0, 0, half[0]]),
        ("axis_angle", [0, 0, 0.3]),
        ("euler_rpy", [0, 0, 0.3]),
        ("six_rows", [c, -s, 0, s, c, 0]),
        ("six_columns", [c, s, 0, -s, c, 0]),
        ("six_interleaved", [c, -s, s, c, 0, 0]),
    ):
        np.testing.assert_allclose(encode_rotation(-q, layout), wanted, atol=1e-12, err_msg=layout)


def test_euler_angles_are_ours() -> None:
    """Roll, pitch and yaw mean Rz(yaw) Ry(pitch) Rx(roll), as in `euler_to_quaternion`."""
    angles = np.array([0.3, -0.5, 1.1])
    np.testing.assert_allclose(decode_rotation(angles, "euler_rpy"), euler_to_quaternion(*angles), atol=1e-12)
    np.testing.assert_allclose(encode_rotation(euler_to_quaternion(*angles), "euler_rpy"), angles, atol=1e-12)


def test_six_numbers_need_not_be_orthonormal() -> None:
    """What a network predicts is made a rotation: the first direction is kept."""
    q = euler_to_quaternion(0.3, -0.5, 1.1)
    matrix = pose_to_matrix(np.concatenate([np.zeros(3), q]))[:3, :3]
    bent = np.concatenate([2.0 * matrix[:, 0], 0.5 * matrix[:, 1] + 0.3 * matrix[:, 0]])
    np.testing.assert_allclose(decode_rotation(bent, "six_columns"), q, atol=1e-9)


@pytest.mark.parametrize(
    ("values", "layout"),
    [(np.zeros(4), "quaternion_xyzw"), (np.zeros(6), "six_rows"), (np.array([1.0, 0, 0, 2, 0, 0]), "six_columns")],
)
def test_numbers_that_are_no_rotation_are_refused(values: np.ndarray, layout: str) -> None:
    """A quaternion of length 0, or two parallel directions."""
    with pytest.raises(ValueError, match="has length"):
        decode_rotation(values, layout)


# Actions ----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mapping", ["libero", "libero_vla_eval"])
def test_a_libero_action_is_scaled_and_turns_about_the_world(mapping: str) -> None:
    """1 is 5 cm and 0.5 rad; -1 opens the gripper."""
    layout = load_mapping(mapping).action
    action = layout.decode(np.array([1.0, -2.0, 0.0, 0.0, 0.0, 1.0, -1.0]))
    np.testing.assert_allclose(action[:3], [0.05, -0.05, 0.0], atol=1e-12)
    np.testing.assert_allclose(action[3:7], euler_to_quaternion(0.0, 0.0, 0.5), atol=1e-12)
    assert action[7] == 1.0 and layout.decode(np.array([0.0] * 6 + [1.0]))[7] == 0.0
    arm = layout.action_mode().arm_action_mode
    assert isinstance(arm, EndEffectorPoseViaIK) and not arm.absolute_mode and arm.frame is RelativeFrame.WORLD
    tip = np.concatenate([[0.3, 0.0, 1.0], TOP])
    moved = calculate_delta_pose(tip, action[:7], arm.frame)
    np.testing.assert_allclose(moved[:3], [0.35, -0.05, 1.0], atol=1e-12)


def test_a_delta_in_the_tip_frame_moves_along_the_tip() -> None:
    """With the gripper pointing down, forward along its z is down in the world."""
    layout = ActionLayout("delta_pose", frame="tip")
    arm = layout.action_mode().arm_action_mode
    assert isinstance(arm, EndEffectorPoseViaIK) and arm.frame is RelativeFrame.EE and arm.is_relative
    action = layout.decode(np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.2, 1.0]))
    moved = calculate_delta_pose(np.concatenate([[0.3, 0.0, 1.0], TOP]), action[:7], arm.frame)
    np.testing.assert_allclose(moved[:3], [0.3, 0.0, 0.9], atol=1e-12)
    assert abs(moved[3:] @ decode_rotation(np.array([0, 0, -0.2]), "axis_angle")) < 0.01  # turned over, so about -z


def test_a_key_frame_is_planned() -> None:
    """PerAct: an absolute pose, brought to unit length and w >= 0; 1 opens."""
    layout = load_mapping("peract").action
    arm = layout.action_mode().arm_action_mode
    assert isinstance(arm, EndEffectorPoseViaPlanning) and arm.absolute_mode and arm.retry_without_checks
    action = layout.decode(np.array([0.3, 0.1, 1.0, 0.0, 0.0, 0.0, -2.0, 1.0]))
    np.testing.assert_allclose(action, [0.3, 0.1, 1.0, *IDENTITY[3:], 1.0], atol=1e-12)


def test_droid_velocities_are_scaled_and_1_closes() -> None:
    """1 is 0.2 rad in a fifteenth of a second; beyond 1 it means 1."""
    layout = load_mapping("droid").action
    assert isinstance(layout.action_mode().arm_action_mode, JointVelocity)
    np.testing.assert_allclose(layout.decode(np.array([1.5, -0.5, 0, 0, 0, 0, 0, 0.9])), [3.0, -1.5, 0, 0, 0, 0, 0, 0.0])
    assert layout.decode(np.zeros(8))[7] == 1.0


def test_joint_positions_and_their_changes() -> None:
    """Both are `JointPosition`, absolute or not."""
    for arm, absolute in (("joint_positions", True), ("joint_deltas", False)):
        mode = ActionLayout(arm).action_mode().arm_action_mode
        assert isinstance(mode, JointPosition) and mode.absolute_mode == absolute


@pytest.mark.parametrize(("opened", "closed"), [(1.0, 0.0), (0.0, 1.0), (-1.0, 1.0), (1.0, -1.0)])
def test_every_sign_of_a_gripper(opened: float, closed: float) -> None:
    """Ours is 1 open; numbers beyond the ends, and those nearer to one of them, mean that end."""
    layout = ActionLayout("joint_positions", joints=1, gripper_open=opened, gripper_closed=closed)
    for share, wanted in ((1.3, 1.0), (1.0, 1.0), (0.6, 1.0), (0.4, 0.0), (0.0, 0.0), (-0.3, 0.0)):
        assert layout.decode(np.array([0.0, closed + share * (opened - closed)]))[-1] == wanted


# Observations -----------------------------------------------------------------------------------------------------------------


def seen(height: int = 180, width: int = 320) -> Observation:
    """An observation whose images are red above and blue below."""
    image = np.zeros((height, width, 3), np.uint8)
    image[: height // 2, :, 0] = image[height // 2 :, :, 2] = 200
    return Observation(
        front_rgb=image,
        wrist_rgb=image,
        joint_positions=np.arange(7.0),
        gripper_pose=np.concatenate([[0.3, 0.1, 1.0], euler_to_quaternion(0.0, 0.0, -0.4)]),
        gripper_joint_positions=np.array([0.04, 0.03]),
        gripper_open=1.0,
    )


def test_an_image_is_padded_upright_and_stays_rgb() -> None:
    """16:9 in a square: bars above and below, the red half on top."""
    sent = ImageEntry("front", image_size=(320, 180), resize=224).of(seen())
    assert sent.shape == (224, 224, 3) and sent.dtype == np.uint8
    assert (sent[:49] == 0).all() and (sent[-49:] == 0).all()
    np.testing.assert_array_equal(sent[60, 100], [200, 0, 0])
    np.testing.assert_array_equal(sent[160, 100], [0, 0, 200])
    image = seen().front_rgb
    np.testing.assert_array_equal(ImageEntry("front").of(seen()), image)


def test_states_are_joined_in_order() -> None:
    """LIBERO's eight numbers: position, axis-angle, two fingers, the second negative."""
    sent = load_mapping("libero").encode(seen(), "Push.")
    np.testing.assert_allclose(sent["observation/state"], [0.3, 0.1, 1.0, 0, 0, -0.4, 0.04, -0.03], atol=1e-6)
    assert sent["observation/state"].dtype == np.float32 and sent["prompt"] == "Push."
    droid = load_mapping("droid").encode(seen(), "Push.")
    np.testing.assert_array_equal(droid["observation/joint_position"], np.arange(7))
    np.testing.assert_array_equal(droid["observation/gripper_position"], [0.0])


def test_a_dot_in_a_key_goes_one_map_deeper() -> None:
    """As vla-eval wants its images."""
    sent = load_mapping("libero_vla_eval").encode(seen(256, 256), "Push.")
    assert (
        sent["images"].keys() == {"agentview", "wrist"} and sent["task_description"] == "Push." and sent["states"].shape == (8,)
    )


@pytest.mark.parametrize("name", mapping_names())
def test_every_preset_asks_for_what_it_sends(name: str) -> None:
    """What is observed and the action mode are settings that an evaluation takes, and every part has the size it says."""
    mapping = load_mapping(name)
    settings = PolicySettings.of(mapping.action.action_mode(), mapping.obs_config(), mapping.max_steps)
    config = settings.make_obs_config()
    for image in mapping.images.values():
        camera = config.camera(image.camera)
        assert getattr(camera, image.product) and tuple(camera.image_size) == image.image_size


@pytest.mark.parametrize("part", STATES)
def test_every_part_of_a_state_can_be_sent(part: str) -> None:
    """Its size is the one that is compared with the server's."""
    mapping = mapping_of({**LEAST, "states": {"s": [part]}}, "a.toml")
    observation = seen()
    observation.joint_velocities = observation.task_low_dim_state = np.arange(7.0)
    assert mapping.state_size("s") in (None, len(mapping.encode(observation, "")["s"]))


# Files ------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ({}, "'action'.*is missing"),
        ({"action": {}}, "'action.arm' is missing"),
        ({"action": 3}, "'action' has to be a table"),
        ({"acton": {}, **LEAST}, "'acton'.*Did you mean 'action'"),
        ({"action": {"arm": "delta_poses"}}, "'action.arm'.*Did you mean 'delta_pose'"),
        ({"action": {"arm": ["delta_pose"]}}, f"has to be one of {ARMS[0]}"),
        ({"action": {"arm": "delta_pose", "rotaton": "euler_rpy"}}, "'action.rotaton'.*Did you mean 'rotation'"),
        ({"action": {"arm": "delta_pose", "rotation": "euler"}}, "'action.rotation'.*'euler_rpy'"),
        ({"action": {"arm": "delta_pose", "frame": "base"}}, "'action.frame' has to be one of world, tip"),
        ({"action": {"arm": "absolute_pose", "frame": "tip"}}, "'action.frame' is for a delta_pose"),
        ({"action": {"arm": "absolute_pose", "rotation_scale": 0.5}}, "'action.rotation_scale' is for"),
        ({"action": {"arm": "joint_positions", "joints": 0}}, "'action.joints' has to be a whole number"),
        ({"action": {"arm": "delta_pose", "scale": -1.0}}, "'action.scale'"),
        ({"action": {"arm": "delta_pose", "scale": float("nan")}}, "'action.scale'"),
        ({"action": {"arm": "delta_pose", "clip": 0.0}}, "'action.clip'"),
        ({"action": {"arm": "delta_pose", "gripper_open": 0.0}}, "'action.gripper_open' has to differ"),
        ({**LEAST, "images": {"i": {"camera": "frnt"}}}, "'images.i.camera'.*Did you mean 'front'"),
        ({**LEAST, "images": {"i": {}}}, "'images.i.camera' is missing"),
        ({**LEAST, "images": {"i": {"camera": "front", "image_size": [5]}}}, "'images.i.image_size'"),
        ({**LEAST, "images": {"i": {"camera": "front", "product": "depth", "resize": 64}}}, "'images.i.resize' is for rgb"),
        ({**LEAST, "images": {"i": {"camera": "front", "resize": 0}}}, "'images.i.resize'"),
        ({**LEAST, "images": "front"}, "'images' has to be a table"),
        ({**LEAST, "states": {"s": ["tip_positon"]}}, "'states.s'.*Did you mean 'tip_position'"),
        ({**LEAST, "states": {"s": []}}, "'states.s' has to be a list"),
        ({**LEAST, "states": {"prompt": ["fingers"]}}, "'prompt' is the key of two values"),
        ({**LEAST, "states": {"a": ["fingers"], "a.b": ["fingers"]}}, "'a' is the key of two values, or of a value and a map"),
        ({**LEAST, "instruction": ""}, "'instruction'"),
        ({**LEAST, "replan": 0}, "'replan' has to be a whole number"),
        ({**LEAST, "max_steps": 1.5}, "'max_steps'"),
        (
            {**LEAST, "images": {"i": {"camera": "front"}, "j": {"camera": "front", "image_size": [64, 64]}}},
            "'images.j.image_size' differs",
        ),
    ],
)
def test_what_is_wrong_in_a_mapping_is_named(content: dict[str, Any], says: str) -> None:
    """The file and the key, the value, and what is possible."""
    with pytest.raises(MappingError, match=f"(?s)^a.toml: .*{says}"):
        mapping_of(content, "a.toml")


def test_a_mapping_is_a_preset_or_a_file(tmp_path: Path) -> None:
    """A near name is proposed; a file that is missing or not TOML is named."""
    with pytest.raises(UnknownName, match="Did you mean 'libero'"):
        load_mapping("libro")
    with pytest.raises(MappingError, match="No such file"):
        load_mapping(str(tmp_path / "missing.toml"))
    file = tmp_path / "own.toml"
    file.write_text("action =", encoding="utf-8")
    with pytest.raises(MappingError, match="cannot be read"):
        load_mapping(str(file))
    file.write_text('[action]\narm = "joint_deltas"\njoints = 6\n', encoding="utf-8")
    assert load_mapping(str(file)).action.size == 7
