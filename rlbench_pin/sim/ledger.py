"""What was done to a physics server while its world was built, so that it can be done again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import ModuleType, SimpleNamespace
from typing import Any

from rlbench_pin.errors import RlbenchPinError

_CHANGES = (
    "changeConstraint",
    "changeDynamics",
    "changeVisualShape",
    "createConstraint",
    "loadURDF",
    "removeBody",
    "removeConstraint",
    "resetBasePositionAndOrientation",
    "resetBaseVelocity",
    "resetJointState",
    "setCollisionFilterGroupMask",
    "setCollisionFilterPair",
    "setGravity",
    "setJointMotorControlArray",
    "setPhysicsEngineParameter",
    "setTimeStep",
)
"""Functions of pybullet with which worlds are built."""


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
    """Return the functions of pybullet, where those that change a world write into its ledger while that is open."""
    functions = dict(vars(module))
    functions.update({name: _noting(functions[name]) for name in _CHANGES})
    return SimpleNamespace(**functions)


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
