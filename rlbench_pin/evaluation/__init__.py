"""How well something does on the tasks: policies on sets of tasks, with their results; controllers on the legs of demonstrations.

The names are looked up when first used, so that a list of sets, or a table, costs no simulator.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door

if TYPE_CHECKING:
    from rlbench_pin.environment.episode import EVALUATION_SEEDS
    from rlbench_pin.evaluation.challenge import (
        LEARNERS,
        ChallengeConfig,
        ChallengeConflict,
        ChallengeProgress,
        ChallengeStopped,
        Demonstration,
        FewShotLearner,
        LearningCurve,
        MetaSplit,
        NoDemonstrations,
        ShotsResult,
        TrainingTask,
        find_learner,
        learning_curve,
        meta_split,
        meta_splits,
        run_challenge,
    )
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
    from rlbench_pin.evaluation.policies import (
        BUILT_IN,
        FunctionPolicy,
        KeyFrame,
        KeyFramePolicy,
        LibraryMissing,
        Policy,
        PolicyClient,
        PolicyContext,
        PolicyFault,
        PolicyReferenceError,
        PolicySettings,
        PolicySettingsError,
        Reference,
        find_policy,
        open_policy,
    )
    from rlbench_pin.evaluation.results.comparison import Comparison, Pairs, TaskComparison, compare
    from rlbench_pin.evaluation.results.file import read_results, results_text, write_results
    from rlbench_pin.evaluation.results.mcnemar import (
        PValues,
        episodes_needed,
        holm,
        mcnemar,
        paired_power,
    )
    from rlbench_pin.evaluation.results.plots import draw_results
    from rlbench_pin.evaluation.results.records import EpisodeRecord, Results
    from rlbench_pin.evaluation.results.statistics import (
        Estimate,
        Summary,
        TaskSummary,
        mean_rate,
        summarise,
        width_note,
    )
    from rlbench_pin.evaluation.results.tables import Table, comparison_table, overview_table, task_table
    from rlbench_pin.evaluation.run.config import EpisodeItem, EvaluationConfig, evaluation_seed, plan_episodes
    from rlbench_pin.evaluation.run.episode import EpisodeOutcome
    from rlbench_pin.evaluation.run.evaluate import EvaluationConflict, EvaluationProgress, EvaluationStopped, evaluate
    from rlbench_pin.evaluation.run.runner import EpisodeRunner
    from rlbench_pin.evaluation.sets.catalogue import (
        TaskSet,
        public_tasks,
        task_set,
        task_sets,
        task_tier,
        variant_tasks,
    )
    from rlbench_pin.evaluation.sets.selection import TaskSelection, resolve_tasks, select_tasks

__all__ = [
    "BUILT_IN",
    "EVALUATION_SEEDS",
    "FOLLOWERS",
    "LEARNERS",
    "PLAN",
    "ChallengeConfig",
    "ChallengeConflict",
    "ChallengeProgress",
    "ChallengeStopped",
    "Command",
    "Comparison",
    "ControllerSummary",
    "Demonstration",
    "EpisodeItem",
    "EpisodeOutcome",
    "EpisodeRecord",
    "EpisodeRunner",
    "Estimate",
    "EvaluationConfig",
    "EvaluationConflict",
    "EvaluationProgress",
    "EvaluationStopped",
    "FewShotLearner",
    "Follower",
    "FunctionPolicy",
    "KeyFrame",
    "KeyFramePolicy",
    "LearningCurve",
    "Leg",
    "LegTrial",
    "LibraryMissing",
    "MetaSplit",
    "NoDemonstrations",
    "PValues",
    "Pairs",
    "Policy",
    "PolicyClient",
    "PolicyContext",
    "PolicyFault",
    "PolicyReferenceError",
    "PolicySettings",
    "PolicySettingsError",
    "Reference",
    "Results",
    "ShotsResult",
    "Summary",
    "Table",
    "TaskComparison",
    "TaskSelection",
    "TaskSet",
    "TaskSummary",
    "TrackingProblem",
    "TrainingTask",
    "chosen_controllers",
    "compare",
    "comparison_table",
    "draw_results",
    "episodes_needed",
    "evaluate",
    "evaluation_seed",
    "find_learner",
    "find_policy",
    "follow_demo",
    "follow_leg",
    "holm",
    "learning_curve",
    "mcnemar",
    "mean_rate",
    "meta_split",
    "meta_splits",
    "open_policy",
    "overview_table",
    "paired_power",
    "plan_episodes",
    "plan_trial",
    "public_tasks",
    "read_results",
    "record_legs",
    "resolve_tasks",
    "results_text",
    "run_challenge",
    "select_tasks",
    "summarise",
    "summarise_legs",
    "table",
    "task_set",
    "task_sets",
    "task_table",
    "task_tier",
    "variant_tasks",
    "width_note",
    "write_results",
]

_HOMES = {
    **dict.fromkeys((
        "LEARNERS", "ChallengeConfig", "ChallengeConflict", "ChallengeProgress", "ChallengeStopped", "Demonstration",
        "FewShotLearner", "LearningCurve", "MetaSplit", "NoDemonstrations", "ShotsResult", "TrainingTask", "find_learner",
        "learning_curve", "meta_split", "meta_splits", "run_challenge",
    ), "challenge"),
    **dict.fromkeys((
        "FOLLOWERS", "Command", "Follower", "TrackingProblem",
    ), "controllers.followers"),
    **dict.fromkeys((
        "ControllerSummary", "summarise_legs", "table",
    ), "controllers.summary"),
    **dict.fromkeys((
        "PLAN", "Leg", "LegTrial", "chosen_controllers", "follow_demo", "follow_leg", "plan_trial", "record_legs",
    ), "controllers.trials"),
    **dict.fromkeys((
        "BUILT_IN", "FunctionPolicy", "KeyFrame", "KeyFramePolicy", "LibraryMissing", "Policy", "PolicyClient", "PolicyContext",
        "PolicyFault", "PolicyReferenceError", "PolicySettings", "PolicySettingsError", "Reference", "find_policy", "open_policy",
    ), "policies"),
    **dict.fromkeys((
        "Comparison", "Pairs", "TaskComparison", "compare",
    ), "results.comparison"),
    **dict.fromkeys((
        "read_results", "results_text", "write_results",
    ), "results.file"),
    **dict.fromkeys((
        "PValues", "episodes_needed", "holm", "mcnemar", "paired_power",
    ), "results.mcnemar"),
    **dict.fromkeys((
        "draw_results",
    ), "results.plots"),
    **dict.fromkeys((
        "EpisodeRecord", "Results",
    ), "results.records"),
    "EVALUATION_SEEDS": "rlbench_pin.environment.episode",
    **dict.fromkeys((
        "EpisodeItem", "EvaluationConfig", "evaluation_seed", "plan_episodes",
    ), "run.config"),
    "EpisodeOutcome": "run.episode",
    **dict.fromkeys((
        "EvaluationProgress", "EvaluationStopped", "evaluate",
    ), "run.evaluate"),
    "EvaluationConflict": "run.evaluate",
    "EpisodeRunner": "run.runner",
    **dict.fromkeys((
        "Estimate", "Summary", "TaskSummary", "mean_rate", "summarise", "width_note",
    ), "results.statistics"),
    **dict.fromkeys((
        "Table", "comparison_table", "overview_table", "task_table",
    ), "results.tables"),
    **dict.fromkeys((
        "TaskSet", "public_tasks", "task_set", "task_sets", "task_tier", "variant_tasks",
    ), "sets.catalogue"),
    **dict.fromkeys((
        "TaskSelection", "resolve_tasks", "select_tasks",
    ), "sets.selection"),
}  # fmt: skip

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__, _HOMES)
