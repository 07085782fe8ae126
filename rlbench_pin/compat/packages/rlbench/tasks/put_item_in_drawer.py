"""The task `put_item_in_drawer` under its known name."""

from rlbench.backend.task import Task


class PutItemInDrawer(Task):
    """The task `put_item_in_drawer` of our library."""

    library_name = "put_item_in_drawer"
