"""The task `close_jar` under its known name."""

from rlbench.backend.task import Task


class CloseJar(Task):
    """The task `close_jar` of our library."""

    library_name = "close_jar"
