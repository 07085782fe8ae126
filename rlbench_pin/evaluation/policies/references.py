"""References of policies: `noop`, `module:factory`, `sb3:FILE`, ... No code of a policy runs before `make_policy` is called."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import inspect
import json
import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from typing import Any, Literal
from urllib.parse import parse_qsl, quote

from rlbench_pin.errors import MissingExtra, UnknownName, nearest_name
from rlbench_pin.evaluation.policies.policy import LibraryMissing, PolicyReferenceError
from rlbench_pin.evaluation.policies.policy_server import NoPolicy, split_tcp
from rlbench_pin.evaluation.policies.wires import SCHEMES, parse_address

_POLICIES = "rlbench_pin.evaluation.policies"
_BASELINES = "rlbench_pin.baselines"
BUILT_IN: Mapping[str, str] = {
    "noop": f"{_POLICIES}.adapters:Noop",
    "random": f"{_POLICIES}.adapters:Random",
    "classical": f"{_BASELINES}.classical:policy",
    "cloning": f"{_BASELINES}.cloning:policy",
    "key_frames": f"{_BASELINES}.key_frames:policy",
}
"""Name -> `module:factory` of the policies of this package."""
IN_PROCESS = ("noop", "random")
"""Built-in policies that run in the process of the worker."""
EXPERT = "expert"
"""The policy that plays demonstrations of the planner; the evaluation plays it without a policy object."""
FORMS = (
    "`module:factory`, `file.py:factory`, `sb3:FILE`, `ppo:FOLDER`, `sac:FOLDER`, `lerobot:FOLDER`, `unix:PATH`,"
    " `tcp://HOST:PORT`, `openpi://HOST:PORT?mapping=NAME` or `vla-eval://HOST:PORT?mapping=NAME`"
)


@dataclass(frozen=True)
class Reference:
    """A reference and the place where its policy runs."""

    text: str
    """The reference as it was written."""
    place: Literal["in-process", "subprocess", "socket", "websocket"]
    """Transport of the policy."""
    target: str
    """`module:factory` or `file.py:factory` with arguments, or an address."""


def find_policy(reference: str) -> Reference:
    """Check that the target of a reference exists, and return it. The module of the policy is not imported.

    Args:
        reference: A name of `BUILT_IN`, `module:factory`, `file.py:factory`, `sb3:FILE`, `ppo:FOLDER`, `sac:FOLDER`,
            `lerobot:FOLDER`, `unix:PATH` or `tcp://HOST:PORT`. Except for the last two, arguments of the factory may follow, as
            `?key=value&...`. Or `openpi://HOST:PORT?mapping=NAME`, `vla-eval://HOST:PORT?mapping=NAME`.

    Raises:
        UnknownName: The reference is a single word, and no policy of this package has this name.
        PolicyReferenceError: There is no such module, file or factory, or the reference has none of these forms.
        MissingExtra: The library of the policy is not installed.
    """
    if not isinstance(reference, str) or not reference or "\0" in reference:
        raise PolicyReferenceError(reference, f"has to be a text such as {FORMS}")
    if reference.startswith(("unix:", "tcp:")):
        return _at_address(reference)
    if reference.startswith(tuple(f"{scheme}:" for scheme in SCHEMES)):
        parse_address(reference)
        return Reference(reference, "websocket", reference)
    for kind, find in (("sb3:", _sb3), ("lerobot:", _lerobot), ("ppo:", _trained), ("sac:", _trained)):
        if reference.startswith(kind):
            return Reference(reference, "subprocess", find(reference, reference.removeprefix(kind)))
    name, _, query = reference.partition("?")
    if name == EXPERT:
        hint = "Use `rlbench-pin evaluate expert` or `evaluate(...)`."
        raise PolicyReferenceError(reference, "needs the planner and the scene, so it is not available as an object", hint)
    if name in BUILT_IN:
        target = f"{BUILT_IN[name]}?{query}" if query else BUILT_IN[name]
        return Reference(reference, "in-process" if name in IN_PROCESS else "subprocess", target)
    if ":" not in name:
        if name.endswith(".py"):
            known = _defined(reference, Path(name)) if _is_file(Path(name)) else ()
            hint = f"Write `{name}:NAME`, where NAME is a class or function of that file{_listed(known)}."
            raise PolicyReferenceError(reference, "names a file, and no policy in it", hint)
        raise UnknownName("policy", reference, (*BUILT_IN, EXPERT))
    _check_factory(reference)
    return Reference(reference, "subprocess", reference)


def _at_address(reference: str) -> Reference:
    if reference == "unix:":
        raise PolicyReferenceError(reference, "needs the path of a socket", "Write `unix:PATH`.")
    if reference.startswith("tcp:"):
        try:
            split_tcp(reference)
        except ValueError as error:
            raise PolicyReferenceError(reference, f"has no valid address: {error}") from error
    return Reference(reference, "socket", reference)


def _with_path(factory: str, key: str, path: Path, query: str) -> str:
    return f"{_POLICIES}.{factory}?{key}={quote(str(path.resolve()))}{f'&{query}' if query else ''}"


def _sb3(reference: str, rest: str) -> str:
    file, _, query = rest.partition("?")
    path = next((p for p in (Path(file), Path(f"{file}.zip")) if _is_file(p)), None)
    if path is None:
        raise PolicyReferenceError(
            reference, f"needs the file '{file}', which does not exist", "Write one with `model.save(FILE)`."
        )
    if importlib.util.find_spec("stable_baselines3") is None:
        raise MissingExtra("A policy `sb3:FILE`", "stable_baselines3", "rl")
    return _with_path("sb3:load", "file", path, query)


def _trained(reference: str, rest: str) -> str:
    folder, _, query = rest.partition("?")
    algorithm = reference.partition(":")[0]
    if not any(_is_file(path) for path in Path(folder).glob("*/settings.json")):
        hint = f"Train models with `rlbench-pin train {algorithm} TASK --out {folder}`."
        raise PolicyReferenceError(reference, f"needs models in '{folder}', which has none", hint)
    if importlib.util.find_spec("stable_baselines3") is None:
        raise MissingExtra(f"A policy `{algorithm}:FOLDER`", "stable_baselines3", "rl")
    arguments = f"folder={quote(str(Path(folder).resolve()))}&algorithm={algorithm}"
    return f"{_BASELINES}.reinforcement:policy?{arguments}{f'&{query}' if query else ''}"


def _lerobot(reference: str, rest: str) -> str:
    folder, _, query = rest.partition("?")
    path = Path(folder)
    if not _is_file(path / "config.json"):
        hint = "Use the folder `pretrained_model` of a checkpoint, which contains `config.json` and `model.safetensors`."
        raise PolicyReferenceError(reference, f"needs a `config.json` in '{folder}', which has none", hint)
    if importlib.util.find_spec("lerobot") is None:
        hint = "Serve the policy from a Python environment with it, and evaluate `unix:PATH`; docs/policies.md shows how."
        raise LibraryMissing("A policy `lerobot:FOLDER`", "lerobot", hint)
    return _with_path("lerobot_directory:LeRobotPolicy", "folder", path, query)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name that no file can have
        return False


def _check_factory(reference: str) -> None:
    """Raise PolicyReferenceError unless there is such a module or file, and the factory is not missing in its text."""
    try:
        where, name, _ = split_reference(reference)
    except NoPolicy as error:
        raise PolicyReferenceError(reference, f"has an unknown form: {error}", f"Use {FORMS}.") from error
    file: Path | None
    if where.endswith(".py"):
        file = Path(where)
        if not _is_file(file):
            raise PolicyReferenceError(reference, f"needs the file '{where}', which does not exist", "Check the path.")
    else:
        spec = _spec_of(where)
        if spec is None:
            hint = "Install it, put it into this folder or on PYTHONPATH, or use `file.py:factory`."
            raise PolicyReferenceError(reference, f"needs the module '{where}', which does not exist", hint)
        file = Path(spec.origin) if spec.has_location and spec.origin and spec.origin.endswith(".py") else None
    if file is not None:
        _check_name(reference, file, name)


def _spec_of(dotted: str) -> ModuleSpec | None:
    """Return the spec of a module without importing its packages; None if there is no such module."""
    top, *rest = dotted.split(".")
    if not all(part.isidentifier() for part in (top, *rest)):
        return None
    try:
        spec = PathFinder.find_spec(top, [os.getcwd(), *sys.path]) or importlib.util.find_spec(top)
        name = top
        for part in rest:
            if spec is None or spec.submodule_search_locations is None:
                return None
            name = f"{name}.{part}"
            spec = PathFinder.find_spec(name, list(spec.submodule_search_locations))
    except (ImportError, ValueError, OSError):
        return None
    return spec


def _parsed(reference: str, file: Path) -> ast.Module:
    try:
        return ast.parse(file.read_bytes())
    except (SyntaxError, ValueError, OSError) as error:
        raise PolicyReferenceError(reference, f"needs '{file}', which cannot be read: {error}", "Correct it.") from error


def _defined(reference: str, file: Path) -> tuple[str, ...]:
    """Return the public classes and functions of a file."""
    nodes = _parsed(reference, file).body
    return tuple(n.name for n in nodes if isinstance(n, ast.FunctionDef | ast.ClassDef) and not n.name.startswith("_"))


def _listed(names: tuple[str, ...]) -> str:
    return f": {', '.join(names[:8])}{', ...' if len(names) > 8 else ''}" if names else ""


def _check_name(reference: str, file: Path, name: str) -> None:
    tree = _parsed(reference, file)
    names = {n.name for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.ClassDef | ast.AsyncFunctionDef)}
    names |= {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    imported = [alias for n in ast.walk(tree) if isinstance(n, ast.Import | ast.ImportFrom) for alias in n.names]
    names |= {alias.asname or alias.name.split(".")[0] for alias in imported}
    if name not in names and not names & {"*", "__getattr__"}:
        near = nearest_name(name, names)
        found = _listed(_defined(reference, file)) or ": none"
        hint = f"Did you mean '{near}'?" if near else f"Its public classes and functions{found}."
        raise PolicyReferenceError(reference, f"needs '{name}', which is not in '{file}'", hint)


def split_reference(reference: str) -> tuple[str, str, dict[str, Any]]:
    """Return module or file, factory, and keyword arguments of `module:factory?key=value&...`; values are JSON, or text.

    Raises:
        NoPolicy: The reference does not have this form.
    """
    path, _, query = reference.partition("?")
    where, _, name = path.rpartition(":")
    if not where or not name.isidentifier():
        raise NoPolicy(f"'{reference}' is not of the form `module:factory`, or `file.py:factory`.")
    pairs = parse_qsl(query, keep_blank_values=True)
    if query and (len(dict(pairs)) != query.count("&") + 1 or not all("=" in part for part in query.split("&"))):
        raise NoPolicy(f"The arguments '{query}' are not of the form `key=value&...`, each key once.")
    return where, name, {key: _value(text) for key, text in pairs}


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text


POLICY = ("reset", "act", "action_mode", "obs_config")
"""Attributes that every policy has."""


def make_policy(reference: str) -> Any:
    """Import the factory of a reference, call it, and return the policy.

    Raises:
        NoPolicy: There is no such module or factory, or the factory does not return a policy.
    """
    return make_named(reference, "policy", POLICY)


def make_named(reference: str, kind: str, parts: tuple[str, ...]) -> Any:
    """Import the target of a reference, call it unless it is an instance already, and return the object.

    Args:
        reference: `module:factory?key=value&...` or `file.py:factory?...`.
        kind: Kind of the object for errors, such as `policy`.
        parts: Attributes that the object must have; two methods first.

    Raises:
        NoPolicy: There is no such module or factory, or the object lacks an attribute.
    """
    where, name, arguments = split_reference(reference)
    module = _import_file(Path(where)) if where.endswith(".py") else importlib.import_module(where)
    if name not in vars(module) and not hasattr(module, name):
        raise NoPolicy(f"'{where}' has no '{name}'. Check the spelling.")
    made = getattr(module, name)
    is_instance = any(callable(getattr(made, part, None)) for part in parts[:2])
    if callable(made) and not is_instance or isinstance(made, type):
        try:
            inspect.signature(made).bind(**arguments)
        except TypeError as error:
            raise NoPolicy(f"'{where}:{name}' does not accept these arguments: {error}.") from error
        made = made(**arguments)
    lacking = [part for part in parts if not hasattr(made, part)]
    if lacking:
        raise NoPolicy(f"'{where}:{name}' returns a {type(made).__name__}, which is not a {kind}: it has no {lacking[0]}.")
    return made


def _import_file(path: Path) -> Any:
    if not path.is_file():
        raise NoPolicy(f"There is no file '{path}'.")
    folder = str(path.resolve().parent)
    if folder not in sys.path:
        sys.path.insert(0, folder)  # as for a program in that folder
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules.setdefault(path.stem, module)
    spec.loader.exec_module(module)
    return module
