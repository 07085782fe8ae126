"""Playing the episodes of an evaluation: which ones, within which limits, what is counted, and results that can be trusted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.environment.episode import EVALUATION_SEEDS
from rlbench_pin.evaluation.run.config import EpisodeItem, EvaluationConfig, evaluation_seed, plan_episodes
from rlbench_pin.evaluation.run.episode import EpisodeOutcome
from rlbench_pin.evaluation.run.evaluate import EvaluationProgress, EvaluationStopped, evaluate
from rlbench_pin.evaluation.run.journal import EvaluationConflict
from rlbench_pin.evaluation.run.runner import EpisodeRunner
from rlbench_pin.front_door import front_door

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

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
