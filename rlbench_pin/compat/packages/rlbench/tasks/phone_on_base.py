"""The task `phone_on_base` under its known name."""

from rlbench.backend.task import Task


class PhoneOnBase(Task):
    """The task `phone_on_base` of our library."""

    library_name = "phone_on_base"
