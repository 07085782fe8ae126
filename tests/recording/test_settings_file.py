"""`recording.json` is believed only where every setting has its type and lies in its range."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import pytest

from rlbench_pin.errors import EpisodeFileError
from rlbench_pin.recording import PictureConfig, RecordConfig, read_recording
from rlbench_pin.recording.config import write_recording

CONFIG = RecordConfig(tasks=("reach_target",), episodes=3, pictures=PictureConfig(products=()))


def test_settings_come_back(tmp_path: Path) -> None:
    """As they were, tuples included."""
    write_recording(tmp_path, CONFIG)
    assert read_recording(tmp_path) == CONFIG


@pytest.mark.parametrize(
    "change",
    [
        {"tasks": "reach_target"}, {"tasks": []}, {"tasks": [1]}, {"tasks": None}, {"episodes": 0}, {"episodes": 1.5},
        {"episodes": True}, {"episodes": 10**30}, {"per_variation": 1}, {"variations": "all"}, {"variations": -2},
        {"draw_variations": "yes"}, {"seed": -1}, {"seed": "0"}, {"max_attempts": 0}, {"max_velocity": 0},
        {"max_velocity": "fast"}, {"max_acceleration": -1.0}, {"max_acceleration": True}, {"unknown": 1},
        {"pictures": None}, {"pictures": []}, {"pictures": {"image_size": [128]}}, {"pictures": {"image_size": [128, 0]}},
        {"pictures": {"image_size": [1e9, 1e9]}}, {"pictures": {"image_size": 128}}, {"pictures": {"cameras": ["nose"]}},
        {"pictures": {"cameras": [[]]}}, {"pictures": {"products": "rgb"}}, {"pictures": {"renderer": 7}},
        {"pictures": {"render_mode": "vulkan"}}, {"pictures": {"compression": "zip"}}, {"pictures": {"zoom": 3}},
    ],
    ids=str,
)  # fmt: skip
def test_a_setting_that_is_senseless_is_refused(tmp_path: Path, change: dict[str, object]) -> None:
    """With the name of the file and what to do instead."""
    content = {"version": 1, **asdict(CONFIG), **change}
    (tmp_path / "recording.json").write_text(json.dumps(content))
    with pytest.raises(EpisodeFileError, match=r"recording\.json.*naming the tasks"):
        read_recording(tmp_path)


@pytest.mark.parametrize("text", ["", "[" * 100_000, "[]", "7", "null", "{}", '{"version": NaN}', "\xff", '{"version": 1}'])
def test_what_is_no_recording_is_refused(tmp_path: Path, text: str) -> None:
    """Whatever the file holds, and where it is a folder."""
    (tmp_path / "recording.json").write_bytes(text.encode("latin1"))
    with pytest.raises(EpisodeFileError, match=r"recording\.json"):
        read_recording(tmp_path)
    (tmp_path / "folder" / "recording.json").mkdir(parents=True)
    with pytest.raises(EpisodeFileError, match=r"recording\.json"):
        read_recording(tmp_path / "folder")
