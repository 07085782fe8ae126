"""The few-shot challenge: learners adapt to unseen tasks from 1, 5 or 20 demonstrations of each."""

from rlbench_pin.evaluation.challenge.config import (
    LEARNERS,
    ChallengeConfig,
    ChallengeConflict,
    ChallengeStopped,
    MetaSplit,
    NoDemonstrations,
    find_learner,
    meta_split,
    meta_splits,
    read_secret,
)
from rlbench_pin.evaluation.challenge.learner import Demonstration, FewShotLearner, TrainingTask
from rlbench_pin.evaluation.challenge.run import ChallengeProgress, LearningCurve, ShotsResult, learning_curve, run_challenge

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
    "read_secret",
    "run_challenge",
]
