"""Importing the package is silent and light, every public name is at a front door, a wrong name is answered."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import rlbench_pin
from rlbench_pin.errors import MissingExtra
from rlbench_pin.front_door import public_names
from rlbench_pin.tasks import camel_case, library_names

ROOT = Path(__file__).resolve().parents[1]
HEAVY = ("pybullet", "pinocchio", "coal", "placo", "ompl", "toppra", "osqp", "h5py", "av", "tyro", "scipy")
DOORS = sorted({door for door, _ in public_names()})
LAZY = {f"rlbench_pin.{file.parent.name}" for file in (ROOT / "rlbench_pin").glob("*/__init__.pyi")}
"""Packages whose names `lazy_loader` looks up; it answers wrong names, and sorts `__all__`."""
OUTER = [door for door in DOORS if door.count(".") == 1 and door not in LAZY]
TEXTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
PROGRAMS = sorted((ROOT / "examples").rglob("*.py"))


def _run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)


def test_import_is_silent_and_loads_no_heavy_library() -> None:
    """`import rlbench_pin` prints nothing and brings in none of the libraries that take time to load, nor does `dir`."""
    code = (
        f"import sys, rlbench_pin; dir(rlbench_pin), hasattr(rlbench_pin, 'x'); print([m for m in {HEAVY!r} if m in sys.modules])"
    )
    result = _run(code)
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == "[]"
    assert result.stderr == ""


def test_the_first_door_is_small() -> None:
    """The package has about two dozen public names."""
    assert 10 <= len(rlbench_pin.__all__) <= 25


def _place(name: str) -> tuple[int, str]:
    """Constants first, then classes, then functions, each in alphabetical order."""
    return (0 if name.isupper() else 1 if name[0].isupper() else 2), name


@pytest.mark.parametrize("door", DOORS)
def test_a_door_opens(door: str) -> None:
    """Its public names are in order, there, and listed by `dir`; a door that wants an extra says which."""
    try:
        package = importlib.import_module(door)
    except MissingExtra as error:
        assert importlib.util.find_spec(error.library) is None
        pytest.skip(str(error))
    assert list(package.__all__) == sorted(set(package.__all__), key=None if door in LAZY else _place)
    assert [name for name in package.__all__ if not hasattr(package, name)] == []
    assert set(package.__all__) <= set(dir(package))


@pytest.mark.parametrize("file", sorted((ROOT / "rlbench_pin").glob("*.py")), ids=lambda file: file.stem)
def test_modules_list_all_that_is_public(file: Path) -> None:
    """Every class and function of a module that says what is public."""
    defined = ast.parse(file.read_text(encoding="utf-8")).body
    public = {node.name for node in defined if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_")}
    if f"rlbench_pin.{file.stem}" in DOORS:
        assert public <= set(importlib.import_module(f"rlbench_pin.{file.stem}").__all__)


def test_every_folder_is_reached_from_the_package() -> None:
    """`rlbench_pin.planning` is there after `import rlbench_pin`, and listed."""
    folders = {path.parent.name for path in (ROOT / "rlbench_pin").glob("*/__init__.py")} - {"assets", "cli"}
    assert folders <= set(dir(rlbench_pin))
    assert all(getattr(rlbench_pin, name).__name__ == f"rlbench_pin.{name}" for name in folders | {"spatial", "observation"})


def test_classes_of_tasks_are_names_of_the_package_of_tasks() -> None:
    """All of the library."""
    assert {camel_case(name) for name in library_names()} <= set(dir(rlbench_pin.tasks))
    assert rlbench_pin.tasks.ReachTarget.__name__ == "ReachTarget"  # type: ignore[attr-defined]


# What pages and examples import -------------------------------------------------------------------------------------------------


def _own_imports(code: str) -> Iterator[tuple[str, str]]:
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "rlbench_pin":
            yield from ((str(node.module), alias.name) for alias in node.names)


def _programs(file: Path) -> list[str]:
    """Return the Python in a file, without files of the package and its tests that a page shows."""
    text = file.read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL) if file.suffix == ".md" else [text]
    return [block for block in blocks if not re.match(r"# (rlbench_pin|tests|examples)/", block)]


@pytest.mark.parametrize("file", [*TEXTS, *PROGRAMS], ids=lambda file: file.relative_to(ROOT).as_posix())
def test_what_users_see_imported_is_at_a_front_door(file: Path) -> None:
    """No page and no example reaches into a package."""
    asked = [found for code in _programs(file) for found in _own_imports(code)]
    known = {*public_names(), *(("rlbench_pin.tasks", camel_case(name)) for name in library_names())}
    assert [f"from {door} import {name}" for door, name in asked if (door, name) not in known] == []


@pytest.mark.parametrize("file", TEXTS, ids=lambda file: file.name)
def test_names_in_the_prose_exist(file: Path) -> None:
    """`rlbench_pin.a.b` in backticks can be looked up."""
    prose = re.sub(r"```.*?```", "", file.read_text(encoding="utf-8"), flags=re.DOTALL)
    for dotted in set(re.findall(r"`(rlbench_pin(?:\.\w+)+)", prose)) - {"rlbench_pin.tasks.stored"}:
        value: object = rlbench_pin
        for name in dotted.split(".")[1:]:
            value = getattr(value, name)


# Wrong names --------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("door", "name", "says"),
    [
        ("rlbench_pin", "planing", "Did you mean 'planning'?"),
        ("rlbench_pin", "Enviroment", "Did you mean 'Environment'"),
        ("rlbench_pin", "ReachTaget", "Did you mean 'ReachTarget' of rlbench_pin.tasks?"),
        ("rlbench_pin", "MotionPlanner", "It is in rlbench_pin.planning: `from rlbench_pin.planning import MotionPlanner`."),
        ("rlbench_pin", "EndEfectorVelocity", "Did you mean 'EndEffectorVelocity'?"),
        ("rlbench_pin", "zzz", "`dir(rlbench_pin)` lists the names."),
        ("rlbench_pin.planning", "MotionPlaner", "Did you mean 'MotionPlanner'?"),
        ("rlbench_pin.planning", "motionplanner", "Did you mean 'MotionPlanner'?"),
        ("rlbench_pin.planning", "DifferentialIK", "It is in rlbench_pin.control"),
        ("rlbench_pin.control", "Environment", "It is in rlbench_pin: `from rlbench_pin import Environment`."),
        ("rlbench_pin.gym", "GymnasiumEnvironment", "Did you mean 'GymnasiumEnv'?"),
        ("rlbench_pin.tasks", "ReachTaget", "Did you mean 'ReachTarget'?"),
        ("rlbench_pin.spatial", "above_tabel", "Did you mean 'above_table'?"),
    ],
)
def test_a_wrong_name_is_answered(door: str, name: str, says: str) -> None:
    """As an attribute and in an import, with the nearest name or the package that has it."""
    package = importlib.import_module(door)
    with pytest.raises(AttributeError) as by_attribute:
        getattr(package, name)
    assert str(by_attribute.value).startswith(f"module '{door}' has no attribute '{name}'")
    assert says in str(by_attribute.value)
    with pytest.raises(ImportError) as by_import:
        exec(f"from {door} import {name}", {})
    assert str(by_import.value).startswith(f"cannot import name '{name}' from '{door}'")
    assert says in str(by_import.value)


@pytest.mark.parametrize("door", OUTER)
def test_every_door_answers(door: str) -> None:
    """A name that is nearly one of its own, and one that is none, without loading anything for it."""
    package = importlib.import_module(door)
    own = package.__all__[0]
    with pytest.raises(AttributeError, match=f"Did you mean .*'{own}'"):
        getattr(package, f"{own}x")
    assert not hasattr(package, "no_such_name_anywhere")
    assert not hasattr(package, "__wrapped__")


@pytest.mark.simulation
@pytest.mark.parametrize(
    "door", ["rlbench_pin.robot", "rlbench_pin.planning", "rlbench_pin.control", "rlbench_pin.sim", "rlbench_pin.tasks"]
)
def test_parts_are_imported_by_themselves(door: str) -> None:
    """In a process of its own, and all public names resolve."""
    result = _run(f"import {door} as part; print(part.__all__ and [n for n in part.__all__ if not hasattr(part, n)])")
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == "[]"


@pytest.mark.simulation
def test_loading_the_environment_prints_nothing() -> None:
    """The simulator's greeting does not reach stdout."""
    result = _run("import rlbench_pin; rlbench_pin.Environment")
    assert result.returncode == 0, result.stderr
    assert result.stdout == ""
