"""What a worker of the challenge does: episodes of policies that were made from demonstrations of their task."""

from __future__ import annotations

from contextlib import nullcontext
from functools import partial
from pathlib import Path

from rlbench_pin.evaluation.challenge.client import LearnerClient
from rlbench_pin.evaluation.challenge.config import ChallengeConfig
from rlbench_pin.evaluation.challenge.demonstrations import ShownDemonstrations
from rlbench_pin.evaluation.challenge.learned import read_learned
from rlbench_pin.evaluation.policies.settings import PolicySettings
from rlbench_pin.evaluation.run.config import EpisodeItem, EvaluationConfig
from rlbench_pin.evaluation.run.episode import EpisodeOutcome
from rlbench_pin.evaluation.run.runner import Around, EpisodeRunner


class ShotsRunner(EpisodeRunner):
    """Plays episodes of test tasks; before the first of each, a new process of the learner adapts to it.

    Args:
        challenge: The run.
        folder: Where it keeps demonstrations, and what was learned.
        shots: Demonstrations of each task.
        settings: What the learner asks for.
        config: What is evaluated.
    """

    def __init__(
        self, challenge: ChallengeConfig, folder: Path, shots: int, settings: PolicySettings, config: EvaluationConfig
    ) -> None:
        self._learner = open_learner(challenge, folder, settings)
        super().__init__(config, self._learner)
        self._demonstrations, self._shots = ShownDemonstrations(folder / DEMONSTRATIONS), shots
        self._learned, self._shown = read_learned(folder / LEARNED), ""

    def play(self, item: EpisodeItem, around: Around = lambda task: nullcontext()) -> EpisodeOutcome:
        """Play an episode.

        Args:
            item: Which one.
            around: Makes what is around it from its start to its end.
        """
        if self._shown != item.name:
            self._learner.show(partial(self._demonstrations.read, item.name, self._shots), self._learned)
            self._shown = item.name
        return super().play(item, around)


DEMONSTRATIONS, LEARNED = "demonstrations", "learned.msgpack"
"""Where a run keeps demonstrations of test tasks, and what was learned from the others."""


def open_learner(config: ChallengeConfig, folder: Path, known: PolicySettings | None = None) -> LearnerClient:
    """Return the learner of a run; it starts when it is first asked for something.

    Once there are demonstrations in the folder of the run, it is kept out of that.
    """
    limits = config.time_limit, config.start_limit, config.adapt_limit
    return LearnerClient(config.learner, config.seed, *limits, folder if (folder / DEMONSTRATIONS).exists() else None, known)
