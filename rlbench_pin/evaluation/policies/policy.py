"""The interface of policies, and their errors. A policy gets an instruction, then returns one action after the other."""

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
    """Number of joints of the arm."""
    action_low: tuple[float, ...]
    """Lower bound of each number of an action."""
    action_high: tuple[float, ...]
    """Upper bound of each number of an action."""
    control_period: float
    """Time between two observations of an action mode that acts for one tick [s]."""
    max_steps: int
    """Maximum number of actions of the episode."""
    seed: int
    """Seed for random numbers of the policy. It is a hash that does not reveal the seed of the episode."""
    task: str = ""
    """Name of the task; empty if it is withheld."""


@runtime_checkable
class Policy(Protocol):
    """Interface of a policy.

    The optional attribute `max_steps` suggests the maximum number of actions of an episode. The optional attribute `joint_names`
    contains the arm joints that the policy was made for, in order; an evaluation with another arm is refused.

    Attributes:
        action_mode: Action mode of the policy; a mode of this package.
        obs_config: Observations that the policy gets.
    """

    action_mode: ActionMode
    obs_config: ObservationConfig

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode: discard all state of the previous one.

        Args:
            instruction: One sentence that describes the goal.
            context: The arm, the bounds of actions, and the limits of the episode.
        """
        ...

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, shape (n,), in the form of `action_mode`.

        Args:
            observation: Observation with the data of `obs_config`. After a refused action it is the previous observation.
        """
        ...


LONGEST_DETAIL = 2000
"""Maximum number of characters that are kept of the error of a policy."""
FaultKind = Literal["crashed", "timed out", "wrong answer", "unreachable"]
"""Kind of the failure of a policy."""


class PolicyFault(RlbenchPinError):
    """A policy failed, and with it the episode. The next `reset` starts the policy again, or connects again.

    Args:
        kind: Kind of the failure.
        detail: Description of the failure; the same failure has the same text.
        hint: The next step.
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
    """A reference names no policy that can be started."""

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
    """A policy was made for the joints of another arm.

    Args:
        joint_names: Joints of the policy.
        robot: Name of the arm of the evaluation.
        owners: Names of the arms that have the joints of the policy.
        needed: Joints of the arm of the evaluation.
    """

    def __init__(self, joint_names: tuple[str, ...], robot: str, owners: tuple[str, ...], needed: tuple[str, ...]) -> None:
        self.joint_names, self.robot, self.owners, self.needed = joint_names, robot, owners, needed
        problem = f"are not those of the arm '{robot}': {', '.join(needed)}"
        hint = f"No arm of the catalogue has them. Use a policy that was made for '{robot}'."
        if owners:
            hint = f"They are joints of '{owners[0]}'. Use `--robot {owners[0]}`, or a policy that was made for '{robot}'."
        super().__init__("The joints of the policy", joint_names, problem, hint)
