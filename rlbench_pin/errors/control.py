"""Commands that a controller cannot give."""

from __future__ import annotations

from rlbench_pin.errors.base import InvalidValue, RlbenchPinError


class ControlError(RlbenchPinError):
    """A controller cannot do what it was asked."""


class InvalidTarget(ControlError, InvalidValue):
    """A controller was given a target or a state that is not valid: NaN, a wrong shape, a quaternion of norm zero."""


class InfeasibleControl(ControlError):
    """No command satisfies the constraints of a controller; carries the problem that has no solution."""

    def __init__(self, controller: str, cause: str, problem: object = None) -> None:
        self.controller, self.cause, self.problem = controller, cause, problem
        super().__init__(f"{controller} found no command: {cause}. Stop the arm, or relax the constraint.")
