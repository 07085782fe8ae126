"""What is installed: everything that the package needs at run time, and not much more."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest
from release import build

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "rlbench_pin"
MAX_BYTES = 25_000_000


def _files() -> list[Path]:
    return [p for p in sorted(PACKAGE.rglob("*")) if p.is_file() and "__pycache__" not in p.parts]


def test_the_package_is_small() -> None:
    """Compressed as in a wheel, code and assets together stay under 25 MB."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in _files():
            archive.write(file, file.relative_to(ROOT))
    assert 100_000 < packed.tell() < MAX_BYTES


@pytest.mark.simulation
def test_wheel_and_sdist_hold_the_whole_package(tmp_path: Path) -> None:
    """Every scene, asset and module is in the wheel, nothing of tests and scripts is. Both are small, and twine accepts them."""
    pytest.importorskip("hatchling")
    pytest.importorskip("twine")
    sdist, wheel = sorted(build(ROOT, tmp_path), key=lambda file: file.suffix)
    assert sdist.name.endswith(".tar.gz") and sdist.stat().st_size < MAX_BYTES
    assert wheel.stat().st_size < MAX_BYTES
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
    # These lie at the top of the wheel: Python reads the first at its start, the program `rlbench-pin` is the second.
    top = {"rlbench_pin/compat/rlbench_pin_compat.pth", "rlbench_pin/cli/rlbench_pin_command.py"}
    files = {file.relative_to(ROOT).as_posix() for file in _files()}
    assert names == files - top | {Path(name).name for name in top}
