"""The task `take_frame_off_hanger` under its known name."""

from rlbench.backend.task import Task


class TakeFrameOffHanger(Task):
    """The task `take_frame_off_hanger` of our library."""

    library_name = "take_frame_off_hanger"
