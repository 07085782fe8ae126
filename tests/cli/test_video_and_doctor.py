"""Films from the circling camera, and what the doctor says."""

from __future__ import annotations

import json

import av
import numpy as np
import pytest

from rlbench_pin.checking.validate import demo_bytes
from rlbench_pin.cli.doctor import check_image
from rlbench_pin.cli.main import main
from rlbench_pin.environment import demos, library_versions, low_dim_config, make_environment
from rlbench_pin.errors import CameraError
from rlbench_pin.recording.video import Clip, Orbit, grid_frames, grid_size, side_view


def test_the_orbit_stays_inside_the_room_and_looks_at_its_centre():
    """A whole circle stays between the walls; the centre is always in the middle of the image."""
    orbit = Orbit(size=(64, 48))
    for frame in range(0, 1300, 100):
        view = orbit.view(frame)
        x, y, z = view.pose[:3]
        assert -1.75 < x < 2.25 and -2.0 < y < 2.0 and 0.0 < z < 2.8
        local = np.linalg.inv(view.extrinsics()) @ [*orbit.center, 1.0]
        np.testing.assert_allclose(local[:2], 0.0, atol=1e-9)


@pytest.mark.parametrize("name", ["open_oven", "reach_target"])
def test_videos_have_the_arm_and_the_task_in_the_image(name):
    """At the reset nothing but the room is seen along the borders, from the side and from an orbit; the task is not far away."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        task.reset(seed=2)
        world = task.world
        room = [i for i, mask in world.masks.items() if mask.partition("/")[0] in world.room]
        orbit = Orbit(size=(160, 90)).around(world)
        for view in (side_view(world), orbit.view(0), orbit.view(300)):
            mask = world.render(view, rgb=False, depth=False).mask
            assert np.isin([*mask[0], *mask[-1], *mask[:, 0], *mask[:, -1]], room).all()
            rows, columns = np.nonzero(~np.isin(mask, room))
            assert max(np.ptp(rows) / mask.shape[0], np.ptp(columns) / mask.shape[1]) > 0.5


def test_a_grid_shows_all_videos_until_the_longest_ends():
    """Shorter videos stand still at their end; the size is even."""
    clips = {"a": Clip(), "b_c": Clip(), "d": Clip()}
    for clip, (length, gray) in zip(clips.values(), ((2, 60), (4, 120), (1, 200))):
        for _ in range(length):
            clip.add(np.full((41, 61, 3), gray, dtype=np.uint8))
    frames = list(grid_frames(clips, (61, 41)))
    width, height = grid_size(3, (61, 41))
    assert len(frames) == 4 and frames[0].shape == (height, width, 3) and width % 2 == height % 2 == 0
    assert abs(int(frames[-1][35, 30, 0]) - 60) < 4 and abs(int(frames[-1][80, 30, 0]) - 200) < 4


def test_video_writes_a_video_that_moves(tmp_path):
    """`rlbench-pin video` records a task: as many images as it says, none black, the camera moves."""
    assert main(["video", "reach_target", "--size", "96", "64", "--out", str(tmp_path)]) == 0
    with av.open(str(tmp_path / "reach_target.mp4")) as film:
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(frames) > 25 and frames[0].shape == (64, 96, 3)
    assert min(frame.mean() for frame in frames) > 20
    assert np.abs(frames[0].astype(int) - frames[-1].astype(int)).mean() > 1.0


def test_a_smooth_video_has_images_between_the_ticks(tmp_path):
    """`--smooth 3` makes three times as many images for the same time; every third is that of the plain video."""
    videos = {}
    for smooth in (1, 3):
        out = tmp_path / str(smooth)
        assert main(["video", "reach_target", "--size", "96", "64", "--smooth", str(smooth), "--out", str(out)]) == 0
        with av.open(str(out / "reach_target.mp4")) as film:
            stream = film.streams.video[0]
            assert float(stream.average_rate) == 20.0 * smooth
            videos[smooth] = [frame.to_ndarray(format="rgb24").astype(int) for frame in film.decode(video=0)]
    moving = len(videos[1]) - 20
    assert len(videos[3]) == 3 * len(videos[1])
    for tick in range(5, moving, 5):
        assert np.abs(videos[3][3 * tick + 2] - videos[1][tick]).mean() < 4.0


def test_images_between_physics_steps_change_nothing():
    """A demonstration that is looked at before every physics step is the same to the last byte."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("pick_and_lift")
        plain = task.try_demo(seed=2).demo
        looks = []

        def look():
            if len(looks) % 4 == 0:
                Orbit(size=(32, 24)).image(task.world, 0)
            looks.append(1)

        task.world.on_physics.append(look)
        seen = task.try_demo(seed=2).demo
        task.world.on_physics.remove(look)
    assert len(looks) > 500 and plain is not None and seen is not None
    assert demo_bytes(plain) == demo_bytes(seen)


def test_doctor_tries_every_renderer(capsys):
    """The CPU renderer works everywhere; EGL is reported as it is."""
    assert main(["doctor", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    works = {finding["what"]: finding["works"] for finding in report["findings"]}
    assert works["one pybullet"] and works["renderer cpu"] and works["videos"] and "renderer egl" in works
    assert report["versions"]["pybullet"].startswith("3.2.")


def test_doctor_refuses_two_pybullets(monkeypatch, capsys, tmp_path):
    """Both distributions write the same module: the line names both, and the commands that leave one."""
    for name, version in (("pybullet", "3.2.7"), ("pybullet_arm64", "3.2.8")):
        folder = tmp_path / f"{name}-{version}.dist-info"
        folder.mkdir()
        (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(demos, "_version", demos._version.__wrapped__)  # not the versions read before
    assert library_versions()["pybullet"] == "3.2.7, 3.2.8 (pybullet-arm64)"
    assert main(["doctor", "--json"]) == 1
    finding = json.loads(capsys.readouterr().out)["findings"][0]
    assert not finding["works"] and finding["needed"]
    assert "3.2.7 and 3.2.8 (pybullet-arm64)" in finding["detail"]
    assert "`pip uninstall --yes pybullet pybullet-arm64`, then install rlbench-pin again" in finding["detail"]


@pytest.mark.parametrize("picture", [np.zeros((8, 8, 3)), np.full((8, 8, 3), 90.0)])
def test_black_and_flat_images_are_rejected(picture):
    """A renderer that gives them does not work; neither does one that draws no robot."""
    with pytest.raises(CameraError, match="renderer"):
        check_image(picture.astype(np.uint8), np.ones((8, 8), dtype=bool), "egl")
    noise = np.random.default_rng(0).integers(0, 255, (8, 8, 3)).astype(np.uint8)
    check_image(noise, np.ones((8, 8), dtype=bool), "egl")
    with pytest.raises(CameraError, match="robot"):
        check_image(noise, np.zeros((8, 8), dtype=bool), "egl")
