"""The task `open_jar` under its known name."""

from rlbench.backend.task import Task


class OpenJar(Task):
    """The task `open_jar` of our library."""

    library_name = "open_jar"
