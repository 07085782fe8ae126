"""The task `hit_ball_with_queue` under its known name."""

from rlbench.backend.task import Task


class HitBallWithQueue(Task):
    """The task `hit_ball_with_queue` of our library."""

    library_name = "hit_ball_with_queue"
