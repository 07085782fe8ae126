"""The few-shot challenge: learners meet unseen tasks, with 1, 5 or 20 demonstrations of each, and nothing else."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.evaluation.challenge.config import ChallengeConfig
from rlbench_pin.evaluation.challenge.faults import ChallengeConflict, ChallengeStopped, NoDemonstrations
from rlbench_pin.evaluation.challenge.learner import Demonstration, FewShotLearner, TrainingTask
from rlbench_pin.evaluation.challenge.references import LEARNERS, find_learner
from rlbench_pin.evaluation.challenge.run import ChallengeProgress, run_challenge
from rlbench_pin.evaluation.challenge.splits import MetaSplit, meta_split, meta_splits
from rlbench_pin.evaluation.challenge.summary import LearningCurve, ShotsResult, learning_curve
from rlbench_pin.front_door import front_door

__all__ = [
    "LEARNERS",
    "ChallengeConfig",
    "ChallengeConflict",
    "ChallengeProgress",
    "ChallengeStopped",
    "Demonstration",
    "FewShotLearner",
    "LearningCurve",
    "MetaSplit",
    "NoDemonstrations",
    "ShotsResult",
    "TrainingTask",
    "find_learner",
    "learning_curve",
    "meta_split",
    "meta_splits",
    "run_challenge",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
