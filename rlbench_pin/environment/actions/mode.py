"""What all modes share: a specification that is made once per runtime, and actions that are checked once."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from rlbench_pin.environment.actions.specification import ActionSpec
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidActionError, InvalidValue, shown
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_array


def as_action(action: object, size: int, what: str, more: int = 0) -> FloatArray:
    """Return `action` as a finite float64 vector of `size` numbers, or with `more` after them, or raise InvalidActionError."""
    try:
        array = as_array(action, what)
    except InvalidValue as error:
        raise InvalidActionError(f"{what} takes {size} numbers, not {shown(action)}. It {error.problem}.") from error
    if array.shape not in ((size,), (size + more,)):
        shapes = f"({size},)" if more == 0 else f"({size},) or ({size + more},)"
        raise InvalidActionError(f"{what} takes an array of shape {shapes}, not {array.shape}.", "wrong shape")
    if not all(map(math.isfinite, array.tolist())):
        bad = ", ".join(str(i) for i in np.flatnonzero(~np.isfinite(array)))
        raise InvalidActionError(f"{what} got NaN or infinity at index {bad}. Check the policy's output.", "not finite")
    return array.copy()


@runtime_checkable
class ChecksValues(Protocol):
    """A mode that refuses some finite numbers."""

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray | None:
        """Raise InvalidActionError when `values`, shape (n,), mean nothing; return them, or others to take their place."""
        ...


def checked(mode: object, runtime: Runtime, values: FloatArray) -> FloatArray:
    """Return `values`, shape (n,), as a mode wants them, or raise InvalidActionError when it refuses them."""
    result = mode.check(runtime, values) if isinstance(mode, (PartMode, ChecksValues)) else values  # the cheap question first
    return values if result is None else result


@dataclass
class BoundMode:
    """What a mode keeps for one runtime. Modes with solvers keep them in a subclass."""

    _spec: ActionSpec | None = field(default=None, init=False)
    _origin: tuple[object, ...] = field(default=(), init=False)

    def spec(self, origin: tuple[object, ...], make: Callable[[], ActionSpec]) -> ActionSpec:
        """Return the specification.

        Args:
            origin: What it is made from; it is made again when one of these is another object than the last time.
            make: Makes it.
        """
        same = len(origin) == len(self._origin) and all(a is b for a, b in zip(origin, self._origin, strict=True))
        if self._spec is None or not same:
            self._spec, self._origin = make(), origin
        return self._spec


class SpecifiedMode:
    """A mode whose numbers have a specification. It holds settings only; what belongs to one runtime is kept by that runtime.

    Settings may be replaced at any time.
    """

    def bind(self, runtime: Runtime) -> BoundMode:
        """Make what the mode keeps for `runtime`; `Runtime.bound` calls this once."""
        return BoundMode()

    def make_spec(self, runtime: Runtime) -> ActionSpec:
        """Work out what the numbers mean."""
        raise NotImplementedError

    def spec_origin(self, runtime: Runtime) -> tuple[object, ...]:
        """Return what `make_spec` depends on: the settings."""
        return tuple(vars(self).values())

    def action_spec(self, runtime: Runtime) -> ActionSpec:
        """Return what the numbers mean."""
        return runtime.bound(self).spec(self.spec_origin(runtime), lambda: self.make_spec(runtime))

    def action_bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values of an action, each of shape (n,)."""
        spec = self.action_spec(runtime)
        return spec.low.copy(), spec.high.copy()


class PartMode(SpecifiedMode):
    """An arm mode or a gripper mode. Subclasses say what the numbers mean (`make_spec`) and what they do.

    A mode whose action takes one control tick says what comes before and after the tick: `action_pre_step` and
    `action_post_step`. Then other modes can share the tick: all pre-steps, one `runtime.step()`, all post-steps. A mode that
    takes as many ticks as its motion needs overrides `execute`, and `action_step` is the whole motion.

    An action may have `optional_values` further numbers, which the specification leaves out.
    """

    @property
    def optional_values(self) -> int:
        """How many numbers may follow those of the specification, all or none."""
        return 0

    @property
    def takes_one_tick(self) -> bool:
        """Whether an action takes one control tick, so that its pre-step and post-step are all there is to it."""
        return type(self).execute is PartMode.execute and type(self).action is PartMode.action

    def action_pre_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Do what comes before the tick of an action (n,), such as commanding the motors, without stepping. Here nothing."""

    def action_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Run the ticks of an action (n,): one tick, or the whole motion of a mode that has its own `execute`."""
        if type(self).execute is PartMode.execute:
            runtime.step()
        else:
            self.execute(runtime, action)

    def action_post_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Do what comes after the tick of an action (n,), such as holding still, without stepping. Here nothing."""

    def execute(self, runtime: Runtime, values: FloatArray) -> None:
        """Run one action to its end; `values`, shape (n,), are checked."""
        self.action_pre_step(runtime, values)
        self.action_step(runtime, values)
        self.action_post_step(runtime, values)

    def action(self, runtime: Runtime, action: object) -> None:
        """Check one action, then run it to its end.

        Raises:
            InvalidActionError: The action is refused; nothing has moved.
        """
        values = as_action(action, self.action_shape(runtime)[0], type(self).__name__, self.optional_values)
        self.execute(runtime, checked(self, runtime, values))

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray | None:
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
