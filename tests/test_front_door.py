"""Importing the package is silent and light, and every public name resolves."""

from __future__ import annotations

import subprocess
import sys

import pytest

import rlbench_pin

HEAVY = ("pybullet", "pinocchio", "coal", "placo", "ompl", "toppra", "osqp", "h5py", "av", "tyro", "scipy")


def _run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)


def test_import_is_silent_and_loads_no_heavy_library() -> None:
    """`import rlbench_pin` prints nothing and brings in none of the libraries that take time to load."""
    result = _run(f"import sys, rlbench_pin; print([m for m in {HEAVY!r} if m in sys.modules])")
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == "[]"
    assert result.stderr == ""


def test_all_is_sorted_and_small() -> None:
    """The package has about a dozen public names, in order."""
    assert list(rlbench_pin.__all__) == sorted(rlbench_pin.__all__)
    assert 10 <= len(rlbench_pin.__all__) <= 20


@pytest.mark.parametrize("name", rlbench_pin.__all__)
def test_every_public_name_resolves(name: str) -> None:
    """Every name of `__all__` can be imported from the package and is listed by `dir`."""
    assert getattr(rlbench_pin, name) is not None
    assert name in dir(rlbench_pin)


@pytest.mark.simulation
@pytest.mark.parametrize(
    "package",
    [
        "robot",
        "planning",
        "planning.kinematics",
        "planning.problems",
        "planning.search",
        "planning.timing",
        "control",
        "control.qp",
    ],
)
def test_parts_have_public_names(package: str) -> None:
    """A part of the package is imported by itself, and its public names resolve."""
    code = f"import rlbench_pin.{package} as part; print(part.__all__ and [n for n in part.__all__ if not hasattr(part, n)])"
    result = _run(code)
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == "[]"


def test_unknown_name_is_an_attribute_error() -> None:
    """A misspelt name fails as python users expect."""
    with pytest.raises(AttributeError, match="Enviroment"):
        _ = rlbench_pin.Enviroment  # type: ignore[attr-defined]


@pytest.mark.simulation
def test_loading_the_environment_prints_nothing() -> None:
    """The simulator's greeting does not reach stdout."""
    result = _run("import rlbench_pin; rlbench_pin.Environment")
    assert result.returncode == 0, result.stderr
    assert result.stdout == ""
