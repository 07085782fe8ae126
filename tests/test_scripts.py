"""The scripts that users are shown run as they stand."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import compare_behaviour
import h5py
import numpy as np
import pytest

from rlbench_pin.datasets import read_demo, read_manifest, stored_demos, verify_task
from rlbench_pin.datasets.formats.rlbench import folder_demos
from rlbench_pin.datasets.layout import episode_path
from rlbench_pin.robot.description import robot_description
from rlbench_pin.scene.reader import read_scene
from rlbench_pin.sim import World
from rlbench_pin.spatial import compose, rotation_distance
from rlbench_pin.tasks.waypoints import waypoints_of

EXPORT = Path(__file__).resolve().parents[1] / "scripts" / "export_demos.py"
TURN = EXPORT.with_name("turn_tip_frame.py")
TASK = "reach_target"


def test_the_table_of_conversions(monkeypatch: pytest.MonkeyPatch) -> None:
    """A cell counts all seeds of a pair; a demonstration that was played for other arms before keeps what they did."""
    spec = importlib.util.spec_from_file_location("conversions", EXPORT.with_name("conversions.py"))
    assert spec is not None and spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "conversions", script)  # its dataclasses look their module up
    spec.loader.exec_module(script)
    found: dict[tuple[str, str, int, str], object] = {}
    for seed, cause in enumerate(("", "contact", "")):
        script.add(found, script.Trial("push_button", "panda", seed, "a", {"ur5e": cause}, 2.0))
    script.add(found, script.Trial("push_button", "panda", 0, "a", {"jaco": "reach"}, 1.0))
    pairs = [("panda", "ur5e"), ("panda", "jaco"), ("ur5e", "panda")]
    rows = script.table(list(found.values()), ["push_button"], pairs)
    assert list(rows) == ["panda -> ur5e", "panda -> jaco"]
    assert (rows["panda -> ur5e"]["count"], rows["panda -> ur5e"]["of"]) == (2, 3)
    text = script.page(rows, ["push_button"], ["panda", "ur5e", "jaco"], 3)
    assert "| `panda` |  | 67 (21 to 94) | 0 (0 to 79) |" in text and "2 of 3: contact 1" in text


def test_the_matrix_keeps_the_arms_that_are_not_named(tmp_path: Path) -> None:
    """The Panda's cell comes from the sweep, that of the UR5e stays; below 80 % a cell has its causes."""
    cell = {"count": 15, "of": 20, "rate": 0.75, "wilson_95": [0.531, 0.888], "causes": {"planning": 5}}
    (tmp_path / "arms.json").write_text(json.dumps({"episodes": 20, "arms": {"ur5e": {TASK: cell}}}))
    command = [
        sys.executable,
        str(EXPORT.with_name("arms_matrix.py")),
        TASK,
        "--robots",
        "panda",
        "--report",
        "--out",
        str(tmp_path),
    ]
    result = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert result.returncode == 0, result.stderr
    arms = json.loads((tmp_path / "arms.json").read_text())["arms"]
    assert list(arms) == ["panda", "ur5e"] and arms["ur5e"] == {TASK: cell} and arms["panda"][TASK]["of"] == 100
    text = (tmp_path / "arms.md").read_text()
    assert "| `ur5e` | 0 of 1 | 15 of 20 (75.0 %) |" in text and "75 % (53 to 89): planning 5 |" in text
    assert (tmp_path / "arms.png").stat().st_size > 1000


def export(out: Path) -> str:
    """Run the script for two small episodes and return what it printed."""
    options = ("--tasks", TASK, "--episodes", "2", "--workers", "1", "--image-size", "32")
    command = [sys.executable, str(EXPORT), "--out", str(out), *options]
    result = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout


