"""What all modes share: a specification that is made once per runtime, and actions that are checked once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from rlbench_pin.environment.actions.specification import ActionSpec
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.spatial import FloatArray


def as_action(action: object, size: int, what: str) -> FloatArray:
    """Return `action` as a finite float64 vector of `size` numbers, or raise InvalidActionError."""
    try:
        array = np.array(action, dtype=float)
    except (TypeError, ValueError) as error:
        raise InvalidActionError(f"{what} takes {size} numbers, not {action!r}.") from error
    if array.shape != (size,):
        raise InvalidActionError(f"{what} takes an array of shape ({size},), not {array.shape}.")
    if not np.isfinite(array).all():
        bad = ", ".join(str(i) for i in np.flatnonzero(~np.isfinite(array)))
        raise InvalidActionError(f"{what} got NaN or infinity at index {bad}. Check the policy's output.")
    return array


@runtime_checkable
class ChecksValues(Protocol):
    """A mode that refuses some finite numbers."""

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return `values`, shape (n,), or raise InvalidActionError when they mean nothing."""
        ...


@dataclass
class BoundMode:
    """What a mode keeps for one runtime. Modes with solvers keep them in a subclass."""

    spec: ActionSpec | None = None
    """The specification, once it was asked for."""


class SpecifiedMode:
    """A mode whose numbers have a specification. It holds settings only; what belongs to one runtime is kept by that runtime."""

    def bind(self, runtime: Runtime) -> BoundMode:
        """Make what the mode keeps for `runtime`; `Runtime.bound` calls this once."""
        return BoundMode()

    def make_spec(self, runtime: Runtime) -> ActionSpec:
        """Work out what the numbers mean."""
        raise NotImplementedError

    def action_spec(self, runtime: Runtime) -> ActionSpec:
        """Return what the numbers mean."""
        bound = runtime.bound(self)
        if bound.spec is None:
            bound.spec = self.make_spec(runtime)
        return bound.spec

    def action_bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values of an action, each of shape (n,)."""
        spec = self.action_spec(runtime)
        return spec.low.copy(), spec.high.copy()


class PartMode(SpecifiedMode):
    """An arm mode or a gripper mode. Subclasses say what the numbers mean (`make_spec`) and do (`execute`)."""

    def execute(self, runtime: Runtime, values: FloatArray) -> None:
        """Run one action to its end; `values`, shape (n,), are checked."""
        raise NotImplementedError

    def action(self, runtime: Runtime, action: object) -> None:
        """Check one action, then run it to its end.

        Raises:
            InvalidActionError: The action is refused; nothing has moved.
        """
        values = as_action(action, self.action_shape(runtime)[0], type(self).__name__)
        self.execute(runtime, self.check(runtime, values))

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return `values`, shape (n,), or raise InvalidActionError when they mean nothing. Here everything finite is taken."""
        return values

    def action_shape(self, runtime: Runtime) -> tuple[int]:
        """Return the shape of an action."""
        return (self.action_spec(runtime).size,)


class ActionPart(Protocol):
    """What arm modes and gripper modes offer."""

    def action(self, runtime: Runtime, action: FloatArray) -> None:
        """Run one action to its end."""
        ...

    def action_shape(self, runtime: Runtime) -> tuple[int]:
        """Return the shape of an action."""
        ...

    def action_bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values of an action."""
        ...

    def action_spec(self, runtime: Runtime) -> ActionSpec:
        """Return what the numbers mean."""
        ...


def execute(mode: ActionPart, runtime: Runtime, values: FloatArray) -> None:
    """Run numbers that are checked already; a mode with an `action` of its own is given them there."""
    if isinstance(mode, PartMode) and type(mode).action is PartMode.action:
        mode.execute(runtime, values)
    else:
        mode.action(runtime, values)
