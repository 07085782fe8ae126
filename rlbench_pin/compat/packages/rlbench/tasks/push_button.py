"""The task `push_button` under its known name."""

from rlbench.backend.task import Task


class PushButton(Task):
    """The task `push_button` of our library."""

    library_name = "push_button"
