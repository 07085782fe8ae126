"""Front doors: the public names of a package, those that are looked up when first used, and the answer to a wrong name.

A package puts one line below its `__all__`, where type checkers do not see it, because they would take every name for right:

    if not TYPE_CHECKING:
        __getattr__, __dir__ = front_door(__name__)
"""

from __future__ import annotations

import ast
import importlib
import inspect
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import lru_cache
from opcode import opmap
from pathlib import Path
from types import FrameType

ROOT = Path(__file__).parent
NOT_LISTED = ("cli", "compat")
"""Folders whose names no program asks for."""

Lookup = tuple[Callable[[str], object], Callable[[], list[str]]]


def front_door(package: str, homes: Mapping[str, str] | None = None, parts: Collection[str] = ()) -> Lookup:
    """Return `__getattr__` and `__dir__` of a package.

    Args:
        package: Its name, `__name__`.
        homes: Name -> module of the package that has it, for names that are looked up when first used; with all its dots
            where another package has it.
        parts: Packages and modules below it that are imported when first used.

    Returns:
        Two functions for the package. The first raises AttributeError for a name that is not there, or ImportError where a
        `from ... import` asks for it; the text has the nearest names, and the package where the name is.
    """
    known = dict(homes or {})

    def look_up(name: str) -> object:
        if name in parts:
            return importlib.import_module(f"{package}.{name}")
        if name not in known:
            raise unknown_name(package, name, _caller())
        home = known[name] if known[name].startswith(f"{ROOT.name}.") else f"{package}.{known[name]}"
        value: object = getattr(importlib.import_module(home), name)
        vars(sys.modules[package])[name] = value
        return value

    def names() -> list[str]:
        there = vars(sys.modules[package])
        below = (name for name, value in there.items() if getattr(value, "__name__", "") == f"{package}.{name}")
        special = (name for name in there if name.startswith("__"))
        return sorted({*there.get("__all__", ()), *parts, *below, *special})

    return look_up, names


def unknown_name(package: str, name: str, caller: FrameType | None = None) -> AttributeError | ImportError:
    """Return the error for a name that a package does not have.

    Args:
        package: Where it was looked for.
        name: The name.
        caller: Who asks. `from ... import` has an error of its own for an AttributeError, without its text.
    """
    if name.startswith("_") or _is_only_trying(caller):
        return AttributeError(f"module '{package}' has no attribute '{name}'", name=name)
    if _is_from_import(caller):
        return ImportError(f"cannot import name '{name}' from '{package}'.{_hint(package, name)}", name=package)
    return AttributeError(f"module '{package}' has no attribute '{name}'.{_hint(package, name)}", name=name)


def _caller() -> FrameType | None:
    """Return who asked a package for a name: the first on the way up that is neither this module nor a `__getattr__`."""
    frame = inspect.currentframe()
    while frame is not None and (frame.f_globals is globals() or frame.f_code.co_name == "__getattr__"):
        frame = frame.f_back
    return frame


def _is_only_trying(caller: FrameType | None) -> bool:
    """Whether Python asks before it imports a module of that name."""
    return caller is not None and caller.f_globals.get("__name__") == "importlib._bootstrap"


def _is_from_import(caller: FrameType | None) -> bool:
    return caller is not None and caller.f_code.co_code[caller.f_lasti] == opmap["IMPORT_FROM"]


def _hint(package: str, name: str) -> str:
    """Return where the name is, or names like it: of this package first, then of the others."""
    listed = dir(sys.modules[package])
    others = {known: door for door, known in public_names() if known not in listed}
    if name in others:
        return f" It is in {others[name]}: `from {others[name]} import {name}`."
    own = {known: package for known in listed if not known.startswith("_")}
    near = _near(name, own) or _near(name, others)
    if not near:
        return f" `dir({package})` lists the names."
    doors = {**others, **own}
    return f" Did you mean {' or '.join(f'{known!r}{_of(doors[known], package)}' for known in near)}?"


def _of(door: str, package: str) -> str:
    return "" if door == package else f" of {door}"


def _near(name: str, known: Iterable[str]) -> list[str]:
    """Return up to three names like `name`, the most like it first; capitals do not count."""
    folded: dict[str, list[str]] = {}
    for word in known:
        folded.setdefault(word.lower(), []).append(word)
    close: list[str] = importlib.import_module("difflib").get_close_matches(name.lower(), folded, n=3, cutoff=0.75)
    return [word for key in close for word in folded[key]][:3]


@lru_cache(maxsize=1)
def public_names() -> tuple[tuple[str, str], ...]:
    """Return (package, name) of everything public, as the files of the packages say; outer packages come last."""
    files = [f for f in (*ROOT.rglob("__init__.py"), *ROOT.glob("*.py")) if f.relative_to(ROOT).parts[0] not in NOT_LISTED]
    doors = {".".join((ROOT.name, *_module(file))): _listed(file) for file in files}
    doors[f"{ROOT.name}.tasks"] += [class_name(file.stem) for file in (ROOT / "tasks" / "library").glob("*.toml")]
    order = sorted(doors, key=lambda door: (-door.count("."), door))
    return tuple((door, name) for door in order for name in doors[door])


def _module(file: Path) -> tuple[str, ...]:
    return tuple(part for part in file.relative_to(ROOT).with_suffix("").parts if part != "__init__")


def _listed(file: Path) -> list[str]:
    """Return the names in the `__all__` of a file, or in the stub of a package that `lazy_loader` loads, without running it."""
    if (stub := file.with_suffix(".pyi")).is_file():
        tree = ast.parse(stub.read_text(encoding="utf-8"))
        return [alias.name for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names]
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return [str(name) for name in ast.literal_eval(node.value)]
    return []


def class_name(stem: str) -> str:
    """Return what the class in a file is called: `ReachTarget` for `reach_target`."""
    return "".join(word.capitalize() for word in stem.split("_"))
