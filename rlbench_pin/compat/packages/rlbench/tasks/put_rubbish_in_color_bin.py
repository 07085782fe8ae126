"""The task `put_rubbish_in_color_bin` under its known name."""

from rlbench.backend.task import Task


class PutRubbishInColorBin(Task):
    """The task `put_rubbish_in_color_bin` of our library."""

    library_name = "put_rubbish_in_color_bin"
