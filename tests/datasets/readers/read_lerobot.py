"""Load a folder with the dataset class of `lerobot` and print what it finds as JSON; run by a Python that has it."""

from __future__ import annotations

import json
import sys

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from torch.utils.data import DataLoader


def main(root: str) -> None:
    """Iterate over all frames, and once more over one episode with a window of actions."""
    data = LeRobotDataset("local/rlbench_pin", root=root, video_backend="pyav")
    frames, tasks, states, actions, brightness = 0, set(), [], [], []
    for batch in DataLoader(data, batch_size=16):
        frames += len(batch["index"])
        tasks |= set(batch["task"])
        states.append(batch["observation.state"].numpy())
        actions.append(batch["action"].numpy())
        brightness.append(np.stack([batch[key].numpy().mean(axis=(1, 2, 3)) for key in data.meta.camera_keys]))
    window = LeRobotDataset(
        "local/rlbench_pin", root=root, video_backend="pyav", episodes=[1], delta_timestamps={"action": [0.0, 0.05, 0.1]}
    )
    found = {
        "frames": frames,
        "episodes": data.num_episodes,
        "fps": data.fps,
        "tasks": sorted(tasks),
        "cameras": data.meta.camera_keys,
        "picture": list(data[0][data.meta.camera_keys[0]].shape),
        "state": np.concatenate(states).tolist(),
        "action": np.concatenate(actions).tolist(),
        "brightness": np.concatenate(brightness, axis=1).tolist(),
        "window": list(window[0]["action"].shape),
        "mean": data.meta.stats["observation.state"]["mean"].tolist(),
    }
    sys.stdout.write(json.dumps(found))


if __name__ == "__main__":
    main(sys.argv[1])
