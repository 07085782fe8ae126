"""The committed assets are what the script makes: byte for byte, but for the diagonals and the order of the faces of hulls."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.assets import ASSETS

SCRIPT = Path(__file__).parents[2] / "scripts" / "build_assets.py"


def _files(folder: Path, names: tuple[str, ...]) -> dict[str, bytes]:
    """Return the contents of files and folders below `folder`, by relative path."""
    paths = [p for name in names for p in ((folder / name).rglob("*") if (folder / name).is_dir() else [folder / name])]
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in paths if p.is_file()}


def _mesh(content: bytes) -> tuple[set[str], float, float]:
    """Return the lines of an OBJ file without faces and shades, the enclosed volume [m^3], and the mean shade of its vertices.

    The library that computes hulls orders triangles, and cuts flat faces into them, as the rounding of the processor has it;
    corners of other triangles may have other shades, and with them more or fewer vertices at one place.
    """
    lines = content.decode().splitlines()
    words = [line.split() for line in lines if line.startswith("v ")]
    vertices = np.array([line[1:4] for line in words], dtype=float)
    faces = [[int(corner.split("/")[0]) - 1 for corner in line.split()[1:]] for line in lines if line.startswith("f ")]
    volume = sum(float(np.dot(a, np.cross(b, c))) / 6.0 for a, b, c in (vertices[face] for face in faces))
    shade = float(np.mean([float(line[4]) if len(line) > 4 else 1.0 for line in words]))
    return {" ".join(line.split()[:4]) for line in lines if not line.startswith("f ")}, volume, shade


def _differs(name: str, made: bytes, kept: bytes) -> bool:
    if made == kept:
        return False
    if not name.endswith(".obj"):
        return True
    (lines, volume, shade), (kept_lines, kept_volume, kept_shade) = _mesh(made), _mesh(kept)
    return lines != kept_lines or abs(volume - kept_volume) > 1e-6 * abs(kept_volume) or abs(shade - kept_shade) > 0.05


def _assert_same(made: dict[str, bytes], kept: dict[str, bytes]) -> None:
    assert sorted(made) == sorted(kept)
    assert [name for name in made if _differs(name, made[name], kept[name])] == []


@pytest.mark.simulation
def test_objects_rebuild_to_the_same_bytes(tmp_path: Path) -> None:
    """Objects, room, textures, catalogue and licences."""
    subprocess.run([sys.executable, str(SCRIPT), "--only", "objects", "--out", str(tmp_path)], check=True)
    names = ("objects", "room", "textures", "CATALOGUE.md", "LICENSES.md")
    _assert_same(_files(tmp_path, names), _files(ASSETS, names))


@pytest.mark.slow
@pytest.mark.parametrize("arm", ("panda", "ur5e", "xarm7", "jaco", "iiwa"))
def test_arms_rebuild_to_the_same_bytes(arm: str, tmp_path: Path) -> None:
    """The arms, from the files of example-robot-data and airo-models, and from our own code."""
    airo = os.environ.get("RLBENCH_PIN_AIRO")
    if arm == "ur5e" and airo is None and importlib.util.find_spec("airo_models") is None:
        pytest.skip("airo-models is not installed, and RLBENCH_PIN_AIRO names no folder where its wheel is unpacked")
    more = ["--airo", airo] if airo else []
    subprocess.run([sys.executable, str(SCRIPT), "--only", arm, "--out", str(tmp_path), *more], check=True)
    _assert_same(_files(tmp_path, (f"robots/{arm}",)), _files(ASSETS, (f"robots/{arm}",)))


@pytest.mark.simulation
def test_an_arm_without_its_source_stays_as_it_is(tmp_path: Path) -> None:
    """The script says which files it wants, and writes nothing."""
    command = [sys.executable, str(SCRIPT), "--only", "ur5e", "--out", str(tmp_path), "--airo", str(tmp_path)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    assert "ur5e is not changed" in done.stderr
    assert "airo" in done.stderr
    assert list(tmp_path.rglob("*.*")) == []
