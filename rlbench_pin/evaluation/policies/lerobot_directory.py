"""A policy from the directory `pretrained_model` of a LeRobot checkpoint.

This file needs only numpy, torch and LeRobot. If LeRobot has its own Python environment, copy the file there with
`policy_server.py`, and serve `lambda: LeRobotPolicy(FOLDER)`. Observations and actions have the names in the exports of
`rlbench-pin dataset export lerobot`.
"""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from typing import Any

import numpy as np

STATE, IMAGES, ACTION = "observation.state", "observation.images.", "action"


class LeRobotPolicy:
    """A policy that `lerobot-train` of LeRobot trained on our export.

    The state is the joint positions [rad] and the gripper, 1 open. An action has the same numbers, absolute; the gripper is
    clipped to 0..1.

    Args:
        folder: Folder with `config.json`, `model.safetensors`, and the files of the processors.
        device: Device of torch; when empty, the GPU if there is one.
        max_steps: Suggested maximum number of actions of an episode; None suggests no number.

    Attributes:
        action_mode: Plain data of the action mode.
        obs_config: Plain data of the observations.

    Raises:
        ValueError: The policy was trained on other observations or actions.
    """

    def __init__(self, folder: str, device: str = "", max_steps: int | None = None) -> None:
        self.cameras, self.joints = read_features(Path(folder))
        self.max_steps, self._instruction = max_steps, ""
        self.action_mode = {"mode": "MoveArmThenGripper", "arm": "JointPosition", "gripper": "Discrete"}
        cameras = {name: {"rgb": True, "image_size": list(size)} for name, size in self.cameras.items()}
        self.obs_config = {"joint_positions": True, "gripper_open": True, **({"cameras": cameras} if cameras else {})}
        self._torch = importlib.import_module("torch")
        factory = importlib.import_module("lerobot.policies.factory")
        config = importlib.import_module("lerobot.configs.policies").PreTrainedConfig.from_pretrained(folder)
        self._device = device or ("cuda" if self._torch.cuda.is_available() else "cpu")
        config.device, config.pretrained_path = self._device, folder
        self._policy: Any = factory.get_policy_class(config.type).from_pretrained(folder, config=config)
        self._policy.to(self._device).eval()
        there = {"device_processor": {"device": self._device}}
        self._before, self._after = factory.make_pre_post_processors(
            policy_cfg=config, pretrained_path=folder, preprocessor_overrides=there
        )

    def reset(self, instruction: str, context: Any) -> None:
        """Begin an episode: discard queued observations and actions."""
        if context.joints + 1 != self.joints:
            raise ValueError(f"The policy moves {self.joints - 1} joints, but the arm has {context.joints}. Use another arm.")
        self._instruction = instruction
        self._policy.reset()

    def act(self, observation: Any) -> np.ndarray:
        """Return joint positions [rad] and the gripper, shape (n + 1,)."""
        state = np.append(observation.joint_positions, observation.gripper_open)
        frame: dict[str, Any] = {STATE: self._tensor(state)}
        for name in self.cameras:
            image = getattr(observation, f"{name}_rgb")
            frame[IMAGES + name] = self._tensor(image.transpose(2, 0, 1) / np.float32(255.0))
        frame["task"] = self._instruction
        with self._torch.inference_mode():
            action = self._after(self._policy.select_action(self._before(frame)))
        values = action.squeeze(0).to("cpu").double().numpy().copy()
        values[-1] = np.clip(values[-1], 0.0, 1.0)
        return values  # type: ignore[no-any-return]

    def _tensor(self, array: np.ndarray) -> Any:
        """Return an array as a batch of one."""
        return self._torch.from_numpy(np.ascontiguousarray(array, dtype=np.float32)).unsqueeze(0).to(self._device)


def read_features(folder: Path) -> tuple[dict[str, tuple[int, int]], int]:
    """Return camera -> width and height [px], and the size of an action, from the `config.json` of a directory.

    Raises:
        ValueError: The policy was trained on observations or actions that our exports do not have.
    """
    config = json.loads((folder / "config.json").read_text(encoding="utf-8"))
    inputs, outputs = config.get("input_features") or {}, config.get("output_features") or {}
    if ACTION not in outputs or len(outputs[ACTION]["shape"]) != 1:
        raise ValueError(f"'{folder}' has no output feature `{ACTION}`. Train a policy on an export of rlbench_pin.")
    unknown = [name for name in inputs if name != STATE and not name.startswith(IMAGES)]
    if unknown:
        raise ValueError(f"'{folder}' observes '{unknown[0]}'; exports have {STATE} and {IMAGES}CAMERA. Train on an export.")
    joints = int(outputs[ACTION]["shape"][0])
    if STATE in inputs and list(inputs[STATE]["shape"]) != [joints]:
        raise ValueError(
            f"'{folder}' has states {inputs[STATE]['shape']} and actions [{joints}]; both must be equal. Train on an export."
        )
    shapes = {name.removeprefix(IMAGES): feature["shape"] for name, feature in inputs.items() if name.startswith(IMAGES)}
    return {name: (int(shape[2]), int(shape[1])) for name, shape in shapes.items()}, joints
