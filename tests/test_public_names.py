"""Importing the package is silent and light; public names are listed, exist, and are all that pages and examples import."""

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
from docs_lib.public import public_names

import rlbench_pin
from rlbench_pin.errors import MissingExtra
from rlbench_pin.tasks import camel_case, library_names

ROOT = Path(__file__).resolve().parents[1]
HEAVY = ("pybullet", "pinocchio", "coal", "placo", "ompl", "toppra", "osqp", "h5py", "av", "tyro", "scipy")


PACKAGE = ROOT / "rlbench_pin"


PUBLIC = public_names()
PUBLIC["rlbench_pin.tasks"] += [camel_case(name) for name in library_names()]
PACKAGES = sorted(PUBLIC)
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


def test_the_package_has_few_names() -> None:
    """About two dozen, beside its packages and modules."""
    own = [name for name in rlbench_pin.__all__ if not (PACKAGE / name).is_dir() and not (PACKAGE / f"{name}.py").exists()]
    assert 10 <= len(own) <= 25


def test_a_wrong_name_is_an_attribute_error() -> None:
    """Python proposes near names in its message, because `dir` lists them."""
    with pytest.raises(AttributeError, match="Enviroment"):
        rlbench_pin.Enviroment  # noqa: B018
    assert "Environment" in dir(rlbench_pin)


def _place(name: str) -> tuple[int, str]:
    """Constants first, then classes, then functions, each in alphabetical order."""
    return (0 if name.isupper() else 1 if name[0].isupper() else 2), name


@pytest.mark.parametrize("package_name", PACKAGES)
def test_public_names_exist(package_name: str) -> None:
    """Its public names are in order, there, and listed by `dir`; a package that needs an extra names it."""
    try:
        package = importlib.import_module(package_name)
    except MissingExtra as error:
        assert importlib.util.find_spec(error.library) is None
        pytest.skip(str(error))
    is_lazy = (PACKAGE.parent / package_name.replace(".", "/") / "__init__.pyi").exists()
    assert list(package.__all__) == sorted(set(package.__all__), key=None if is_lazy else _place)
    assert [name for name in package.__all__ if not hasattr(package, name)] == []
    assert set(package.__all__) <= set(dir(package))


@pytest.mark.parametrize("file", sorted((ROOT / "rlbench_pin").glob("*.py")), ids=lambda file: file.stem)
def test_modules_list_all_that_is_public(file: Path) -> None:
    """Every class and function of a module that says what is public."""
    defined = ast.parse(file.read_text(encoding="utf-8")).body
    public = {node.name for node in defined if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_")}
    if f"rlbench_pin.{file.stem}" in PACKAGES:
        assert public <= set(importlib.import_module(f"rlbench_pin.{file.stem}").__all__)


def test_every_folder_is_reached_from_the_package() -> None:
    """`rlbench_pin.planning` is there after `import rlbench_pin`, and listed."""
    folders = {path.parent.name for path in (ROOT / "rlbench_pin").glob("*/__init__.py")} - {
        "assets",
        "baselines",
        "builder",
        "cli",
        "processes",
        "viewer",
    }
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
def test_pages_and_examples_import_public_names(file: Path) -> None:
    """No page and no example reaches into a package."""
    asked = [found for code in _programs(file) for found in _own_imports(code)]
    known = {(package, name) for package, names in PUBLIC.items() for name in names}
    assert [f"from {package_name} import {name}" for package_name, name in asked if (package_name, name) not in known] == []


NOT_IMPORTED = {"rlbench_pin.tasks.stored", "rlbench_pin.evaluation.vla_eval_benchmark"}
"""A file of the user's, and a module that needs an extra."""


@pytest.mark.parametrize("file", TEXTS, ids=lambda file: file.name)
def test_names_in_the_prose_exist(file: Path) -> None:
    """`rlbench_pin.a.b` in backticks can be looked up."""
    prose = re.sub(r"```.*?```", "", file.read_text(encoding="utf-8"), flags=re.DOTALL)
    for dotted in set(re.findall(r"`(rlbench_pin(?:\.\w+)+)", prose)) - NOT_IMPORTED:
        value: object = rlbench_pin
        for name in dotted.split(".")[1:]:
            value = getattr(value, name)


@pytest.mark.simulation
@pytest.mark.parametrize(
    "package_name", ["rlbench_pin.robot", "rlbench_pin.planning", "rlbench_pin.control", "rlbench_pin.sim", "rlbench_pin.tasks"]
)
def test_parts_are_imported_by_themselves(package_name: str) -> None:
    """In a process of its own, and all public names resolve."""
    result = _run(f"import {package_name} as part; print(part.__all__ and [n for n in part.__all__ if not hasattr(part, n)])")
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == "[]"


@pytest.mark.simulation
def test_loading_the_environment_prints_nothing() -> None:
    """The simulator's greeting does not reach stdout."""
    result = _run("import rlbench_pin; rlbench_pin.Environment")
    assert result.returncode == 0, result.stderr
    assert result.stdout == ""
