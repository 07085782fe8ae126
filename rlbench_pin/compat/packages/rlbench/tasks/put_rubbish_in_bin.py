"""The task `put_rubbish_in_bin` under its known name."""

from rlbench.backend.task import Task


class PutRubbishInBin(Task):
    """The task `put_rubbish_in_bin` of our library."""

    library_name = "put_rubbish_in_bin"
