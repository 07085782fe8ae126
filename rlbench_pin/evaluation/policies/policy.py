"""What a policy is: it is told what to do, then asked for one action after the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from rlbench_pin.environment.actions.mode import ActionMode
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.observation import Observation


@dataclass(frozen=True)
class PolicyContext:
    """What a policy is told at the start of an episode, beside the instruction."""

    robot: str
    """Name of the arm."""
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
