"""The task `play_jenga` under its known name."""

from rlbench.backend.task import Task


class PlayJenga(Task):
    """The task `play_jenga` of our library."""

    library_name = "play_jenga"
