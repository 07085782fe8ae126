"""The task `open_microwave` under its known name."""

from rlbench.backend.task import Task


class OpenMicrowave(Task):
    """The task `open_microwave` of our library."""

    library_name = "open_microwave"
