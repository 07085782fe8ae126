"""Training data: frames of demonstrations with chunks of actions, and key frames (`pip install -e '.[learn]'` in a clone).

A small network learns by imitation to predict the commanded joint positions of the next half second of a reach. Its inputs are
the joints and the position of the ball. `FrameDataset` needs no PyTorch; `DataLoader` accepts it directly, here with two worker
processes.

What to look for: the error of the predicted joint positions on a held-out episode falls to a fraction.
"""

from __future__ import annotations

from pathlib import Path

import torch
from torch.utils.data import DataLoader, Subset

from rlbench_pin.datasets import FrameDataset
from rlbench_pin.recording import ImageConfig, ProcessEngine, RecordConfig, record

ROOT = Path("out/examples/reaches")
TASK = "reach_target"
HORIZON = 10  # actions of a chunk, half a second
EPOCHS = 40


def inputs(batch: dict[str, torch.Tensor]) -> torch.Tensor:
    """Return joints and ball of a batch, shape (n, 10)."""
    return torch.cat([batch["joint_positions"], batch["task_low_dim_state"]], dim=1).float()


def error(network: torch.nn.Module, batch: dict[str, torch.Tensor]) -> torch.Tensor:
    """Return the mean error of the predicted joint positions [rad], without actions that only repeat the last one."""
    predicted = network(inputs(batch)).reshape(-1, HORIZON, 7) + batch["joint_positions"][:, None].float()
    apart = (predicted - batch["action"][..., :7].float()).abs().mean(dim=2)
    return apart[~batch["action_is_pad"]].mean()


def main() -> None:
    """Record, train on all episodes except the last, and compare on the last."""
    config = RecordConfig(tasks=(TASK,), episodes=20, variations=1, images=ImageConfig(products=()))
    record(config, ROOT, engine=ProcessEngine(2), resume=True)

    frames = FrameDataset(ROOT, fields=("joint_positions", "task_low_dim_state"), horizon=HORIZON)
    keys = FrameDataset(ROOT, fields=("gripper_pose",), key_frames_only=True)
    print(f"{len(frames)} frames, each with actions {frames[0]['action'].shape}")
    print(f"{len(keys)} steps to a key frame, the first to {keys[0]['action'].round(2)}")

    last = len(frames.episodes) - 1
    held_out = len(frames) - (frames.episodes[last].entry.frames - 1)
    training = DataLoader(Subset(frames, range(held_out)), batch_size=64, shuffle=True, num_workers=2, persistent_workers=True)
    test = next(iter(DataLoader(Subset(frames, range(held_out, len(frames))), batch_size=1000)))

    torch.manual_seed(0)
    network = torch.nn.Sequential(torch.nn.Linear(10, 256), torch.nn.ReLU(), torch.nn.Linear(256, HORIZON * 7))
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-3)
    before = error(network, test).item()
    for _ in range(EPOCHS):
        for batch in training:
            optimizer.zero_grad()
            error(network, batch).backward()
            optimizer.step()
    after = error(network, test).item()
    print(f"mean error on a held-out episode: {before:.4f} rad before, {after:.4f} rad after")
    print("the error has fallen" if after < 0.5 * before else "the error has not fallen by half")


if __name__ == "__main__":  # the workers import this file
    main()
