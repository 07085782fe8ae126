"""The validator: it measures whether tasks fulfil their contract, and writes reports."""

from __future__ import annotations

from rlbench_pin.checking.explain import explain_failure
from rlbench_pin.checking.reach import Reach
from rlbench_pin.checking.records import (
    DemoTrial,
    FrictionTrial,
    KeyFramesTrial,
    NoopTrial,
    Part,
    RandomTrial,
    ReachTrial,
    RepeatTrial,
    Trial,
    WordsTrial,
)
from rlbench_pin.checking.report import Failure, TaskReport, summarise
from rlbench_pin.checking.run import CheckProgress, TrialJournal, run_trials
from rlbench_pin.checking.trials import Item
from rlbench_pin.checking.validate import NoopEpisode
from rlbench_pin.rates import Rate

__all__ = [
    "CheckProgress",
    "DemoTrial",
    "Failure",
    "FrictionTrial",
    "Item",
    "KeyFramesTrial",
    "NoopEpisode",
    "NoopTrial",
    "Part",
    "RandomTrial",
    "Rate",
    "Reach",
    "ReachTrial",
    "RepeatTrial",
    "TaskReport",
    "Trial",
    "TrialJournal",
    "WordsTrial",
    "explain_failure",
    "run_trials",
    "summarise",
]
