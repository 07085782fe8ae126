"""The conventions of docs/conventions.md, each against numbers that were computed by hand."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.environment import (
    CameraConfig,
    Discrete,
    Environment,
    ExtraCamera,
    JointPosition,
    MoveArmThenGripper,
    ObservationConfig,
    TaskEnvironment,
    calculate_delta_pose,
)
from rlbench_pin.environment.actions import RelativeFrame
from rlbench_pin.evaluation.policies import load_mapping
from rlbench_pin.evaluation.policies.mapping import ActionLayout, ImageEntry, decode_rotation, encode_rotation, mapping_of
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import compose, euler_to_quaternion, pose_to_matrix

HALF = np.sqrt(0.5)
"""Sine and cosine of 45 degrees."""
QUARTER = np.array([0.0, 0.0, HALF, HALF])
"""A turn by 90 degrees about z: x goes to y, y to -x."""
QUARTER_MATRIX = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
DOWN = np.array([0.3, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0])
"""A tip that points down: its x is -x of the world, its y is y, its z is -z."""

BALL = np.array([0.4, 0.4, 0.952])
"""Where the ball is: 20 cm above the table."""
EYE = np.array([0.3, 0.35, 1.752])
"""Where the camera is: 1 m above the table, 10 cm nearer to the base than the ball, and 5 cm to the right of it."""
LOOKS_DOWN = np.concatenate([EYE, [HALF, HALF, 0.0, 0.0]])
"""A half turn about the diagonal of x and y: camera z is -z of the world, camera x is y, camera y is x."""
RADIUS = 0.025
"""Radius of the ball [m]."""


@pytest.fixture(scope="module")
def task() -> Iterator[TaskEnvironment]:
    """reach_target with a camera of 128 px that looks straight down, 2 atan(1/2) wide: 128 px are 1 m at a distance of 1 m."""
    config = ObservationConfig(gripper_joint_positions=True)
    config.set_all_high_dim(False)
    product = CameraConfig(image_size=(128, 128), mask=False, depth_in_meters=True)
    config.add_camera("down", ExtraCamera(pose=LOOKS_DOWN, fov=2.0 * np.arctan(0.5), config=product))
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config, seed=0) as environment:
        yield environment.get_task("reach_target")


@pytest.fixture(scope="module")
def seen(task: TaskEnvironment) -> Observation:
    """An observation of a red ball below that camera; the other balls are elsewhere."""
    task.reset(seed=0)
    for name, place in (("target", BALL), ("distractor0", [0.0, 0.0, 9.0]), ("distractor1", [0.0, 0.0, 8.0])):
        task.world.body(name).set_pose(np.concatenate([place, [0.0, 0.0, 0.0, 1.0]]))
    task.world.body("target").set_color((1.0, 0.0, 0.0))
    return task.get_observation()


# Rotations --------------------------------------------------------------------------------------------------------------------


def test_quaternions_are_x_y_z_w() -> None:
    """The last number is w: of poses, of what is sent, and of what is read."""
    np.testing.assert_allclose(euler_to_quaternion(0.0, 0.0, np.pi / 2), QUARTER, atol=1e-12)
    np.testing.assert_allclose(pose_to_matrix(np.concatenate([np.zeros(3), QUARTER]))[:3, :3], QUARTER_MATRIX, atol=1e-12)
    np.testing.assert_allclose(encode_rotation(QUARTER, "quaternion_wxyz"), [HALF, 0.0, 0.0, HALF], atol=1e-12)
    np.testing.assert_allclose(decode_rotation(np.array([HALF, 0.0, 0.0, HALF]), "quaternion_wxyz"), QUARTER, atol=1e-12)


def test_w_is_positive_in_what_we_send() -> None:
    """Both q and -q are one rotation; the one with w >= 0 is sent, and both are read."""
    np.testing.assert_allclose(encode_rotation(-QUARTER, "quaternion_xyzw"), QUARTER, atol=1e-12)
    np.testing.assert_allclose(decode_rotation(-QUARTER, "quaternion_xyzw"), QUARTER, atol=1e-12)
    turned = compose(np.concatenate([np.zeros(3), -QUARTER]), [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    np.testing.assert_allclose(turned[3:], QUARTER, atol=1e-12)


@pytest.mark.parametrize(
    ("layout", "numbers"),
    [
        ("six_rows", [0.0, -1.0, 0.0, 1.0, 0.0, 0.0]),
        ("six_columns", [0.0, 1.0, 0.0, -1.0, 0.0, 0.0]),
        ("six_interleaved", [0.0, -1.0, 1.0, 0.0, 0.0, 0.0]),
    ],
)
def test_six_numbers(layout: str, numbers: list[float]) -> None:
    """The first two rows or columns of the matrix above, or its first two columns row by row."""
    np.testing.assert_allclose(encode_rotation(QUARTER, layout), numbers, atol=1e-12)
    np.testing.assert_allclose(decode_rotation(np.array(numbers), layout), QUARTER, atol=1e-12)


def test_three_numbers() -> None:
    """An axis times an angle in radians; roll, pitch, yaw are turns about the fixed x, then y, then z."""
    np.testing.assert_allclose(encode_rotation(QUARTER, "axis_angle"), [0.0, 0.0, np.pi / 2], atol=1e-12)
    both = decode_rotation(np.array([np.pi / 2, 0.0, np.pi / 2]), "euler_rpy")  # x stays, then goes to y; z goes to -y, then to x
    np.testing.assert_allclose(both, [0.5, 0.5, 0.5, 0.5], atol=1e-12)


# Actions ----------------------------------------------------------------------------------------------------------------------


def test_the_gripper_is_1_open(task: TaskEnvironment) -> None:
    """In observations and actions; a mapping turns it round."""
    task.reset(seed=0)
    joints = task.runtime.robot.joint_positions
    closed, _, _ = task.step(np.append(joints, 0.0))
    assert closed.gripper_open == 0.0
    assert closed.gripper_joint_positions is not None and closed.gripper_joint_positions.max() < 0.01
    opened, _, _ = task.step(np.append(joints, 1.0))
    assert opened.gripper_open == 1.0
    assert load_mapping("droid").action.decode(np.append(np.zeros(7), 1.0))[-1] == 0.0


def test_an_absolute_pose_is_where_the_tip_goes() -> None:
    """A delta pose is added to where it is."""
    numbers = np.array([0.1, 0.2, 0.9, 0.0, 0.0, np.pi / 2, 1.0])
    absolute, delta = ActionLayout("absolute_pose"), ActionLayout("delta_pose")
    np.testing.assert_allclose(absolute.decode(numbers), [0.1, 0.2, 0.9, *QUARTER, 1.0], atol=1e-12)
    assert absolute.action_mode().arm_action_mode.absolute_mode and not delta.action_mode().arm_action_mode.absolute_mode  # type: ignore[attr-defined]
    moved = calculate_delta_pose(DOWN, delta.decode(numbers)[:7])
    np.testing.assert_allclose(moved[:3], [0.4, 0.2, 1.9], atol=1e-12)


def test_the_frames_of_a_delta() -> None:
    """10 cm along z and 90 degrees about z, of a tip that points down: up or down, left or right."""
    delta = np.concatenate([[0.0, 0.0, 0.1], QUARTER])
    world = calculate_delta_pose(DOWN, delta, RelativeFrame.WORLD)
    np.testing.assert_allclose(world[:3], [0.3, 0.0, 1.1], atol=1e-12)
    np.testing.assert_allclose(pose_to_matrix(world)[:3, 0], [0.0, -1.0, 0.0], atol=1e-12)  # tip x was -x, and goes to -y
    tip = calculate_delta_pose(DOWN, delta, RelativeFrame.EE)
    np.testing.assert_allclose(tip[:3], [0.3, 0.0, 0.9], atol=1e-12)
    np.testing.assert_allclose(pose_to_matrix(tip)[:3, 0], [0.0, 1.0, 0.0], atol=1e-12)  # tip x goes to tip y


def test_joints_are_in_order_from_the_base(task: TaskEnvironment) -> None:
    """The first joint of the Panda turns the whole arm about the vertical axis of its base, the last one the gripper alone."""
    assert task.runtime.description.arm_joints == tuple(f"panda_joint{number}" for number in range(1, 8))
    model, (x, y, _, *_) = task.runtime.model, task.runtime.description.base_pose
    _, observation = task.reset(seed=0)
    q = observation.joint_positions
    assert q is not None
    np.testing.assert_allclose(q, task.runtime.description.home, atol=1e-3)
    tip = model.tip_pose(q)
    first = model.tip_pose(q + np.pi / 2 * np.eye(7)[0])
    np.testing.assert_allclose(first[:3], [x - (tip[1] - y), y + (tip[0] - x), tip[2]], atol=1e-9)
    np.testing.assert_allclose(model.tip_pose(q + np.eye(7)[6])[:3], tip[:3], atol=1e-9)


# Images -----------------------------------------------------------------------------------------------------------------------


def test_a_pixel_of_a_camera_that_looks_down(seen: Observation) -> None:
    """The ball is 10 cm up, 5 cm left and 80 cm ahead of the camera: 16 px above and 8 px left of the middle."""
    matrix = seen.misc["down_camera_extrinsics"]
    np.testing.assert_allclose(matrix[:3, :3], [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]], atol=1e-12)
    ball = np.linalg.inv(matrix) @ np.append(BALL, 1.0)
    np.testing.assert_allclose(ball[:3], [0.05, 0.1, 0.8], atol=1e-12)  # x left, y up, z forward
    u, v, z = seen.misc["down_camera_intrinsics"] @ ball[:3]
    np.testing.assert_allclose([u / z, v / z], [64.0 - 8.0, 64.0 - 16.0], atol=1e-9)


def test_images_are_upright_and_rgb(seen: Observation) -> None:
    """Row 0 is on top: what is ahead of the base is above the middle; what is left is left. The first number is red."""
    red, green, blue = seen.down_rgb[48, 56].astype(int)  # type: ignore[attr-defined]
    assert red > 100 and red > 3 * green and red > 3 * blue
    rows, columns = np.nonzero(seen.down_rgb[..., 0].astype(int) > 3 * seen.down_rgb[..., 1].astype(int) + 50)  # type: ignore[attr-defined]
    assert abs(rows.mean() - 48.0) < 1.5 and abs(columns.mean() - 56.0) < 1.5


def test_images_are_sent_as_they_are() -> None:
    """Neither turned nor with red and blue exchanged."""
    image = np.zeros((256, 256, 3), np.uint8)
    image[0, 0] = [200, 100, 50]
    np.testing.assert_array_equal(ImageEntry("front").of(Observation(front_rgb=image))[0, 0], [200, 100, 50])


def test_depth_is_in_metres_along_the_optical_axis(seen: Observation) -> None:
    """The camera is 1 m above the table and 1.752 m above the floor, in the corners too, where the ray is 1.22 times as long."""
    depth = seen.down_depth  # type: ignore[attr-defined]
    np.testing.assert_allclose(depth[[0, -1], [-1, -1]], 1.0, atol=1e-3)  # right: table
    np.testing.assert_allclose(depth[[0, -1], [0, 0]], 1.752, atol=1e-3)  # left: floor
    assert depth[48, 56] == pytest.approx(0.8 - RADIUS, abs=2e-3)
    np.testing.assert_allclose(seen.down_point_cloud[48, 56], BALL + [0.0, 0.0, RADIUS], atol=0.005)  # type: ignore[attr-defined]


def test_mappings_send_depth_in_metres() -> None:
    """Our own observations have 0 to 1 between the planes, unless `depth_in_meters` is on."""
    assert not CameraConfig().depth_in_meters
    content = {"images": {"depth": {"camera": "front", "product": "depth"}}, "action": {"arm": "delta_pose"}}
    assert mapping_of(content, "depth.toml").obs_config().front_camera.depth_in_meters


def test_the_page_names_every_test() -> None:
    """Each convention of the page has its test here, and each test its convention there."""
    page = (Path(__file__).parents[3] / "docs" / "conventions.md").read_text(encoding="utf-8")
    tests = re.findall(r"^def (test_\w+)", Path(__file__).read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(re.findall(r"`(test_\w+)`", page)) == sorted(set(tests) - {"test_the_page_names_every_test"})
