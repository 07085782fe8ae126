"""Evaluations: plan the episodes, play them within limits, count events, and write results with their provenance."""

from __future__ import annotations

from rlbench_pin.environment.episode import EVALUATION_SEEDS
from rlbench_pin.evaluation.run.config import EpisodeItem, EvaluationConfig, evaluation_seed, plan_episodes
from rlbench_pin.evaluation.run.episode import EpisodeOutcome
from rlbench_pin.evaluation.run.evaluate import EvaluationConflict, EvaluationProgress, EvaluationStopped, evaluate
from rlbench_pin.evaluation.run.runner import EpisodeRunner

__all__ = [
    "EVALUATION_SEEDS",
    "EpisodeItem",
    "EpisodeOutcome",
    "EpisodeRunner",
    "EvaluationConfig",
    "EvaluationConflict",
    "EvaluationProgress",
    "EvaluationStopped",
    "evaluate",
    "evaluation_seed",
    "plan_episodes",
]
