"""What goes wrong with policies: those that misbehave, references that lead to none, settings that cannot travel."""

from __future__ import annotations

from typing import Literal

from rlbench_pin.errors import InvalidValue, MissingExtra, RlbenchPinError

LONGEST_DETAIL = 2000
"""So much of what a policy says about its fault is kept."""
FaultKind = Literal["crashed", "timed out", "wrong answer", "unreachable"]
"""How a policy failed."""


class PolicyFault(RlbenchPinError):
    """A policy failed. It costs the episode; the policy is started again, or connected again, at the next `reset`.

    Args:
        kind: How it failed.
        detail: What happened; the same words when it happens again.
        hint: What to do.
        printed: The last lines that the policy printed.
    """

    def __init__(self, kind: FaultKind, detail: str, hint: str = "", printed: str = "") -> None:
        self.kind: FaultKind = kind
        self.detail, self.hint, self.printed = detail, hint, printed
        ending = f"\nIt printed last:\n{printed}" if printed else ""
        super().__init__(f"The policy {_SENTENCES[kind]}: {detail}{f' {hint}' if hint else ''}{ending}")


_SENTENCES = {
    "crashed": "crashed",
    "timed out": "did not answer in time",
    "wrong answer": "gave a wrong answer",
    "unreachable": "cannot be reached",
}


class PolicyReferenceError(InvalidValue):
    """A reference names no policy that could be started."""

    def __init__(self, reference: object, problem: str, hint: str = "") -> None:
        self.reference = reference
        super().__init__("A policy", reference, problem, hint)


class LibraryMissing(MissingExtra):
    """A kind of policy needs a library that is not installed in this environment."""

    def __init__(self, what: str, library: str, hint: str) -> None:
        self.library, self.extra, self.hint = library, "", hint
        RlbenchPinError.__init__(self, f"{what} needs '{library}', which is not installed in this environment. {hint}")


class PolicySettingsError(InvalidValue):
    """The action mode or the observations of a policy are not of this package, or do not exist."""
