"""The pair that is edited lies in a private folder, with what lies beside the real files, and goes away with it."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import replace
from pathlib import Path

import pytest

from rlbench_pin.builder.contracts import TaskText
from rlbench_pin.builder.worker.process import PrivateFolder
from rlbench_pin.errors import InvalidValue
from rlbench_pin.scene.reader import resolve_asset


def _text(folder: Path, scene: str) -> TaskText:
    return TaskText("pick", folder, scene, "x = 1\n")


def test_files_beside_and_above_are_found(tmp_path: Path) -> None:
    """Relative names of the scene lead to the real files; the real pair is neither used nor changed."""
    mine = tmp_path / "tasks" / "mine"
    (tmp_path / "shared").mkdir()
    (mine / "parts").mkdir(parents=True)
    for file in (mine / "cup.urdf", mine / "parts" / "lid.urdf", tmp_path / "shared" / "jar.urdf"):
        file.write_text(file.name)
    (mine / "pick.py").write_text("old")
    names = ("./cup.urdf", "./parts/lid.urdf", "../../shared/jar.urdf")
    folder = PrivateFolder()
    try:
        python = folder.write("world", _text(mine, "\n".join(f'asset = "{name}"' for name in names)))
        assert [resolve_asset(python.with_suffix(".toml"), name).read_text() for name in names] == [
            "cup.urdf",
            "lid.urdf",
            "jar.urdf",
        ]
        assert python.read_text() == "x = 1\n"
        assert (mine / "pick.py").read_text() == "old"
        assert not python.is_symlink()
    finally:
        folder.close()


def test_it_goes_away_and_the_real_files_stay(tmp_path: Path) -> None:
    """Links are removed, not what they lead to."""
    (tmp_path / "cup").mkdir()
    (tmp_path / "cup" / "cup.urdf").write_text("cup")
    folder = PrivateFolder()
    folder.write("world", _text(tmp_path, ""))
    assert (folder.path / "world" / "cup").is_symlink()
    assert folder.path.stat().st_mode & 0o077 == 0
    folder.close()
    folder.close()
    assert not folder.path.exists()
    assert (tmp_path / "cup" / "cup.urdf").read_text() == "cup"


def test_an_update_writes_the_scene_alone(tmp_path: Path) -> None:
    """Unless it names other files."""
    folder = PrivateFolder()
    try:
        before = _text(tmp_path, 'asset = "./a.urdf"')
        python = folder.write("world", before)
        kept = os.stat(python).st_ino
        moved = replace(before, scene='asset = "./a.urdf"  # moved')
        assert folder.update(python, before, moved) == python
        assert os.stat(python).st_ino == kept
        assert python.with_suffix(".toml").read_text() == moved.scene
        (tmp_path / "b.urdf").write_text("b")
        other = replace(before, scene='asset = "./b.urdf"')
        assert (folder.update(python, moved, other).parent / "b.urdf").read_text() == "b"
    finally:
        folder.close()


@pytest.mark.parametrize("name", ["../evil", "a/b", "", "Pick", "pick.py"])
def test_a_name_that_is_no_task_is_refused(tmp_path: Path, name: str) -> None:
    """Nothing is written anywhere."""
    folder = PrivateFolder()
    try:
        with pytest.raises(InvalidValue, match="small letters"):
            folder.write("world", TaskText(name, tmp_path, "", ""))
        assert list(folder.path.iterdir()) == []
    finally:
        folder.close()


def test_it_goes_although_a_forked_process_holds_its_pipes(tmp_path: Path) -> None:
    """Such as one that another library has forked."""
    folder = PrivateFolder()
    forked = os.fork()
    if forked == 0:
        time.sleep(60.0)
        os._exit(0)
    try:
        began = time.monotonic()
        folder.close()
        assert time.monotonic() - began < 10.0
        assert not folder.path.exists()
    finally:
        os.kill(forked, signal.SIGKILL)
        os.waitpid(forked, 0)
