"""Sizes of folders, files and functions, docstrings everywhere, no patching and no module state."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "rlbench_pin"
FOLDERS = ("rlbench_pin", "tests", "benchmarks", "scripts", "examples")
MAX_FILE, MAX_FUNCTION, MAX_MODULES = 300, 40, 15
WIDE_FOLDERS = (PACKAGE / "tasks" / "library", PACKAGE / "compat" / "packages" / "rlbench" / "tasks")
"""One pair of files per task, and one file per task name that users of RLBench know."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


def _files(*folders: str) -> list[Path]:
    return [file for folder in folders for file in sorted((ROOT / folder).rglob("*.py"))]


def _name(file: Path) -> str:
    return file.relative_to(ROOT).as_posix()


@cache
def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


def test_files_have_at_most_300_lines() -> None:
    """A longer file holds a second idea."""
    lengths = {_name(file): file.read_text(encoding="utf-8").count("\n") for file in _files(*FOLDERS)}
    assert {name: n for name, n in lengths.items() if n > MAX_FILE} == {}


def test_functions_have_at_most_40_lines() -> None:
    """Docstring included."""
    found = [
        f"{_name(file)}:{node.lineno} {node.name}"
        for file in _files(*FOLDERS)
        for node in ast.walk(_tree(file))
        if isinstance(node, Function) and (node.end_lineno or 0) - node.lineno >= MAX_FUNCTION
    ]
    assert found == []


def test_folders_have_at_most_15_modules() -> None:
    """Except where each task has its file."""
    counts = {_name(d): len(list(d.glob("*.py"))) for d in PACKAGE.rglob("*") if d.is_dir() and d not in WIDE_FOLDERS}
    assert {name: n for name, n in counts.items() if n > MAX_MODULES} == {}


# Docstrings -------------------------------------------------------------------------------------------------------------------


def _public(node: ast.AST, name: str = "") -> Iterator[tuple[str, ast.AST]]:
    """Yield what is public below a node: not underscored, not inside a function, not an overload."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.ClassDef | Function) and not child.name.startswith("_"):
            if any("overload" in ast.unparse(d) or ".setter" in ast.unparse(d) for d in child.decorator_list):
                continue
            yield f"{name}{child.name}", child
            if isinstance(child, ast.ClassDef):
                yield from _public(child, f"{child.name}.")


def test_everything_public_has_a_docstring() -> None:
    """Modules, classes, functions and methods."""
    lacking = []
    for file in _files("rlbench_pin"):
        tree = _tree(file)
        lacking += [] if ast.get_docstring(tree) else [_name(file)]
        lacking += [f"{_name(file)}: {name}" for name, node in _public(tree) if not ast.get_docstring(node)]  # type: ignore[arg-type]
    assert lacking == []


# Patching and state -----------------------------------------------------------------------------------------------------------

RECORDS = ("self", "observation", "frame", "config", "camera")
"""What `setattr` may fill by name: oneself, and records that hold data only."""
CHANGES = ("append", "add", "update", "pop", "clear", "setdefault", "extend", "remove", "insert")
MUTABLE = (ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp)


def _patches(file: Path) -> Iterator[str]:
    for node in ast.walk(_tree(file)):
        called = node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
        if called in ("setattr", "delattr") and ast.unparse(node.args[0]) not in RECORDS:  # type: ignore[attr-defined]
            yield f"{_name(file)}:{node.lineno} {called}"  # type: ignore[attr-defined]
        if isinstance(node, ast.Attribute) and node.attr in ("meta_path", "path_hooks"):
            yield f"{_name(file)}:{node.lineno} {node.attr}"
    if "ignore[method-assign" in file.read_text(encoding="utf-8"):  # the type checker finds methods that are replaced
        yield f"{_name(file)} replaces a method"


def test_no_object_is_patched() -> None:
    """No attribute of another object is set by name, no method is replaced, no import hook is installed."""
    assert [found for file in _files("rlbench_pin", "benchmarks") for found in _patches(file)] == []


def _private_uses(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield uses of underscored attributes of anything but oneself."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr.startswith("_") and not node.attr.startswith("__"):
            used = ast.unparse(node)
            if used not in (f"self.{node.attr}", f"cls.{node.attr}", "os._exit"):
                yield node.lineno, used


def test_private_attributes_are_private() -> None:
    """What begins with an underscore is used by its own object alone."""
    found = [f"{_name(file)}:{line} {used}" for file in _files("rlbench_pin") for line, used in _private_uses(_tree(file))]
    assert found == []
    assert [line for line, _ in _private_uses(ast.parse("self._a\nother._a = self.b._c\n"))] == [2, 2]


def _module_state(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield names of module level that are bound to something mutable and changed by a function of the module."""
    mutable = {
        target.id
        for node in tree.body
        if isinstance(node, ast.Assign | ast.AnnAssign) and isinstance(node.value, (*MUTABLE, ast.Call))
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        if isinstance(target, ast.Name)
    }
    for function in (n for n in ast.walk(tree) if isinstance(n, Function)):
        for node in ast.walk(function):
            if isinstance(node, ast.Global):
                yield node.lineno, f"global {', '.join(node.names)}"
            if isinstance(node, ast.Assign | ast.AugAssign | ast.Delete):
                targets = [node.target] if isinstance(node, ast.AugAssign) else node.targets
                for target in targets:
                    owner = target.value if isinstance(target, ast.Subscript | ast.Attribute) else None
                    if isinstance(owner, ast.Name) and owner.id in mutable:
                        yield node.lineno, owner.id
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and isinstance(node.func.value, ast.Name):
                changes = node.func.attr in CHANGES
                if changes and node.func.value.id in mutable:
                    yield node.lineno, f"{node.func.value.id}.{node.func.attr}"


def test_no_module_keeps_state() -> None:
    """Nothing at module level is changed by functions; caches of what files say are `lru_cache`."""
    found = [f"{_name(file)}:{line} {what}" for file in _files("rlbench_pin") for line, what in _module_state(_tree(file))]
    assert found == []


@pytest.mark.parametrize(
    "text", ["X = {}\ndef f():\n    X[1] = 2\n", "X = []\ndef f():\n    X.append(1)\n", "def f():\n    global X\n"]
)
def test_the_rule_finds_state(text: str) -> None:
    """What the test above looks for."""
    assert list(_module_state(ast.parse(text)))
