"""Sensors, joints, cameras and textures of scene objects, and the simulator itself."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pyrep import PyRep
from pyrep.const import JointType, PerspectiveMode, PrimitiveShape, RenderMode
from pyrep.errors import PyRepError, UnsupportedCall
from pyrep.objects import Dummy, Joint, Light, Octree, ProximitySensor, Shape, VisionSensor
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment import ObservationConfig, rgb_handles_to_mask
from rlbench_pin.errors import CameraError
from rlbench_pin.sim import look_at
from rlbench_pin.tasks.library.open_drawer import OpenDrawer
from rlbench_pin.tasks.library.reach_target import ReachTarget

TEXTURES = Path(__file__).parents[2] / "rlbench_pin" / "assets" / "textures"


@pytest.fixture
def pyrep() -> Iterator[PyRep]:
    """A running simulation of the reach task."""
    simulator = PyRep()
    simulator.launch(headless=True)
    Simulator.current().load(ReachTarget, ObservationConfig())
    simulator.start()
    yield simulator
    simulator.shutdown()


def box(size: float, position: list[float]) -> Shape:
    """Make a red cube that stays in the air."""
    return Shape.create(PrimitiveShape.CUBOID, [size] * 3, static=True, position=position, color=[1.0, 0.0, 0.0])


def test_proximity_sensors(pyrep: PyRep) -> None:
    """Shapes by any solid part, dummies by their origin, none that is not detectable."""
    goal = ProximitySensor("goal")
    low = np.array(goal.get_bounding_box())
    radius = 0.5 * (low[1] - low[0])
    cube, marker = box(0.04, [0.0, 0.0, 1.8]), Dummy.create()
    assert not goal.is_detected(cube) and not goal.is_detected(marker)
    cube.set_position(goal.get_position() + [0.0, 0.0, radius + 0.015])
    marker.set_position(goal.get_position() + [0.0, 0.0, 0.5 * radius])
    assert goal.is_detected(cube) and goal.is_detected(marker)
    Shape("target").set_detectable(False)
    assert np.isclose(goal.read(), radius - 0.005, atol=1e-3)
    cube.set_detectable(False)
    assert not goal.is_detected(cube) and goal.read() == -1.0


# Joints -----------------------------------------------------------------------------------------------------------------


def test_joints_of_objects(pyrep: PyRep) -> None:
    """Values, limits, a motor that drives them to a value and holds them."""
    Simulator.current().load(OpenDrawer, ObservationConfig())
    joint = Joint("drawer_middle")
    assert joint.get_joint_type() == JointType.PRISMATIC and joint == Joint("chest/drawer_middle")
    cyclic, (low, length) = joint.get_joint_interval()
    assert not cyclic and low == 0.0 and 0.1 < length < 0.4
    joint.set_joint_position(0.05)
    assert np.isclose(joint.get_joint_position(), 0.05) and joint.get_joint_velocity() == 0.0
    joint.set_joint_target_position(0.15)
    for _ in range(20):
        pyrep.step()
    assert np.isclose(joint.get_joint_position(), 0.15, atol=2e-3) and joint.is_motor_enabled()
    joint.set_motor_enabled(False)
    assert not joint.is_motor_enabled() and not joint.is_control_loop_enabled()
    joint.set_joint_target_velocity(0.0)
    assert joint.is_motor_locked_at_zero_velocity()
    with pytest.raises(UnsupportedCall, match="set_joint_target_position"):
        joint.set_joint_target_velocity(0.3)
    with pytest.raises(UnsupportedCall, match="URDF"):
        joint.set_joint_interval(False, [0.0, 1.0])


def test_joints_of_the_arm(pyrep: PyRep) -> None:
    """One joint moves, the others stay; fingers too."""
    joints = [Joint(f"Panda_joint{k}") for k in range(1, 8)]
    before = np.array([j.get_joint_position() for j in joints])
    joints[3].set_joint_target_position(before[3] - 0.2)
    for _ in range(40):
        pyrep.step()
    after = np.array([j.get_joint_position() for j in joints])
    assert np.allclose(after - before, [0, 0, 0, -0.2, 0, 0, 0], atol=0.01)
    assert joints[0].get_joint_type() == JointType.REVOLUTE and joints[0].get_joint_upper_velocity_limit() > 1.0
    assert abs(joints[1].get_joint_force()) > 1.0
    finger = Joint("Panda_gripper_joint1")
    assert finger.get_joint_type() == JointType.PRISMATIC and np.isclose(finger.get_joint_position(), 0.04, atol=1e-3)


def test_velocities_of_links(pyrep: PyRep) -> None:
    """A turning arm moves its tip across the radius, a drawer slides."""
    pyrep.step()
    turn = Joint("Panda_joint1")
    turn.set_joint_target_velocity(0.5)
    for _ in range(20):
        pyrep.step()
    linear, angular = Dummy("Panda_tip").get_velocity()
    assert np.allclose(angular, [0.0, 0.0, turn.get_joint_velocity()], atol=0.02)
    arm = Dummy("Panda_tip").get_position() - Shape("panda_link0").get_position()
    assert np.allclose(linear, np.cross(angular, arm), atol=0.02)


# The simulator ----------------------------------------------------------------------------------------------------------


def test_the_simulator_starts_steps_and_ends() -> None:
    """In this order only, and again; scenes of other simulators are refused before anything starts."""
    pyrep = PyRep()
    with pytest.raises(PyRepError, match="launch"):
        pyrep.step()
    with pytest.raises(UnsupportedCall, match="TOML"):
        pyrep.launch("my_scene.ttt", headless=True)
    pyrep.launch("task_design.ttt", headless=True)
    with pytest.raises(PyRepError, match="start"):
        pyrep.step()
    pyrep.start()
    assert pyrep.running and pyrep.get_simulation_timestep() == 0.05
    before = Simulator.current().world.time
    pyrep.step()
    assert np.isclose(Simulator.current().world.time - before, 0.05)
    pyrep.set_simulation_timestep(0.05)
    with pytest.warns(UserWarning, match="stays 0.05 s"):
        pyrep.set_simulation_timestep(0.005)
    assert pyrep.get_simulation_timestep() == 0.05
    for call in (
        lambda: pyrep.script_call("f@g", 1),
        lambda: pyrep.export_scene("a.ttt"),
        lambda: Light("l"),
        lambda: Octree("o"),
    ):
        with pytest.raises(UnsupportedCall):
            call()
    with pytest.raises(PyRepError):
        pyrep.launch()
    pyrep.stop()
    pyrep.shutdown()
    pyrep.shutdown()
    assert not pyrep.running
    with pytest.raises(RuntimeError, match="launch"):
        Shape("Floor")
    pyrep.launch()
    assert Shape("Floor").still_exists()
    pyrep.shutdown()


def test_plans_ignore_what_is_not_collidable(pyrep: PyRep) -> None:
    """Physics goes on as before."""
    tip = Dummy("Panda_tip").get_position()
    cube, planner = box(0.1, tip.tolist()), Simulator.current().runtime.planner
    for collidable in (True, False):
        cube.set_collidable(collidable)
        Simulator.current().runtime.refresh_planner()
        touching = planner.collision.colliding_pairs(Simulator.current().world.robot.joint_positions)
        assert bool(touching) is collidable and cube.is_respondable()


def test_pixels_lie_where_the_matrices_say(pyrep: PyRep) -> None:
    """World = extrinsics * inverse(intrinsics) * (u, v, 1) * depth, with negative focal lengths."""
    cube = box(0.1, [0.3, 0.2, 1.3])
    camera = VisionSensor.create([96, 64], view_angle=50.0)
    camera.set_pose(look_at((0.9, -0.3, 1.6), (0.3, 0.2, 1.3)))
    intrinsics = camera.get_intrinsic_matrix()
    assert np.allclose(intrinsics, [[-48 / np.tan(np.radians(25)), 0, 48], [0, -48 / np.tan(np.radians(25)), 32], [0, 0, 1]])
    depth, cloud = camera.capture_depth(in_meters=True), camera.capture_pointcloud()
    assert depth.shape == (64, 96) and cloud.shape == (64, 96, 3)
    u, v = 50, 30
    point = camera.get_matrix() @ [*(np.linalg.inv(intrinsics) @ [u, v, 1.0] * depth[v, u]), 1.0]
    assert np.allclose(point[:3], cloud[v, u], atol=1e-6)
    camera.set_render_mode(RenderMode.OPENGL_COLOR_CODED)
    seen = rgb_handles_to_mask(camera.capture_rgb()) == cube.get_handle()
    assert 50 < seen.sum() < 2000
    assert np.abs(cloud[seen] - [0.3, 0.2, 1.3]).max() < 0.05 + 0.004
    normalised = camera.capture_depth()
    assert np.allclose(normalised * (10.0 - 0.01) + 0.01, depth, atol=1e-4)
    assert np.allclose(camera.pointcloud_from_depth(depth), cloud)
    static = VisionSensor.pointcloud_from_depth_and_camera_params(depth, camera.get_matrix(), intrinsics)
    assert np.allclose(static, cloud)


def test_images_are_upright_and_follow_the_camera(pyrep: PyRep) -> None:
    """A cube above the middle is in the upper half, one to the right in the right half."""
    Simulator.current().unload()  # the target of the task is red
    cube, camera = box(0.1, [0.3, 0.0, 1.5]), VisionSensor.create([64, 64], render_mode=RenderMode.OPENGL)
    camera.set_pose(look_at((1.3, 0.0, 1.3), (0.3, 0.0, 1.3)))
    rows, columns = np.nonzero(_red(camera.capture_rgb()))
    assert rows.max() < 32 and abs(columns.mean() - 32) < 3
    cube.set_position([0.3, 0.3, 1.3])  # looking along -x, +y is to the right
    rows, columns = np.nonzero(_red(camera.capture_rgb()))
    assert columns.min() > 32 and abs(rows.mean() - 32) < 3
    camera.set_pose(look_at((0.3, 0.0, 1.3), (1.3, 0.0, 1.3)))
    assert not _red(camera.capture_rgb()).any()


def _red(image: np.ndarray) -> np.ndarray:
    assert image.dtype == np.float32 and image.min() >= 0.0 and image.max() <= 1.0
    return (image[..., 0] > 0.3) & (image[..., 1:].max(axis=-1) < 0.15)


def test_settings_of_a_camera(pyrep: PyRep) -> None:
    """What was set is read back and counts; what cannot be drawn is refused."""
    camera = VisionSensor.create(
        [32, 16], True, view_angle=30.0, near_clipping_plane=0.1, far_clipping_plane=5.0, orientation=[0.1, 0.2, 0.3]
    )
    assert camera.get_resolution() == [32, 16] and camera.get_perspective_angle() == 30.0
    assert (camera.get_near_clipping_plane(), camera.get_far_clipping_plane()) == (0.1, 5.0)
    assert np.allclose(camera.get_orientation(), [0.1, 0.2, 0.3]) and camera.get_render_mode() == RenderMode.OPENGL3
    assert camera.get_perspective_mode() == PerspectiveMode.PERSPECTIVE
    camera.handle_explicitly()
    camera.set_resolution([64, 48])
    camera.set_perspective_angle(90.0)
    assert camera.capture_rgb().shape == (48, 64, 3) and np.isclose(camera.get_intrinsic_matrix()[0, 0], -32.0)
    camera.set_explicit_handling(0)
    with pytest.raises(RuntimeError, match="set_explicit_handling"):
        camera.handle_explicitly()
    with pytest.raises(CameraError):
        camera.set_near_clipping_plane(6.0)
    with pytest.raises(UnsupportedCall, match="perspective"):
        camera.set_perspective_mode(PerspectiveMode.ORTHOGRAPHIC)
    camera.set_entity_to_render(-1)
    assert camera.get_entity_to_render() == -1
    copy = camera.copy()
    camera.remove()
    assert copy.get_resolution() == [64, 48] and not camera.still_exists()


def test_the_cameras_of_observations(pyrep: PyRep) -> None:
    """They deliver what observations show; moved, observations follow; the one on the hand rides along."""
    simulator = Simulator.current()
    front = VisionSensor("cam_front")
    observation = simulator.runtime.get_observation()
    assert np.array_equal(np.rint(front.capture_rgb() * 255.0).astype(np.uint8), observation.front_rgb)
    assert np.allclose(front.capture_depth(), observation.front_depth)
    assert np.array_equal(rgb_handles_to_mask(VisionSensor("cam_front_mask").capture_rgb()), observation.front_mask)
    assert np.allclose(front.get_matrix(), observation.misc["front_camera_extrinsics"])
    assert np.allclose(front.get_position(), [1.35, 0.0, 1.58]) and np.isclose(
        front.get_intrinsic_matrix()[0, 0], -175.84, atol=0.01
    )
    front.set_pose(look_at((1.0, 0.5, 1.5), (0.2, 0.0, 0.9)))
    front.set_resolution([64, 32])
    observation = simulator.runtime.get_observation()
    assert observation.front_rgb is not None and observation.front_rgb.shape == (32, 64, 3)
    assert np.allclose(observation.misc["front_camera_extrinsics"], front.get_matrix())
    assert np.allclose(VisionSensor("cam_front_mask").get_pose(), front.get_pose())
    wrist = VisionSensor("cam_wrist")
    local = wrist.get_pose(relative_to=Dummy("Panda_tip"))
    Joint("Panda_joint1").set_joint_position(0.4)
    assert np.allclose(wrist.get_pose(relative_to=Dummy("Panda_tip")), local, atol=1e-6)
    with pytest.raises(UnsupportedCall, match="VisionSensor.create"):
        front.set_perspective_angle(70.0)


def test_a_camera_circles(pyrep: PyRep) -> None:
    """On the placeholder of videos, whose base turns."""
    base, camera = Dummy("cam_cinematic_base"), VisionSensor.create([32, 32])
    camera.set_pose(Dummy("cam_cinematic_placeholder").get_pose())
    camera.set_parent(Dummy("cam_cinematic_placeholder"))
    radius = np.linalg.norm(camera.get_position(relative_to=base)[:2])
    before = camera.get_position()
    for _ in range(10):
        base.rotate([0.0, 0.0, 0.1])
    moved = camera.get_position()
    assert np.isclose(np.linalg.norm(moved - before), 2.0 * radius * np.sin(0.5))
    ahead = camera.get_matrix()[:3, 2]
    assert ahead @ (base.get_position() - moved) > 0.9 * np.linalg.norm(base.get_position() - moved)


def test_textures(pyrep: PyRep) -> None:
    """On a shape and on the room, and off again."""
    cube, camera = box(0.4, [0.3, 0.3, 1.3]), VisionSensor.create([48, 48], render_mode=RenderMode.OPENGL)
    camera.set_pose(look_at((0.3, 1.5, 1.3), (0.3, 0.3, 1.3)))
    file = next(iter(sorted(TEXTURES.rglob("*.png")) or sorted(TEXTURES.rglob("*.jpg"))))
    holder, texture = pyrep.create_texture(str(file))
    holder.remove()
    plain = camera.capture_rgb()
    for item in (cube, Shape("Wall3"), Shape("Wall4"), Shape("diningTable_visible")):
        before = camera.capture_rgb()
        item.set_texture(texture, uv_scaling=[0.2, 0.2])
        changed = camera.capture_rgb()
        item.remove_texture()
        assert np.array_equal(camera.capture_rgb(), before)
        assert item.get_name() != "Cuboid" or not np.array_equal(changed, before)
    assert np.array_equal(camera.capture_rgb(), plain)
    with pytest.raises(CameraError, match="no_such.png"):
        pyrep.create_texture("no_such.png")


def test_the_arm_can_be_hidden(pyrep: PyRep) -> None:
    """From images and masks, and shown again; resets keep it hidden."""
    mask = VisionSensor("cam_front_mask")
    before = rgb_handles_to_mask(mask.capture_rgb())
    arm = set(range(1, 14))
    assert arm & set(np.unique(before).tolist())
    Shape("Panda").set_renderable(False)
    for _ in range(2):
        assert not arm & set(np.unique(rgb_handles_to_mask(mask.capture_rgb())).tolist())
        Simulator.current().world.build_again()
    Shape("Panda").set_renderable(True)
    assert np.array_equal(rgb_handles_to_mask(mask.capture_rgb()), before)


def test_the_arm_has_colours(pyrep: PyRep) -> None:
    """A link can be painted; the image shows it and says so."""
    hand, camera = Shape("panda_hand"), VisionSensor.create([48, 48], view_angle=20.0, render_mode=RenderMode.OPENGL)
    x, y, z = hand.get_position()
    camera.set_pose(look_at((x + 1.0, y, z), (x, y, z)))
    assert not _red(camera.capture_rgb()).any()
    hand.set_color([1.0, 0.0, 0.0])
    assert hand.get_color() == [1.0, 0.0, 0.0] and Shape("panda_link0").get_color() != [1.0, 0.0, 0.0]
    assert _red(camera.capture_rgb()).sum() > 20
    boundary = Shape("boundary")
    boundary.set_color([0.0, 1.0, 0.0])
    boundary.set_dynamic(False)
    assert boundary.get_color() == [0.0, 1.0, 0.0] and not boundary.is_dynamic() and not boundary.is_respondable()
