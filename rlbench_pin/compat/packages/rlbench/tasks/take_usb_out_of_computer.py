"""The task `take_usb_out_of_computer` under its known name."""

from rlbench.backend.task import Task


class TakeUsbOutOfComputer(Task):
    """The task `take_usb_out_of_computer` of our library."""

    library_name = "take_usb_out_of_computer"
