"""Docstrings of the public interface, no patching and no module state."""

from __future__ import annotations

import ast
import importlib
import inspect
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import FunctionType

import pytest

from rlbench_pin.errors import MissingExtra

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "rlbench_pin"

Function = ast.FunctionDef | ast.AsyncFunctionDef


def _files(*folders: str) -> list[Path]:
    return [file for folder in folders for file in sorted((ROOT / folder).rglob("*.py"))]


def _name(file: Path) -> str:
    return file.relative_to(ROOT).as_posix()


@cache
def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


# Docstrings -------------------------------------------------------------------------------------------------------------------


def _exported() -> Iterator[object]:
    """Yield every name in `__all__` of the packages that users import."""
    for file in sorted(PACKAGE.rglob("__init__.py")):
        parts = file.parent.relative_to(PACKAGE).parts
        if parts[:1] in (("compat",), ("cli",)):
            continue
        try:
            module = importlib.import_module(".".join((PACKAGE.name, *parts)))
        except MissingExtra:
            continue
        for name in getattr(module, "__all__", ()):
            yield getattr(module, name)


def test_the_public_interface_has_docstrings() -> None:
    """Every exported class and function, and their public methods and properties."""
    lacking = set()
    for value in _exported():
        if not getattr(value, "__module__", "").startswith(PACKAGE.name) or not (
            inspect.isclass(value) or inspect.isfunction(value)
        ):
            continue
        lacking |= set() if value.__doc__ else {value.__qualname__}
        for name, member in vars(value).items() if inspect.isclass(value) else ():
            is_public = not name.startswith("_") and isinstance(member, (FunctionType, property, classmethod, staticmethod))
            if is_public and not inspect.getdoc(getattr(value, name)):
                lacking.add(f"{value.__qualname__}.{name}")
    assert lacking == set()


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
