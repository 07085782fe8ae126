"""The task `hang_frame_on_hanger` under its known name."""

from rlbench.backend.task import Task


class HangFrameOnHanger(Task):
    """The task `hang_frame_on_hanger` of our library."""

    library_name = "hang_frame_on_hanger"
