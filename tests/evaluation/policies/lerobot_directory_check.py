"""Run by a Python with LeRobot: makes a directory of a policy, and asks it through us and through LeRobot."""

from __future__ import annotations

import json
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import torch
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.policies.act.modeling_act import ACTPolicy
from lerobot.policies.factory import make_pre_post_processors
from lerobot.utils.control_utils import predict_action


def make(folder: str) -> tuple[Any, Any, Any]:
    """Write a small ACT policy as `lerobot-train` does, and return it with its processors."""
    config = ACTConfig(
        device="cpu", chunk_size=4, n_action_steps=2, dim_model=32, n_heads=2, dim_feedforward=32, n_encoder_layers=1,
        n_vae_encoder_layers=1, latent_dim=4, pretrained_backbone_weights=None, push_to_hub=False,
    )  # fmt: skip
    front = PolicyFeature(FeatureType.VISUAL, (3, 48, 64))
    config.input_features = {"observation.state": PolicyFeature(FeatureType.STATE, (8,)), "observation.images.front": front}
    config.output_features = {"action": PolicyFeature(FeatureType.ACTION, (8,))}
    numbers = {"mean": torch.zeros(8), "std": torch.ones(8), "min": -torch.ones(8), "max": torch.ones(8)}
    picture = {name: value[:3].reshape(3, 1, 1) for name, value in numbers.items()}
    statistics = {
        "observation.state": numbers,
        "action": {**numbers, "mean": torch.full((8,), 0.3)},
        "observation.images.front": picture,
    }
    policy, (before, after) = ACTPolicy(config), make_pre_post_processors(config, dataset_stats=statistics)
    for part in (policy, before, after):
        part.save_pretrained(folder)
    return policy.eval(), before, after


def main() -> None:
    """Compare over a few actions, which come in chunks."""
    sys.path.insert(0, sys.argv[1])
    from lerobot_directory import LeRobotPolicy

    policy, before, after = make(sys.argv[2])
    ours = LeRobotPolicy(sys.argv[2], device="cpu")
    rng = np.random.default_rng(0)
    ours.reset("go", SimpleNamespace(joints=7))
    policy.reset()
    answers: dict[str, list[list[float]]] = {"ours": [], "theirs": []}
    for _ in range(5):
        q, picture = rng.normal(size=7), rng.integers(0, 256, (48, 64, 3), dtype=np.uint8)
        answers["ours"].append(ours.act(SimpleNamespace(joint_positions=q, gripper_open=1.0, front_rgb=picture)).tolist())
        frame = {"observation.state": np.append(q, 1.0).astype(np.float32), "observation.images.front": picture}
        action = predict_action(frame, policy, torch.device("cpu"), before, after, use_amp=False, task="go")
        values = action.squeeze(0).double().numpy()
        answers["theirs"].append([*values[:-1].tolist(), float(np.clip(values[-1], 0.0, 1.0))])
    sys.stdout.write(json.dumps({**answers, "action_mode": ours.action_mode, "obs_config": ours.obs_config}) + "\n")


if __name__ == "__main__":
    main()
