"""Changes of files: of bytes, of text, and of what TOML and JSON files say."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from typing import Any

import numpy as np

NUMBERS = (0, -1, 1, 2, 90, 180, 1e20, -1e20, 1e308, 5e-324, 2**31, 2**63, 2**64, 10**30, 0.1, float("nan"), float("inf"))
WORDS = (
    "",
    " ",
    "x",
    "ünï☃",
    "../../../etc/passwd",
    "/dev/zero",
    "a" * 5000,
    "root",
    "world",
    "waypoint1",
    "nan",
    "-1",
    "\u202e",
)
KEYS = ("name", "parent", "pose", "size", "fixed", "format", "rpy", "asset", "__class__", "qx", "poses", "", "é", "a.b")
Tree = dict[str, Any]


def value(rng: np.random.Generator, depth: int = 2) -> Any:
    """Draw a value that TOML and JSON can say."""
    kind = rng.integers(8 if depth else 5)
    if kind < 2:
        return NUMBERS[int(rng.integers(len(NUMBERS)))]
    if kind < 4:
        return WORDS[int(rng.integers(len(WORDS)))]
    if kind == 4:
        return bool(rng.integers(2))
    if kind == 5:
        return {KEYS[int(rng.integers(len(KEYS)))]: value(rng, depth - 1) for _ in range(3)}
    if kind == 6:
        return [value(rng, depth - 1) for _ in range(int(rng.integers(9)))]
    return [float(x) for x in rng.normal(size=int(rng.choice([1, 2, 3, 4, 6, 7, 8])))]


def places(tree: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the paths of all values in a tree, except the tree itself."""
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    return [found for key, below in items for found in ((*path, key), *places(below, (*path, key)))]


def _holder(tree: Any, path: tuple[Any, ...]) -> Any:
    for key in path[:-1]:
        tree = tree[key]
    return tree


def changed(tree: Tree, rng: np.random.Generator) -> Tree:
    """Return a tree with one to three changes: values, keys, entries dropped, doubled or exchanged."""
    tree = copy.deepcopy(tree)
    for _ in range(int(rng.integers(1, 4))):
        paths = places(tree)
        if not paths:
            return tree
        path = paths[int(rng.integers(len(paths)))]
        holder, key = _holder(tree, path), path[-1]
        kind = int(rng.integers(7))
        if kind == 0:
            del holder[key]
        elif kind == 1 and isinstance(holder, list):
            holder.append(copy.deepcopy(holder[key]))
        elif kind == 2 and isinstance(holder, dict):
            holder[KEYS[int(rng.integers(len(KEYS)))]] = holder.pop(key)
        elif kind == 3:
            other = paths[int(rng.integers(len(paths)))]
            holder[key] = copy.deepcopy(_holder(tree, other)[other[-1]])
        elif kind == 4 and isinstance(holder[key], int | float):
            holder[key] = holder[key] * float(rng.choice([-1.0, 57.3, 1000.0, 1e-9, 1e9]))
        else:
            holder[key] = value(rng)
    return tree


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Return bytes with a flipped bit, a part cut off, zeroed, exchanged or inserted."""
    size = len(data)
    if size < 8:
        return b"\0" * 8
    start = int(rng.integers(size))
    length = int(min(size - start, rng.choice([1, 4, 64, 512, 4096])))
    kind = int(rng.integers(6))
    if kind == 0:
        return data[:start] + bytes([data[start] ^ (1 << int(rng.integers(8)))]) + data[start + 1 :]
    if kind == 1:
        return data[:start]
    if kind == 2:
        return data[:start] + bytes(length) + data[start + length :]
    if kind == 3:
        return data[:start] + data[start + length :]
    if kind == 4:
        return data[:start] + rng.bytes(length) + data[start:]
    return data[size // 2 :] + data[: size // 2]


def toml_text(tree: Tree) -> str:
    """Write a tree as TOML, in a plain way that takes any value."""
    tables = {k: v for k, v in tree.items() if isinstance(v, dict)}
    arrays = {k: v for k, v in tree.items() if isinstance(v, list) and v and all(isinstance(e, dict) for e in v)}
    lines = [f"{_key(k)} = {_inline(v)}" for k, v in tree.items() if k not in tables and k not in arrays]
    for name, table in tables.items():
        lines += ["", f"[{_key(name)}]", *(f"{_key(k)} = {_inline(v)}" for k, v in table.items())]
    for name, entries in arrays.items():
        for entry in entries:
            lines += ["", f"[[{_key(name)}]]", *(f"{_key(k)} = {_inline(v)}" for k, v in entry.items())]
    return "\n".join(lines) + "\n"


def _key(key: object) -> str:
    return json.dumps(str(key), ensure_ascii=True)


def _inline(item: Any) -> str:
    if isinstance(item, dict):
        return "{" + ", ".join(f"{_key(k)} = {_inline(v)}" for k, v in item.items()) + "}"
    if isinstance(item, list):
        return "[" + ", ".join(_inline(v) for v in item) + "]"
    if isinstance(item, float):
        return {"nan": "nan", "inf": "inf", "-inf": "-inf"}.get(repr(item), repr(item))
    return json.dumps(item)


TEXTS: tuple[Callable[[str], str], ...] = (
    lambda text: "",
    lambda text: text[: len(text) // 2],
    lambda text: text * 2,
    lambda text: text.replace("=", ":", 1),
    lambda text: text.replace('"', "", 1),
    lambda text: "a = " + "[" * 3000 + "]" * 3000,
    lambda text: "a" + ".a" * 2000 + " = 1",
    lambda text: text + "[[body]]\nname = 'x'\n" * 3000,
    lambda text: text + f"big = {'9' * 5000}\n",
    lambda text: text.replace("[[", "[").replace("]]", "]"),
    lambda text: text.replace("parent", "Parent"),
    lambda text: "\ufeff" + text,
    lambda text: text + "\0",
    lambda text: text + 'weird = "\ud800"\n'.encode("utf-8", "replace").decode(),
)
"""Changes of a whole text."""
