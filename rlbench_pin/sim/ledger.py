"""What was done to a physics server while its world was built, so that it can be done again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import BuiltinFunctionType, ModuleType, SimpleNamespace
from typing import Any

from rlbench_pin.errors import RlbenchPinError

_NOT_NOTED = ("get", "save", "connect", "disconnect", "loadPlugin", "removeState", "resetSimulation")
"""Beginnings of functions of pybullet that change nothing that building again must bring back."""


@dataclass(frozen=True)
class Change:
    """One call that changed a physics server, and what it gave."""

    function: Callable[..., Any]
    positional: tuple[Any, ...]
    named: Mapping[str, Any]
    result: Any

    def repeat(self) -> None:
        """Do it again.

        Raises:
            RlbenchPinError: It gave something else this time.
        """
        result = self.function(*self.positional, **self.named)
        if result != self.result:
            name = self.function.__name__
            raise RlbenchPinError(f"Building the world anew, {name} gave {result} instead of {self.result}. Reload the task.")


_open: dict[int, list[Change]] = {}
"""Ledgers that are being written, by number of the physics server."""


def noting(module: ModuleType) -> SimpleNamespace:
    """Return what pybullet offers, where functions that change a world write into its ledger while that is open."""
    contents = vars(module)
    noted = (n for n, f in contents.items() if isinstance(f, BuiltinFunctionType) and not n.startswith(_NOT_NOTED))
    return SimpleNamespace(**{**contents, **{name: _noting(contents[name]) for name in noted}})


def _noting(function: Callable[..., Any]) -> Callable[..., Any]:
    def call(*positional: Any, **named: Any) -> Any:
        result = function(*positional, **named)
        ledger = _open.get(named.get("physicsClientId", 0))
        if ledger is not None:
            ledger.append(Change(function, positional, named, result))
        return result

    return call


def open_ledger(identifier: int) -> None:
    """Begin to write down what is done to a physics server."""
    _open[identifier] = []


def close_ledger(identifier: int) -> tuple[Change, ...]:
    """Stop writing and return what was written; nothing when no ledger is open."""
    return tuple(_open.pop(identifier, ()))
