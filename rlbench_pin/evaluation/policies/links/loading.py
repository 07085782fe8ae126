"""Policies from their references, `module:factory` and `file.py:factory`; runs in the process that hosts the policy."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import json
import sys
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl

from rlbench_pin.evaluation.policies.policy_server import NoPolicy


def split_reference(reference: str) -> tuple[str, str, dict[str, Any]]:
    """Return module or file, factory, and keyword arguments of `module:factory?key=value&...`; values are JSON, or text.

    Raises:
        NoPolicy: It has not this form.
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
"""What a policy has."""


def make_policy(reference: str) -> Any:
    """Import what a reference names, call it, and return the policy.

    Raises:
        NoPolicy: There is no such module or factory, or what it returns is no policy.
    """
    return make_named(reference, "policy", POLICY)


def make_named(reference: str, kind: str, parts: tuple[str, ...]) -> Any:
    """Import what a reference names, call it unless it is the thing itself, and return that.

    Args:
        reference: `module:factory?key=value&...` or `file.py:factory?...`.
        kind: What it is to be, one word.
        parts: What such a thing has; two methods first.

    Raises:
        NoPolicy: There is no such module or factory, or what it returns lacks a part.
    """
    where, name, arguments = split_reference(reference)
    module = _import_file(Path(where)) if where.endswith(".py") else importlib.import_module(where)
    if name not in vars(module) and not hasattr(module, name):
        raise NoPolicy(f"'{where}' has no '{name}'.")
    made = getattr(module, name)
    is_thing = any(callable(getattr(made, part, None)) for part in parts[:2])
    if callable(made) and not is_thing or isinstance(made, type):
        try:
            inspect.signature(made).bind(**arguments)
        except TypeError as error:
            raise NoPolicy(f"'{where}:{name}' cannot be called so: {error}.") from error
        made = made(**arguments)
    lacking = [part for part in parts if not hasattr(made, part)]
    if lacking:
        raise NoPolicy(f"'{where}:{name}' gives a {type(made).__name__}, which is no {kind}: it has no {lacking[0]}.")
    return made


def _import_file(path: Path) -> Any:
    if not path.is_file():
        raise NoPolicy(f"There is no file '{path}'.")
    folder = str(path.resolve().parent)
    if folder not in sys.path:
        sys.path.insert(0, folder)  # as for a program that lies there
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules.setdefault(path.stem, module)
    spec.loader.exec_module(module)
    return module
