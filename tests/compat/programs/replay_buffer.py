"""The data side of a keyframe agent: stored demonstrations become transitions of voxel indices, rotation bins and clouds."""

import os
import sys
import tempfile

import numpy as np
from pyrep.const import RenderMode
from scipy.spatial.transform import Rotation

from rlbench import dataset_generator
from rlbench.observation_config import CameraConfig, ObservationConfig
from rlbench.utils import get_stored_demos

CAMERAS = ["front", "left_shoulder", "wrist"]
SCENE_BOUNDS = [-0.3, -0.5, 0.6, 0.7, 0.5, 1.6]
VOXEL_SIZE = 100
ROTATION_RESOLUTION = 5
LOW_DIM_SIZE = 4
IMAGE_SIZE = 64
EPISODE_LENGTH = 25


def make_dataset(root):
    sys.argv = [
        "rlbench-generate-dataset",
        "--save_path",
        root,
        "--tasks",
        "open_drawer",
        "--image_size",
        str(IMAGE_SIZE),
        str(IMAGE_SIZE),
        "--episodes_per_task",
        "2",
        "--variations",
        "1",
        "--processes",
        "1",
        "--renderer",
        "opengl",
        "--seed",
        "1",
    ]
    dataset_generator.main()


def obs_config():
    unused = CameraConfig()
    unused.set_all(False)
    used = {
        camera + "_camera": CameraConfig(
            rgb=True,
            depth=False,
            point_cloud=True,
            mask=False,
            image_size=(IMAGE_SIZE, IMAGE_SIZE),
            render_mode=RenderMode.OPENGL,
        )
        for camera in CAMERAS
    }
    return ObservationConfig(
        right_shoulder_camera=unused,
        overhead_camera=unused,
        **used,
        joint_forces=False,
        joint_positions=True,
        joint_velocities=True,
        task_low_dim_state=False,
        gripper_touch_forces=False,
        gripper_pose=True,
        gripper_open=True,
        gripper_matrix=True,
        gripper_joint_positions=True,
    )


def is_stopped(demo, i, obs, stopped_buffer, delta=0.1):
    next_is_not_final = i == (len(demo) - 2)
    gripper_state_no_change = (
        i < (len(demo) - 2)
        and obs.gripper_open == demo[i + 1].gripper_open == demo[i - 1].gripper_open == demo[i - 2].gripper_open
    )
    small_delta = np.allclose(obs.joint_velocities, 0, atol=delta)
    return stopped_buffer <= 0 and small_delta and (not next_is_not_final) and gripper_state_no_change


def keypoint_discovery(demo):
    episode_keypoints = []
    prev_gripper_open = demo[0].gripper_open
    stopped_buffer = 0
    for i, obs in enumerate(demo):
        stopped = is_stopped(demo, i, obs, stopped_buffer)
        stopped_buffer = 4 if stopped else stopped_buffer - 1
        last = i == (len(demo) - 1)
        if i != 0 and (obs.gripper_open != prev_gripper_open or last or stopped):
            episode_keypoints.append(i)
        prev_gripper_open = obs.gripper_open
    if len(episode_keypoints) > 1 and (episode_keypoints[-1] - 1) == episode_keypoints[-2]:
        episode_keypoints.pop(-2)
    return episode_keypoints


def point_to_voxel_index(point):
    low, high = np.array(SCENE_BOUNDS[:3]), np.array(SCENE_BOUNDS[3:])
    return np.clip(np.floor((point - low) / (high - low) * VOXEL_SIZE).astype(int), 0, VOXEL_SIZE - 1)


def quaternion_to_bins(quaternion):
    euler = Rotation.from_quat(quaternion).as_euler("xyz", degrees=True) + 180
    bins = np.around(euler / ROTATION_RESOLUTION).astype(int)
    bins[bins == int(360 / ROTATION_RESOLUTION)] = 0
    return bins


def bins_to_quaternion(bins):
    return Rotation.from_euler("xyz", bins * ROTATION_RESOLUTION - 180, degrees=True).as_quat()