@pytest.mark.slow
def test_export_demos(tmp_path: Path) -> None:
    """It records, and every format holds what was recorded; run again, it finds all that is there."""
    printed = export(tmp_path)
    assert "2 recorded now, 0 found, 0 missing" in printed
    assert f"{TASK}: 0 faults" in printed
    assert "the front image is (32, 32, 3)" in printed
    verify_task(tmp_path / "dataset", TASK, structure=True)
    entries = read_manifest(tmp_path / "dataset", TASK)
    demos = [read_demo(episode_path(tmp_path / "dataset", TASK, e.variation, e.episode), sha256=e.sha256) for e in entries]
    with h5py.File(tmp_path / f"{TASK}.hdf5") as file:
        assert [len(file[f"data/demo_{i}/actions"]) for i in range(2)] == [len(demo) - 1 for demo in demos]
    folders = folder_demos(tmp_path / "rlbench", TASK, -1, -1, random_selection=False)
    for demo, folder in zip(demos, folders, strict=True):
        assert np.array_equal([o.joint_positions for o in demo], [o.joint_positions for o in folder])
        assert np.array_equal([o.wrist_rgb for o in demo], [o.wrist_rgb for o in folder])
    assert (tmp_path / "lerobot").is_dir() == (importlib.util.find_spec("pyarrow") is not None)
    again = export(tmp_path)
    assert "0 recorded now, 2 found, 0 missing" in again
    assert f"{tmp_path / 'rlbench'} already exists" in again
    assert "wrote" not in again
    assert len(stored_demos(tmp_path / "dataset", TASK, -1, -1, random_selection=False)) == 2


@pytest.mark.simulation
def test_interpreters_are_compared_by_their_records(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Tasks that a record has are kept; the comparison names each hash that differs, for one interpreter after the other."""
    first, second, out = (tmp_path / name for name in ("first.json", "second.json", "out.json"))
    compare_behaviour.record(first, [TASK])
    content = json.loads(first.read_text())
    assert sorted(content["tasks"]) == [f"{TASK} 0 {part}" for part in ("demonstration", "end", "reset", "state")]
    assert list(content["cameras"]) == list(content["tasks"])
    content["tasks"][f"{TASK} 0 end"] = "other"
    second.write_text(json.dumps(content))
    compare_behaviour.record(second, [TASK])
    assert json.loads(second.read_text()) == content
    assert compare_behaviour.compare_records(first, second, 5, out) == 1
    assert compare_behaviour.compare_records(out, first, 5, out) == 0
    assert "8 values, 1 differ" in capsys.readouterr().out
    assert [len(run["differences"]) for run in json.loads(out.read_text())["runs"]] == [0, 1, 0]
    content["runs"][0]["python"] = "3.0.0"
    second.write_text(json.dumps(content))
    with pytest.raises(SystemExit, match="another interpreter"):
        compare_behaviour.record(second, [TASK])


OLD_SCENE = """format = 2

[[frame]]
name = "grasp_a"                            # poses of the hand
pose = [0.1, 0.2, 0.3]
rpy = [3.1415927, 0.0, 0.5]

[[frame]]
name = "other"
pose = [0.1, 0.2, 0.3]

[[waypoint]]
name = "waypoint0"
parent = "waypoint1"
pose = [0.01, -0.02, -0.1]                  # before it

[[waypoint]]
name = "waypoint1"
parent = "grasp_a"

[[waypoint]]
name = "waypoint2"
parent = "other"

[[waypoint]]
name = "waypoint3"
parent = "other"
path = "curve"
points = [
    [0.3, 0.1, 0.2, 0.0, 0.0, 0.6, 0.8],
]

[[waypoint]]
name = "waypoint4"
parent = "waypoint2"
path = "curve"
arc = { axis = [0.0, 1.0, 0.0], angle = 0.4 }
"""


def test_turn_tip_frame(tmp_path: Path) -> None:
    """Every pose of the gripper is turned about its own z, stays where it is, and comments and other frames stay as they are."""
    file = tmp_path / "scene.toml"
    file.write_text(OLD_SCENE)
    before = hand_poses(file)
    subprocess.run([sys.executable, str(TURN), str(file), "--frames", "grasp_"], check=True, capture_output=True)
    after = hand_poses(file)
    assert after.keys() == before.keys()
    for name, poses in before.items():
        for old, new in zip(poses, after[name], strict=True):
            wanted = old if name == "other" else compose(old, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
            np.testing.assert_allclose(new[:3], wanted[:3], atol=1e-6, err_msg=name)
            assert rotation_distance(new, wanted) < 1e-6, name
    assert "# poses of the hand" in file.read_text() and "# before it" in file.read_text()


def hand_poses(file: Path) -> dict[str, list[np.ndarray]]:
    """Return where frames and waypoints of a scene are in the world, a curve pose by pose."""
    with World(read_scene(file), robot_description("panda")) as world:
        poses = {name: [world.frame(name).pose] for name in ("grasp_a", "other")}
        previous = world.frame("other").pose
        for waypoint in waypoints_of(world):
            curve = waypoint.curve_poses(previous) if waypoint.path == "curve" else [waypoint.pose]
            poses[f"waypoint{waypoint.index}"], previous = curve, curve[-1]
    return poses
