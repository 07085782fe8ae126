"""What was done to a physics server while its world was built, so that it can be done again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import BuiltinFunctionType, ModuleType, SimpleNamespace
from typing import Any

from rlbench_pin.errors import RlbenchPinError

_NOT_NOTED = (
    "connect",
    "disconnect",
    "get",
    "loadPlugin",
    "performCollisionDetection",
    "removeState",
    "resetSimulation",
    "restoreState",
    "save",
    "stepSimulation",
)
"""Beginnings of functions of pybullet that are no part of building a world."""


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
            RlbenchPinError: It failed, or gave something else this time.
        """
        name = self.function.__name__
        try:
            result = self.function(*self.positional, **self.named)
        except Exception as error:
            problem = f"{name}{self.positional} failed: {error}"
        else:
            if result == self.result:
                return
            problem = f"{name}{self.positional} gave {result} instead of {self.result}"
        raise RlbenchPinError(
            f"The world could not be built again: {problem}. Restore the files it was built from, and load the task again."
        )


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
