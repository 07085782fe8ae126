"""The items of a recording, their seeds, which settings are refused, and `recording.json`, which is checked when it is read."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from rlbench_pin.datasets.layout import ALL_VARIATIONS
from rlbench_pin.environment.episode import drawn_variations
from rlbench_pin.errors import CameraError, EpisodeFileError, TaskEnvironmentError, UnknownName
from rlbench_pin.recording import ImageConfig, RecordConfig, read_recording
from rlbench_pin.recording.config import item_seed, plan_items, write_recording

TASK = "reach_target"
CONFIG = RecordConfig(tasks=(TASK,), episodes=6, variations=2, max_attempts=3, images=ImageConfig(products=()))
FILED = RecordConfig(tasks=("reach_target",), episodes=3, images=ImageConfig(products=()))


def test_the_seed_of_an_item_follows_from_its_name_alone() -> None:
    """Another task, variation, number or seed of the recording is another seed; the order of the plan is no part of it."""
    names = [(s, t, v, i) for s in (0, 1) for t in ("a", "b") for v in range(4) for i in range(50)]
    seeds = {name: item_seed(*name) for name in names}
    assert len(set(seeds.values())) == len(names)
    assert all(0 <= seed < 2**53 for seed in seeds.values())
    assert item_seed(0, "reach_target", 3, 7) == 4230836312881034


def test_a_plan_spreads_episodes_over_variations() -> None:
    """Variations take turns; a longer plan begins like the shorter one, so that a dataset can grow."""
    items = plan_items(replace(CONFIG, episodes=5))
    variations = sorted({item.variation for item in items})
    assert len(variations) == 2
    assert [(item.variation, item.index) for item in items] == [
        (variations[n % 2], n // 2) for n in range(5)
    ]  # fmt: skip
    assert plan_items(replace(CONFIG, episodes=9))[:5] == items
    assert len(plan_items(replace(CONFIG, per_variation=True))) == 12


def test_several_tasks_and_the_same_one_twice() -> None:
    """A task that is named twice is recorded once."""
    items = plan_items(replace(CONFIG, tasks=(TASK, "push_button", TASK), episodes=2))
    assert [item.name for item in items] == [TASK, TASK, "push_button", "push_button"]


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"tasks": ("reach_targt",)}, UnknownName, "Did you mean 'reach_target'"),
        ({"tasks": ()}, TaskEnvironmentError, "rlbench-pin list"),
        ({"episodes": 0}, TaskEnvironmentError, "episodes .* Got 0"),
        ({"variations": 0}, TaskEnvironmentError, "variations .* Got 0"),
        ({"seed": -1}, TaskEnvironmentError, "seed .* Got -1"),
        ({"max_attempts": 0}, TaskEnvironmentError, "max_attempts .* Got 0"),
    ],
)
def test_senseless_settings_are_refused(change: dict[str, object], error: type[Exception], words: str) -> None:
    """Each wrong setting is named with its value, before anything is made."""
    with pytest.raises(error, match=words):
        plan_items(replace(CONFIG, **change))  # type: ignore[arg-type]


def test_senseless_images_are_refused() -> None:
    """Unknown cameras and products and empty images are errors at once."""
    with pytest.raises(UnknownName, match="Did you mean 'wrist'"):
        ImageConfig(cameras=("wrst",))
    with pytest.raises(UnknownName, match="product"):
        ImageConfig(products=("rgbd",))
    with pytest.raises(CameraError, match="image_size"):
        ImageConfig(image_size=(0, 128))


def test_variations_are_drawn_without_repeats() -> None:
    """All where they are few or all are wanted; otherwise as many as wanted, always the same ones."""
    assert drawn_variations(3, 20) == drawn_variations(3, ALL_VARIATIONS) == (0, 1, 2)
    drawn = drawn_variations(60, 20)
    assert len(set(drawn)) == 20
    assert drawn == drawn_variations(60, 20)


def test_the_first_variations() -> None:
    """Which variations there are need not be drawn."""
    items = plan_items(replace(CONFIG, draw_variations=False))
    assert sorted({item.variation for item in items}) == [0, 1]


def test_shadows_and_speed() -> None:
    """Settings of the images and of the arm reach the environment that records."""
    plain = ImageConfig(products=("rgb",), render_mode="opengl")
    assert not plain.obs_config().front_camera.draws_shadows
    assert ImageConfig().obs_config().front_camera.draws_shadows
    with plain.environment(max_velocity=0.5) as environment:
        planner = environment.get_task(TASK).runtime.planner
    assert planner.config.max_velocity == 0.5


def test_settings_come_back(tmp_path: Path) -> None:
    """As they were, tuples included."""
    write_recording(tmp_path, FILED)
    assert read_recording(tmp_path) == FILED


def test_recordings_of_earlier_versions_are_read(tmp_path: Path) -> None:
    """Their settings of images have the key `images`."""
    content = {"version": 1, **asdict(FILED)}
    content["pictures"] = content.pop("images")
    (tmp_path / "recording.json").write_text(json.dumps(content))
    assert read_recording(tmp_path) == FILED


@pytest.mark.parametrize(
    "change",
    [
        {"tasks": "reach_target"}, {"tasks": []}, {"tasks": [1]}, {"tasks": None}, {"episodes": 0}, {"episodes": 1.5},
        {"episodes": True}, {"episodes": 10**30}, {"per_variation": 2}, {"variations": "all"}, {"variations": -2},
        {"draw_variations": "yes"}, {"seed": -1}, {"seed": "0"}, {"max_attempts": 0}, {"max_velocity": 0},
        {"max_velocity": "fast"}, {"max_acceleration": -1.0}, {"max_acceleration": True}, {"unknown": 1},
        {"images": None}, {"images": []}, {"images": {"image_size": [128]}}, {"images": {"image_size": [128, 0]}},
        {"images": {"image_size": [1e9, 1e9]}}, {"images": {"image_size": 0}}, {"images": {"cameras": ["nose"]}},
        {"images": {"cameras": [[]]}}, {"images": {"products": "rgb"}}, {"images": {"renderer": 7}},
        {"images": {"render_mode": "vulkan"}}, {"images": {"compression": "zip"}}, {"images": {"zoom": 3}},
    ],
    ids=str,
)  # fmt: skip
def test_a_setting_that_is_senseless_is_refused(tmp_path: Path, change: dict[str, object]) -> None:
    """With the name of the file and what to do instead."""
    content = {"version": 1, **asdict(FILED), **change}
    (tmp_path / "recording.json").write_text(json.dumps(content))
    with pytest.raises(EpisodeFileError, match=r"recording\.json.*the tasks and the settings"):
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
