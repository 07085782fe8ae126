"""The committed assets are what the script makes, byte for byte."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rlbench_pin.assets import ASSETS

SCRIPT = Path(__file__).parents[2] / "scripts" / "build_assets.py"


def _files(folder: Path, names: tuple[str, ...]) -> dict[str, bytes]:
    """Return the contents of files and folders below `folder`, by relative path."""
    paths = [p for name in names for p in ((folder / name).rglob("*") if (folder / name).is_dir() else [folder / name])]
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in paths if p.is_file()}


def _assert_same(made: dict[str, bytes], kept: dict[str, bytes]) -> None:
    assert sorted(made) == sorted(kept)
    assert [name for name in made if made[name] != kept[name]] == []


@pytest.mark.simulation
def test_objects_rebuild_to_the_same_bytes(tmp_path: Path) -> None:
    """Objects, room, textures, catalogue and licences."""
    subprocess.run([sys.executable, str(SCRIPT), "--only", "objects", "--out", str(tmp_path)], check=True)
    names = ("objects", "room", "textures", "CATALOGUE.md", "LICENSES.md")
    _assert_same(_files(tmp_path, names), _files(ASSETS, names))


@pytest.mark.slow
def test_the_robot_rebuilds_to_the_same_bytes(tmp_path: Path) -> None:
    """The robot, from the files of example-robot-data."""
    subprocess.run([sys.executable, str(SCRIPT), "--only", "panda", "--out", str(tmp_path)], check=True)
    _assert_same(_files(tmp_path, ("robots/panda",)), _files(ASSETS, ("robots/panda",)))
