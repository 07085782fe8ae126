"""What the files of a policy add up to, so that an evaluation does not go on with another policy of the same name."""

from __future__ import annotations

import hashlib
from pathlib import Path
from urllib.parse import unquote

_BLOCK = 1 << 20
"""Bytes that are read at once."""


def policy_digests(reference: str) -> dict[str, str]:
    """Return name -> SHA-256 of the files that a reference names: `file.py`, the file of `sb3:`, a folder's own files.

    A folder is that of `lerobot:FOLDER` or of an argument, as in `cloning?folder=models`. Modules that a file imports,
    libraries, and what is served behind a socket are not looked at; the built-in policies go with the commit.

    Args:
        reference: What `find_policy` takes.
    """
    if reference.startswith(("unix:", "tcp:")):
        return {}
    name, _, query = reference.partition("?")
    values = [unquote(pair.partition("=")[2]) for pair in query.split("&") if pair]
    kind, _, rest = name.partition(":")
    named = [rest, f"{rest}.zip"][: 2 if kind == "sb3" else 1] if kind in ("sb3", "lerobot") else []
    named += [name.rpartition(":")[0]] if name.rpartition(":")[0].endswith(".py") else []
    found: dict[str, str] = {}
    for text in (*named, *values):
        for file in _files(text):
            found[str(file)] = _digest(file)
    return found


def _files(text: str) -> list[Path]:
    """Return the file that a text names, or those of the folder, sorted; none where there is neither."""
    path = Path(text)
    try:
        if text and path.is_file():
            return [path]
        return sorted(file for file in path.rglob("*") if file.is_file()) if text and path.is_dir() else []
    except (OSError, ValueError):  # a text that no path can be
        return []


def _digest(file: Path) -> str:
    found = hashlib.sha256()
    with file.open("rb") as opened:
        while block := opened.read(_BLOCK):
            found.update(block)
    return found.hexdigest()
