"""A dataset: record it with two processes, read it, and convert its key frames to actions.

What to look for: `record` resumes after an interruption (start the program twice); only the requested fields are read from a
file; a demonstration of a hundred frames has a few key frames, and planned motions to their poses solve the task.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rlbench_pin import Discrete, EndEffectorPoseViaPlanning, Environment, MoveArmThenGripper
from rlbench_pin.datasets import Episode, key_frames, read_demo, read_manifest
from rlbench_pin.environment import key_frame_actions, low_dim_config
from rlbench_pin.recording import ImageConfig, ProcessEngine, RecordConfig, record

ROOT = Path("out/examples/recorded")
TASK = "pick_and_lift"


def main() -> None:
    """Record four demonstrations, read the files, and play the key frames of the first."""
    front = ImageConfig(cameras=("front",), products=("rgb",), image_size=(64, 64))
    config = RecordConfig(tasks=(TASK,), episodes=4, images=front)
    report = record(config, ROOT, engine=ProcessEngine(2), resume=True)
    print(f"{report.found} episodes found, {report.recorded} recorded, {len(report.failed)} failed")

    for entry in read_manifest(ROOT, TASK):
        with Episode(ROOT / TASK / entry.file) as episode:  # reads one field, and one image
            tip, image = episode.array("gripper_pose"), episode[0].front_rgb
            way = np.linalg.norm(np.diff(tip[:, :3], axis=0), axis=1).sum()
            print(f"variation {entry.variation}: {len(tip)} frames, the tip moves {way:.2f} m, first image {image.shape}")

    demo = read_demo(ROOT / TASK / read_manifest(ROOT, TASK)[0].file)
    print(f"{len(demo)} frames, key frames {key_frames(demo)}")
    mode = MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete())
    with Environment(mode, obs_config=low_dim_config()) as environment:
        task = environment.get_task(TASK)
        task.reset_to_demo(demo)
        for action in key_frame_actions(demo):  # tip pose, gripper, and whether collisions are ignored
            _, reward, terminate = task.step(action)
            if terminate:
                break
    print("Playing the key frames gives reward", reward)


if __name__ == "__main__":  # the workers import this file
    main()