def extract_obs(obs, t):
    """What the network sees: channels first, and four numbers of proprioception."""
    obs.gripper_matrix = None
    obs.joint_positions = None
    if obs.gripper_joint_positions is not None:
        obs.gripper_joint_positions = np.clip(obs.gripper_joint_positions, 0.0, 0.04)
    time = (1.0 - (t / float(EPISODE_LENGTH - 1))) * 2.0 - 1.0
    state = {k: v for k, v in vars(obs).items() if isinstance(v, np.ndarray) and k.split("_")[-1] in ("rgb", "cloud")}
    out = {k: np.transpose(v, [2, 0, 1]).astype(np.float32) for k, v in state.items()}
    out["low_dim_state"] = np.array([obs.gripper_open, *obs.gripper_joint_positions, time], dtype=np.float32)
    for camera in CAMERAS:
        out[camera + "_camera_extrinsics"] = obs.misc[camera + "_camera_extrinsics"]
        out[camera + "_camera_intrinsics"] = obs.misc[camera + "_camera_intrinsics"]
    return out


def add_episode(replay, demo):
    keypoints = keypoint_discovery(demo)
    assert 2 <= len(keypoints) <= EPISODE_LENGTH, keypoints
    current, poses = 0, []
    for k, keypoint in enumerate(keypoints):
        target = demo[keypoint]
        quaternion = target.gripper_pose[3:] / np.linalg.norm(target.gripper_pose[3:])
        if quaternion[-1] < 0:
            quaternion = -quaternion
        voxel, bins = point_to_voxel_index(target.gripper_pose[:3]), quaternion_to_bins(quaternion)
        dot = abs(np.dot(bins_to_quaternion(bins), quaternion))
        assert 2 * np.arccos(min(dot, 1.0)) < np.radians(2 * ROTATION_RESOLUTION), "rotation does not survive its bins"
        poses.append(target.gripper_pose)
        replay.append((extract_obs(demo[current], k), voxel, bins, int(target.gripper_open), float(k == len(keypoints) - 1)))
        current = keypoint
    return poses


def check(replay):
    for obs, voxel, bins, grip, terminal in replay:
        assert obs["front_rgb"].shape == obs["front_point_cloud"].shape == (3, IMAGE_SIZE, IMAGE_SIZE)
        assert obs["low_dim_state"].shape == (LOW_DIM_SIZE,)
        assert np.all((0 < voxel) & (voxel < VOXEL_SIZE - 1)), voxel
        points = obs["left_shoulder_point_cloud"].reshape(3, -1).T
        inside = np.all((points > SCENE_BOUNDS[:3]) & (points < SCENE_BOUNDS[3:]), axis=1)
        assert inside.mean() > 0.2, inside.mean()
        table = points[inside][:, 2]
        assert abs(np.median(table[table < 0.80]) - 0.752) < 0.01, "the table is not where the clouds should have it"


def project(obs, camera, point):
    """Pixel (column, row) of a world point, with the stored camera matrices."""
    extrinsics, intrinsics = obs[camera + "_camera_extrinsics"], obs[camera + "_camera_intrinsics"]
    in_camera = np.linalg.inv(extrinsics) @ np.append(point, 1.0)
    pixel = intrinsics @ in_camera[:3]
    return (pixel[:2] / pixel[2]).round().astype(int)


def main():
    np.random.seed(1)
    with tempfile.TemporaryDirectory() as root:
        make_dataset(root)
        assert os.listdir(root) == ["open_drawer"]
        replay, first = [], None
        for d in range(2):
            demo = get_stored_demos(
                amount=1,
                image_paths=False,
                dataset_root=root,
                variation_number=0,
                task_name="open_drawer",
                obs_config=obs_config(),
                random_selection=False,
                from_episode_number=d,
            )[0]
            poses = add_episode(replay, demo)
            first = poses if first is None else first
            cloud = demo[0].front_point_cloud
            column, row = project(replay[0][0], "front", cloud[40, 30])
            assert (column, row) == (30, 40) or d, "cloud and matrices disagree"
        assert not np.allclose(first[0], poses[0]), "both episodes are the same"
        check(replay)
    print("replay buffer:", len(replay), "transitions, keyframes of the last demo:", len(poses))


if __name__ == "__main__":
    main()
