"""How long an episode may be."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rlbench_pin.environment.actions import ActionMode, EndEffectorPoseViaPlanning, unwrapped
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.run.config import EvaluationConfig

KEY_FRAMES = 25
"""Actions of an episode at most, unless said otherwise, where each plans a motion to a pose."""


@dataclass(frozen=True)
class Limits:
    """Where an episode is cut off."""

    steps: int
    """Actions."""
    seconds: float
    """Simulated time [s]."""

    @classmethod
    def of(cls, config: EvaluationConfig, settings: PolicySettings, mode: ActionMode, control_period: float) -> Limits:
        """Return the limits of a policy's episodes.

        Args:
            config: What the user asks for, which goes first.
            settings: What the policy suggests, which goes second.
            mode: Its action mode: 25 for one that plans motions to poses, otherwise as many ticks as the seconds have.
            control_period: Time of a control tick [s].
        """
        ticks = math.ceil(config.max_seconds / control_period)
        usual = KEY_FRAMES if isinstance(unwrapped(mode.arm_action_mode), EndEffectorPoseViaPlanning) else ticks
        return cls(config.max_steps or settings.max_steps or usual, config.max_seconds)
