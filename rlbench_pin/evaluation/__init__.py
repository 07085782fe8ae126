"""How well something does on the tasks: controllers on the legs of demonstrations."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.evaluation.controllers.followers import FOLLOWERS, Command, Follower, TrackingProblem
from rlbench_pin.evaluation.controllers.summary import ControllerSummary, summarise_legs, table
from rlbench_pin.evaluation.controllers.trials import (
    PLAN,
    Leg,
    LegTrial,
    chosen_controllers,
    follow_demo,
    follow_leg,
    plan_trial,
    record_legs,
)
from rlbench_pin.front_door import front_door

__all__ = [
    "FOLLOWERS",
    "PLAN",
    "Command",
    "ControllerSummary",
    "Follower",
    "Leg",
    "LegTrial",
    "TrackingProblem",
    "chosen_controllers",
    "follow_demo",
    "follow_leg",
    "plan_trial",
    "record_legs",
    "summarise_legs",
    "table",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
