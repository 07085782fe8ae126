"""Load a file with the dataset class of `robomimic` and print what it finds as JSON; run by a Python that has it."""

from __future__ import annotations

import json
import sys

import robomimic.utils.file_utils as file_utils
import robomimic.utils.obs_utils as obs_utils
from robomimic.utils.dataset import SequenceDataset

LOW_DIM, RGB = ["joint_positions", "gripper_open", "gripper_pose"], ["front_image"]


def main(path: str) -> None:
    """Read sequences of ten steps of the episodes to train with."""
    obs_utils.initialize_obs_utils_with_obs_specs([{"obs": {"low_dim": LOW_DIM, "rgb": RGB}}])
    data = SequenceDataset(
        hdf5_path=path, obs_keys=(*LOW_DIM, *RGB), dataset_keys=("actions", "rewards", "dones"), frame_stack=1, seq_length=10,
        pad_frame_stack=True, pad_seq_length=True, get_pad_mask=False, goal_mode=None, hdf5_cache_mode=None,
        hdf5_use_swmr=True, hdf5_normalize_obs=False, filter_by_attribute="train", load_next_obs=True,
    )  # fmt: skip
    first = data[0]
    found = {
        "environment": file_utils.get_env_metadata_from_dataset(path),
        "shapes": file_utils.get_shape_metadata_from_dataset(path, all_obs_keys=[*LOW_DIM, *RGB])["all_shapes"],
        "steps": len(data),
        "actions": list(first["actions"].shape),
        "pictures": list(first["obs"]["front_image"].shape),
        "joints": first["obs"]["joint_positions"][0].tolist(),
        "next_joints": first["next_obs"]["joint_positions"][0].tolist(),
        "rewards": float(sum(data[i]["rewards"][0] for i in range(len(data)))),
    }
    sys.stdout.write(json.dumps(found))


if __name__ == "__main__":
    main(sys.argv[1])
