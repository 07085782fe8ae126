"""A small protocol for tests."""

from __future__ import annotations

from pathlib import Path

SMALL = """
name = "small"
version = 1
cameras = ["front", "wrist"]
image_size = [64, 64]
arm = "EndEffectorPoseViaPlanning"
gripper = "Discrete"
max_steps = 5
max_seconds = 20.0
episodes_of = "task"
tasks = [
    {name = "reach_target", variations = 3, title = "Reach", part = "easy"},
    {name = "push_button", variations = [4, 9], part = "hard"},
]

[splits.train]
episodes = 3

[splits.test]
episodes = 2
seeds = [0, 10]
"""


def small_file(folder: Path, *changes: tuple[str, str]) -> str:
    """Write the small protocol, with texts replaced by others, and return its path."""
    text = SMALL
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    path = folder / f"small{len(list(folder.glob('small*.toml')))}.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)
