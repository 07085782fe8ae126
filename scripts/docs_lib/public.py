"""The public names of every package, read from its source."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "rlbench_pin"
OPTIONAL_LIBRARIES = ("torch", "stable_baselines3", "safetensors", "ray", "vla_eval", "lerobot", "tensorboard")
"""Libraries of extras that the site is built without."""
TYPE_ALIASES = {
    "FloatArray": "rlbench_pin.spatial.FloatArray",
    "PoseLike": "rlbench_pin.spatial.PoseLike",
    "OwnTasks": "rlbench_pin.tasks.OwnTasks",
    "Wording": "rlbench_pin.tasks.Wording",
    "FactorsLike": "rlbench_pin.environment.factors.FactorsLike",
}
"""Names of types that signatures show as they are written."""


@dataclass(frozen=True)
class Assigned:
    """A constant or an alias of a type, as its module assigns it."""

    annotation: str
    value: str
    doc: str
    """The string below it."""


def public_names() -> dict[str, list[str]]:
    """Return package or module -> its public names, for everything that programs import."""
    files = [
        f
        for f in (*PACKAGE.rglob("__init__.py"), *PACKAGE.glob("*.py"))
        if f.relative_to(PACKAGE).parts[0] not in ("cli", "compat")
    ]
    found = {}
    for file in files:
        parts = [part for part in file.relative_to(ROOT).with_suffix("").parts if part != "__init__"]
        if names := _listed(file):
            found[".".join(parts)] = names
    return found


def _listed(file: Path) -> list[str]:
    """Return the public names of a package or module: those in its stub, or in its `__all__`."""
    if file.with_suffix(".pyi").exists():
        return list(_imports(file))
    for node in _tree(file).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return [str(name) for name in ast.literal_eval(node.value)]
    return []


def assigned(module: str, name: str) -> Assigned:
    """Return how a name is assigned, in the module itself or in the one that it is imported from."""
    file = _file(module)
    body = _tree(file).body
    for node, after in zip(body, [*body[1:], None]):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        if [ast.unparse(target) for target in targets] == [name]:
            annotation = ast.unparse(node.annotation) if isinstance(node, ast.AnnAssign) else ""
            is_doc = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
            doc = " ".join(str(after.value.value).split()) if is_doc else ""  # type: ignore[union-attr]
            return Assigned(annotation, ast.unparse(node.value) if node.value else "", doc)  # type: ignore[union-attr]
    return assigned(*_imports(file)[name])


def _imports(file: Path) -> dict[str, tuple[str, str]]:
    """Return public name -> module and name that it comes from, of a package."""
    stub = file.with_suffix(".pyi")
    package = ".".join(file.parent.relative_to(ROOT).parts)
    return dict(_imported(_tree(stub if stub.exists() else file), package))


def _imported(tree: ast.Module, package: str) -> Iterator[tuple[str, tuple[str, str]]]:
    for node in tree.body:
        if isinstance(node, ast.ImportFrom):
            parent = ".".join(package.split(".")[: len(package.split(".")) + 1 - node.level]) if node.level else ""
            module = ".".join(part for part in (parent, node.module) if part)
            for alias in node.names:
                yield alias.asname or alias.name, (module, alias.name)


def _file(module: str) -> Path:
    path = ROOT.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


@cache
def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))
