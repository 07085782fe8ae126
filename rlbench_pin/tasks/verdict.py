"""The verdict on an action: is the goal reached, is the episode over? Asked after every control tick."""

from __future__ import annotations

from rlbench_pin.errors import NoShapedReward
from rlbench_pin.tasks.task import Task


class Verdict:
    """What a task said of the ticks of one action; the first tick that ends the episode counts.

    Args:
        task: The running task.

    Attributes:
        success: Whether the goal was reached.
        over: Whether the episode has ended, by success or by the fail list.
    """

    def __init__(self, task: Task) -> None:
        self._task, self._asked = task, False
        self.success = self.over = False

    def ask(self) -> None:
        """Ask the task about the tick that has just ended; once the episode is over nothing changes."""
        if self.over:
            return
        self._asked = True
        success, over = self._task.success()
        self.success, self.over = bool(success), bool(over)

    def reward(self, shaped: bool = False) -> float:
        """Return 1 when the goal was reached, else 0; when `shaped`, the task's own reward at the present instant.

        Raises:
            NoShapedReward: The task gives none (also a RuntimeError).
        """
        if not shaped:
            return float(self.success)
        reward = self._task.reward()
        if reward is None:
            raise NoShapedReward(self._task.get_name())
        return float(reward)

    def ask_at_least_once(self) -> None:
        """Ask about the present instant where an action took no tick."""
        if not self._asked:
            self.ask()
