"""The task `beat_the_buzz` under its known name."""

from rlbench.backend.task import Task


class BeatTheBuzz(Task):
    """The task `beat_the_buzz` of our library."""

    library_name = "beat_the_buzz"
