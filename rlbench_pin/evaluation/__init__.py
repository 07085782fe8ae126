"""How well something does on the tasks: controllers on the legs of demonstrations."""

from rlbench_pin.evaluation.controller_summary import ControllerSummary, summarise_legs, table
from rlbench_pin.evaluation.controller_trials import (
    PLAN,
    Leg,
    LegTrial,
    chosen_controllers,
    follow_demo,
    follow_leg,
    plan_trial,
    record_legs,
)
from rlbench_pin.evaluation.followers import FOLLOWERS, Command, Follower, TrackingProblem

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
