"""Imports point down the rows, never sideways or up, and each foreign library has its home packages."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

PACKAGE = "rlbench_pin"
ROOT = Path(__file__).resolve().parents[1] / PACKAGE

# Top row first; the packages of one row do not import each other.
ROWS: tuple[tuple[str, ...], ...] = (
    ("cli", "compat"),
    ("builder", "baselines"),
    ("viewer",),
    ("checking", "evaluation", "recording", "gym"),
    ("environment",),
    ("tasks",),
    ("sim", "planning", "control"),
    ("robot", "scene", "datasets"),
    ("errors", "values", "spatial", "urdf", "observation", "assets", "plugins", "processes", "rates"),
)
FLOOR = len(ROWS) - 1
SHARED = ("errors", "values")
"""What the floor itself stands on: errors and front doors import nothing, values only errors."""

# Records that neighbours exchange. They hold data only, and import nothing but the floor.
RECORDS = ("scene.snapshot", "robot.trajectory")

OPTIONAL = {"small_gicp"}
"""Libraries of extras that a module needs in one function only."""

# Foreign library -> the packages that may import it.
HOMES: dict[str, tuple[str, ...]] = {
    "pybullet": ("sim",),
    "pybullet_data": (),
    "ompl": ("planning",),
    "toppra": ("planning",),
    "osqp": ("control",),
    "placo": ("control",),
    "coal": ("robot",),
    "pinocchio": ("spatial", "robot", "planning", "control", "sim", "baselines", "recording"),
    "h5py": ("datasets",),
    "isal": ("datasets",),
    "pyarrow": ("datasets",),
    "av": ("datasets",),
    "tomllib": ("scene", "checking", "environment", "evaluation", "robot"),
    "tomlkit": ("scene", "builder"),
    "pydantic": ("scene",),
    "xml": ("urdf", "builder"),
    "yaml": ("planning",),
    "qpsolvers": ("control",),
    "scipy": ("planning", "control", "checking", "baselines", "evaluation"),
    "small_gicp": ("baselines",),
    "tyro": ("cli",),
    "tqdm": ("cli",),
    "PIL": ("checking", "recording", "sim", "datasets", "compat", "builder", "viewer", "evaluation"),
    "ray": ("processes",),
    "matplotlib": ("baselines", "evaluation"),
    "zarr": ("datasets",),
    "gymnasium": ("gym", "compat", "baselines"),
    "msgpack": ("evaluation",),
    "vla_eval": ("evaluation",),
    "torch": ("baselines",),
    "safetensors": ("baselines",),
    "stable_baselines3": ("baselines",),
    "trimesh": ("builder", "viewer"),
    "viser": ("builder", "viewer"),
    "manifold3d": (),
    "pickle": ("datasets", "errors"),  # foreign files; may evidence of errors travel?
}


@dataclass(frozen=True)
class Import:
    """One import statement: who imports what, and where."""

    file: Path
    line: int
    target: str

    @property
    def source(self) -> str:
        """Dotted name of the importing module below the package, `""` for the package itself."""
        parts = self.file.relative_to(ROOT).with_suffix("").parts
        return ".".join(p for p in parts if p != "__init__")

    def __str__(self) -> str:
        return f"{self.file.relative_to(ROOT.parent)}:{self.line} imports {self.target}"


def _targets(node: ast.AST) -> list[str]:
    """Dotted names that one import statement loads; `from a import b` counts as `a.b`."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        assert node.level == 0, "imports are absolute"
        return [f"{node.module}.{alias.name}" for alias in node.names]
    return []


@cache
def _imports() -> tuple[Import, ...]:
    nodes = ((file, node) for file in sorted(ROOT.rglob("*.py")) for node in ast.walk(_tree(file)))
    return tuple(Import(file, node.lineno, target) for file, node in nodes for target in _targets(node))  # type: ignore[attr-defined]


@cache
def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


def _package(dotted: str) -> str:
    return dotted.split(".")[0]


def _row(package: str) -> int | None:
    return next((i for i, packages in enumerate(ROWS) if package in packages), None)


def _is_record(dotted: str) -> bool:
    return any(dotted == r or dotted.startswith(r + ".") for r in RECORDS)


def arrow_fault(source: str, target: str) -> str | None:
    """Say why module `source` may not import `target` (both dotted, below the package), or None when it may."""
    here, there = _package(source), _package(target)
    if here == there or not source or there == "__version__":
        return None
    row_here, row_there = _row(here), _row(there)
    if row_here is None or row_there is None:
        return f"'{here if row_here is None else there}' is in none of the rows"
    if _is_record(source):
        return None if row_there == FLOOR else "a record imports only the floor"
    if row_here < row_there or _is_record(target):
        return None
    if row_here == row_there == FLOOR:
        return None if (here, there) == ("observation", "spatial") or there in SHARED else "the bottom row imports nothing"
    return "sideways" if row_here == row_there else "upwards"


def test_every_package_has_a_row() -> None:
    """A new folder or module of the package is put into a row first, and no row names one that is gone."""
    packages = {p.stem for p in ROOT.iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()} - {"__init__", "__pycache__"}
    assert {package for row in ROWS for package in row} == packages


def test_the_architecture_page_draws_these_rows() -> None:
    """The page shows the rows that the test keeps."""
    drawn = "\n".join(" . ".join(row) for row in ROWS)
    assert f"```text\n{drawn}\n```" in (ROOT.parent / "docs" / "architecture.md").read_text(encoding="utf-8")


def test_imports_point_down() -> None:
    """No import goes up or sideways."""
    own = [i for i in _imports() if i.target.split(".")[0] == PACKAGE]
    faults = [(i, arrow_fault(i.source, i.target.removeprefix(PACKAGE + "."))) for i in own]
    assert [f"{i}: {why}" for i, why in faults if why] == []


def test_foreign_libraries_stay_at_home() -> None:
    """Only `sim` imports pybullet, only `planning` OMPL, and so on."""
    foreign = [(i.target.split(".")[0], i) for i in _imports() if i.target.split(".")[0] in HOMES]
    assert [str(i) for library, i in foreign if _package(i.source) not in HOMES[library]] == []
    used = {(library, _package(i.source)) for library, i in foreign}
    assert {(library, home) for library, homes in HOMES.items() for home in homes} == used


def test_no_import_is_hidden_in_a_function() -> None:
    """Imports stand at the top of the file, but for optional extras; and `cli` starts fast because its commands import late."""
    hidden = []
    for file in sorted(ROOT.rglob("*.py")):
        if file.relative_to(ROOT).parts[0] == "cli":
            continue
        functions = [n for n in ast.walk(_tree(file)) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
        inner = {n for f in functions for n in ast.walk(f) if isinstance(n, ast.Import | ast.ImportFrom)}
        lines = sorted(n.lineno for n in inner if not (isinstance(n, ast.Import) and {a.name for a in n.names} <= OPTIONAL))
        hidden += [f"{file.relative_to(ROOT.parent)}:{line}" for line in lines]
    assert hidden == []


@pytest.mark.parametrize(
    ("source", "target", "allowed"),
    [
        ("environment.reset", "tasks.task", True),
        ("sim.world", "robot.description", True),
        ("tasks.task", "errors", True),
        ("robot.collision", "scene.snapshot", True),
        ("sim.world", "planning.planner", False),
        ("robot.model", "scene.reader", False),
        ("scene.reader", "sim.world", False),
        ("errors", "sim", False),
    ],
)
def test_the_rule_itself(source: str, target: str, allowed: bool) -> None:
    """The rule lets through what the architecture draws and stops the rest."""
    assert (arrow_fault(source, target) is None) == allowed
