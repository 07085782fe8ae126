"""TOPPRA without Matplotlib, which it imports for its plots only: each process starts about 0.4 s earlier."""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

PYPLOT = "matplotlib.pyplot"


class _LazyPyplot(ModuleType):
    """Replaces pyplot in TOPPRA, and imports it when TOPPRA plots."""

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module(PYPLOT), name)


_substitutes = {"matplotlib": ModuleType("matplotlib"), PYPLOT: _LazyPyplot(PYPLOT)}
_replaced = _substitutes.keys() - sys.modules.keys()
sys.modules.update({name: _substitutes[name] for name in _replaced})
import toppra  # noqa: E402
import toppra.constraint  # noqa: E402
from toppra.solverwrapper import seidelWrapper  # noqa: E402

for name in _replaced:
    del sys.modules[name]

__all__ = ["seidelWrapper", "toppra"]
