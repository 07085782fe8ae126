"""What can be wrong with a run of the challenge, beside what can be wrong with an evaluation."""

from __future__ import annotations

from pathlib import Path

from rlbench_pin.errors import RlbenchPinError, shown


class ChallengeConflict(RlbenchPinError):
    """Where a run of the challenge is to be written, there is another one."""

    @classmethod
    def between(cls, path: Path, name: str, then: object, now: object) -> ChallengeConflict:
        """Return the error that says what differs."""
        return cls(
            f"'{path}' is of a run with {name} = {shown(then)}, this is {name} = {shown(now)}. "
            "Choose another folder with `--out`."
        )


class ChallengeStopped(RlbenchPinError):
    """A run of the challenge was stopped before its end; what is done is kept."""

    def __init__(self, stage: str, done: int, wanted: int, folder: Path) -> None:
        self.stage, self.done, self.wanted, self.folder = stage, done, wanted, folder
        super().__init__(f"{stage}: {done} of {wanted} are done and kept in '{folder}'. Go on with `--resume`.")


class NoDemonstrations(RlbenchPinError):
    """A task of the test could not be demonstrated often enough."""

    def __init__(self, task: str, seed: int, cause: str) -> None:
        self.task, self.seed, self.cause = task, seed, cause
        super().__init__(
            f"There is no demonstration of '{task}' from seed {seed}: {cause} `rlbench-pin check {task}` shows how often that "
            "happens; another `--seed` uses other demonstrations."
        )
