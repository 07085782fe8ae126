"""The task `push_buttons` under its known name."""

from rlbench.backend.task import Task


class PushButtons(Task):
    """The task `push_buttons` of our library."""

    library_name = "push_buttons"
