"""Someone who needs other views: moves a camera of the environment, makes own ones, and checks them against the images."""

import numpy as np
from pyrep.const import RenderMode
from pyrep.objects.dummy import Dummy
from pyrep.objects.object import Object
from pyrep.objects.vision_sensor import VisionSensor
from scipy.spatial.transform import Rotation

from rlbench import CameraConfig, Environment, ObservationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.tasks import PushButton


def look_at(eye, target):
    """Pose of a camera: z forward, x to the left, y up."""
    z = np.asarray(target, float) - eye
    z /= np.linalg.norm(z)
    x = np.cross([0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    return np.concatenate([eye, Rotation.from_matrix(np.column_stack([x, np.cross(z, x), z])).as_quat()])


def difference(a, b):
    return np.abs(a.astype(float) - b.astype(float)).mean()


def make_environment():
    size = (64, 48)
    front = CameraConfig(image_size=size, depth_in_meters=True, render_mode=RenderMode.OPENGL)
    wrist = CameraConfig(image_size=size, point_cloud=False, mask=False, render_mode=RenderMode.OPENGL)
    off = CameraConfig()
    off.set_all(False)
    obs_config = ObservationConfig(
        front_camera=front, wrist_camera=wrist, left_shoulder_camera=off, right_shoulder_camera=off, overhead_camera=off
    )
    return Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=obs_config, headless=True)


def move_the_front_camera(task, before, moved):
    """A camera of the environment, moved: image, matrices and cloud follow."""
    cam = VisionSensor("cam_front")
    assert Object.exists("cam_front") and not Object.exists("cam_of_nobody")
    assert cam.get_resolution() == [64, 48]
    cam.set_pose(moved)
    assert np.allclose(cam.get_pose()[:3], moved[:3], atol=1e-6)
    after = task.get_observation()
    assert difference(before.front_rgb, after.front_rgb) > 5, "the image is still the old one"
    extrinsics = after.misc["front_camera_extrinsics"]
    assert np.allclose(extrinsics, cam.get_matrix(), atol=1e-6)
    assert np.allclose(extrinsics[:3, 3], moved[:3], atol=1e-6)
    cloud = after.front_point_cloud.reshape(-1, 3)
    near = cloud[(np.abs(cloud[:, 0] - 0.25) < 0.25) & (np.abs(cloud[:, 1]) < 0.25) & (cloud[:, 2] < 0.78)]
    assert len(near) > 50 and abs(np.median(near[:, 2]) - 0.752) < 0.01, "the cloud does not lie on the table"
    obs, _, _ = task.step(np.array([0.0] * 7 + [1.0]))
    assert difference(after.front_rgb, obs.front_rgb) < 5, "the camera has gone back by itself"
    return cam


def make_an_own_camera(pose):
    own = VisionSensor.create(
        [96, 72], view_angle=50.0, near_clipping_plane=0.05, far_clipping_plane=4.0, render_mode=RenderMode.OPENGL
    )
    own.set_pose(pose)
    rgb = own.capture_rgb()
    assert rgb.shape == (72, 96, 3) and 0.0 <= rgb.min() < rgb.max() <= 1.0
    depth = own.capture_depth(in_meters=True)
    assert depth.shape == (72, 96) and 0.3 < depth.min() < depth.max() <= 4.0
    ratio = own.capture_depth()
    assert np.allclose(0.05 + ratio * 3.95, depth, atol=1e-3)
    points = own.pointcloud_from_depth(depth)
    same = VisionSensor.pointcloud_from_depth_and_camera_params(depth, own.get_matrix(), own.get_intrinsic_matrix())
    assert np.allclose(points, same, atol=1e-6)
    assert own.get_intrinsic_matrix()[0, 0] < 0, "focal lengths are negative here"
    own.set_resolution([32, 32])
    assert own.capture_rgb().shape == (32, 32, 3)
    return own


def video_from_the_placeholder():
    """The placeholder for cinematic images, as a pose to put a sensor at."""
    placeholder = Dummy("cam_cinematic_placeholder")
    video = VisionSensor.create([80, 45])
    video.set_pose(placeholder.get_pose())
    wide = video.capture_rgb()
    placeholder.set_position([1.0, 0.3, 1.5])
    video.set_position([0.0, 0.0, 0.3], relative_to=placeholder)
    assert wide.std() > 0.05, "the cinematic camera sees nothing"
    assert not np.allclose(video.get_position(), placeholder.get_position())
    return video


def main():
    np.random.seed(4)
    env = make_environment()
    env.launch()
    task = env.get_task(PushButton)
    _, before = task.reset()
    assert before.front_rgb.shape == (48, 64, 3)
    assert before.overhead_rgb is None
    moved = look_at(np.array([0.9, 0.6, 1.4]), [0.25, 0.0, 0.8])
    cam = move_the_front_camera(task, before, moved)
    own = make_an_own_camera(moved)
    video = video_from_the_placeholder()
    print("moved cam_front to", np.round(cam.get_position(), 2), "and made", own.get_name(), "and", video.get_name())
    env.shutdown()


if __name__ == "__main__":
    main()
