"""The task `insert_usb_in_computer` under its known name."""

from rlbench.backend.task import Task


class InsertUsbInComputer(Task):
    """The task `insert_usb_in_computer` of our library."""

    library_name = "insert_usb_in_computer"
