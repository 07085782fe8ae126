"""A pair of files made by `new` is a task at once, outside the package."""

from __future__ import annotations

from pathlib import Path

import pytest

from rlbench_pin.cli.main import main


def test_a_new_task_passes_check_and_can_be_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without touching the package: checked, and shown."""
    assert main(["new", "touch_it", "--out", str(tmp_path)]) == 0
    file = tmp_path / "touch_it.py"
    assert str(file) in capsys.readouterr().out
    assert main(["check", "--task-file", str(file), "--episodes", "6", "--no-contract"]) == 0
    assert "touch_it" in capsys.readouterr().out
    assert main(["view", str(file), "--out", str(tmp_path / "touch_it.png")]) == 0
    assert (tmp_path / "touch_it.png").stat().st_size > 10_000


@pytest.mark.slow
def test_a_new_task_keeps_the_whole_contract(tmp_path: Path) -> None:
    """Resting and flailing solve nothing, resets repeat, demonstrations succeed."""
    main(["new", "touch_it", "--out", str(tmp_path)])
    assert main(["check", "--task-file", str(tmp_path / "touch_it.py"), "--episodes", "20"]) == 0


def test_an_edited_pair_becomes_another_task(tmp_path: Path) -> None:
    """The scene and the class of the walk-through in CONTRIBUTING.md: pick a cube up."""
    main(["new", "raise_cube", "--out", str(tmp_path)])
    (tmp_path / "raise_cube.toml").write_text(SCENE)
    (tmp_path / "raise_cube.py").write_text(TASK)
    assert main(["check", "--task-file", str(tmp_path / "raise_cube.py"), "--episodes", "5", "--no-contract"]) == 0


@pytest.mark.parametrize(("name", "says"), [("Touch It", "no task name"), ("reach_target", "exists already")])
def test_bad_names_are_refused(name: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Misuse is exit code 2, and nothing is written."""
    assert main(["new", name, "--out", str(tmp_path)]) == 2
    assert says in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_existing_files_are_not_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A second `new` of the same name is refused."""
    assert main(["new", "touch_it", "--out", str(tmp_path)]) == 0
    before = (tmp_path / "touch_it.py").read_text()
    assert main(["new", "touch_it", "--out", str(tmp_path)]) == 2
    assert "would be overwritten" in capsys.readouterr().err
    assert (tmp_path / "touch_it.py").read_text() == before


SCENE = """\
format = 1

[placement]
footprint = [0.1, 0.1]

[[body]]
name = "cube"
asset = "objects/cube_small/cube_small.urdf"
pose = [0.0, 0.0, 0.02]

[[sensor]]
name = "above"
pose = [0.0, 0.0, 0.2]
shape = "box"
size = [0.1, 0.1, 0.05]

[[waypoint]]
name = "waypoint0"
parent = "waypoint1"
pose = [0.0, 0.0, -0.1]
symmetry = 4

[[waypoint]]
name = "waypoint1"
parent = "cube"
pose = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
ignore_collisions = true
gripper = "close"
symmetry = 4

[[waypoint]]
name = "waypoint2"
parent = "waypoint1"
pose = [0.0, 0.0, -0.18]
ignore_collisions = true
symmetry = 4
"""

TASK = '''\
"""Raise a cube."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Grasped, Task


class RaiseCube(Task):
    """The cube has to be held 0.2 m above its place."""

    def init_task(self) -> None:
        self.register_graspable_objects(["cube"])
        cube, above = self.scene.body("cube"), self.scene.sensor("above")
        self.register_success_conditions([Grasped(self.gripper, cube), Detected(cube, above)])

    def variation_count(self) -> int:
        return 1

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        return ["Raise the cube."]
'''
