"""The validator: what every task must keep, measured and reported."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.checking.explain import explain_failure
from rlbench_pin.checking.failures import Failure
from rlbench_pin.checking.journal import TrialJournal
from rlbench_pin.checking.judge import Rest
from rlbench_pin.checking.pool import CheckProgress, run_trials
from rlbench_pin.checking.reach import Reach
from rlbench_pin.checking.records import (
    DemoTrial,
    IdleTrial,
    KeyFramesTrial,
    Part,
    RandomTrial,
    ReachTrial,
    RepeatTrial,
    Trial,
    WordsTrial,
)
from rlbench_pin.checking.report import TaskReport, summarise
from rlbench_pin.checking.trials import Item
from rlbench_pin.front_door import front_door
from rlbench_pin.rates import Rate

__all__ = [
    "CheckProgress",
    "DemoTrial",
    "Failure",
    "IdleTrial",
    "Item",
    "KeyFramesTrial",
    "Part",
    "RandomTrial",
    "Rate",
    "Reach",
    "ReachTrial",
    "RepeatTrial",
    "Rest",
    "TaskReport",
    "Trial",
    "TrialJournal",
    "WordsTrial",
    "explain_failure",
    "run_trials",
    "summarise",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
