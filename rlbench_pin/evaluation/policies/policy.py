"""Policies and their errors: a policy gets an instruction, then returns one action after the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

import numpy as np

from rlbench_pin.environment.actions.modes import ActionMode
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.errors import InvalidValue, MissingExtra, RlbenchPinError
from rlbench_pin.observation import Observation


@dataclass(frozen=True)
class PolicyContext:
    """Information for a policy at the start of an episode, in addition to the instruction."""

    robot: str
    """Name of the arm, or path of its TOML file."""
    joints: int
    """How many joints it has."""
    action_low: tuple[float, ...]
    """Lowest value of each number of an action."""
    action_high: tuple[float, ...]
    """Highest value of each number of an action."""
    control_period: float
    """Time between two observations of an action mode that acts for one tick [s]."""
    max_steps: int
    """Actions after which the episode is cut off."""
    seed: int
    """For draws of the policy's own. It is a hash: the seed of the episode does not follow from it."""
    task: str = ""
    """Name of the task; empty where it is withheld."""


@runtime_checkable
class Policy(Protocol):
    """Something that is evaluated.

    An attribute `max_steps` suggests how many actions an episode should have. An attribute `joint_names` names the arm joints
    that the policy was made for, in order; an evaluation with another arm is refused.

    Attributes:
        action_mode: What its actions mean; one of this package.
        obs_config: What it wants to observe.
    """

    action_mode: ActionMode
    obs_config: ObservationConfig

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode: forget everything of the one before.

        Args:
            instruction: One sentence that says what to do.
            context: The arm, the bounds of actions, and how long the episode may be.
        """
        ...

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, shape (n,), as `action_mode` takes it.

        Args:
            observation: What `obs_config` asks for. After a refused action it is that of the moment before.
        """
        ...


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


class PolicyOfAnotherArm(PolicySettingsError):
    """A policy was made for other joints than those of the arm.

    Args:
        joint_names: Joints of the policy.
        robot: Name of the arm that was asked for.
        owners: Names of the arms that have the joints of the policy.
        needed: Joints of the arm that was asked for.
    """

    def __init__(self, joint_names: tuple[str, ...], robot: str, owners: tuple[str, ...], needed: tuple[str, ...]) -> None:
        self.joint_names, self.robot, self.owners, self.needed = joint_names, robot, owners, needed
        problem = f"are not those of the arm '{robot}': {', '.join(needed)}"
        hint = f"No arm of the catalogue has them. Use a policy that was made for '{robot}'."
        if owners:
            hint = f"They are joints of '{owners[0]}'. Use `--robot {owners[0]}`, or a policy that was made for '{robot}'."
        super().__init__("The joints of the policy", joint_names, problem, hint)
