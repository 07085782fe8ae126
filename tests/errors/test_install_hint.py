"""What an optional library needs is said in one way, which works: from a clone."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

import pytest

import rlbench_pin
from rlbench_pin.errors import MissingExtra, install_hint

ROOT = Path(__file__).resolve().parents[2]
EXTRAS = set(tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"])
TEXTS = [
    *ROOT.glob("*.md"),
    *(ROOT / "docs").rglob("*.md"),
    *(file for folder in ("rlbench_pin", "examples", "scripts") for file in (ROOT / folder).rglob("*.py")),
]


def test_the_hint_installs_from_a_clone() -> None:
    """The package is on no index, so its name alone would find nothing; every error has the same text."""
    assert install_hint("rl") == "`pip install -e '.[rl]'` in a clone of rlbench_pin"
    assert str(MissingExtra("This", "torch", "rl")).endswith(f"which is not installed. {install_hint('rl')} brings it.")


def test_pages_and_programs_say_the_same() -> None:
    """No page asks an index for `rlbench-pin[...]`, and every extra that one names is there."""
    said = {file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8") for file in TEXTS}
    wrong = r"pip install (?:-U |--upgrade )?['\"]?rlbench[-_]pin"
    assert [name for name, text in said.items() if re.search(wrong, text)] == []
    named = {extra for text in said.values() for extra in re.findall(r"'\.\[(\w+)\]'", text)}
    assert {"rl", "human", "lerobot", "zarr", "ray"} <= named
    assert named <= EXTRAS


@pytest.mark.parametrize(
    ("door", "name", "library"), [("recording", "RayEngine", "ray"), ("control", "ForeignSolver", "qpsolvers")]
)
def test_names_that_need_an_extra_say_so(door: str, name: str, library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are looked up when first used, so that the rest of their package works without."""
    monkeypatch.setitem(sys.modules, library, None)
    for module in ("rlbench_pin.processes.ray_engine", "rlbench_pin.control.qp.foreign_solver"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    package = getattr(rlbench_pin, door)
    monkeypatch.delitem(vars(package), name, raising=False)
    with pytest.raises(MissingExtra, match=f"needs '{library}'.*in a clone"):
        getattr(package, name)
