"""The task `solve_puzzle` under its known name."""

from rlbench.backend.task import Task


class SolvePuzzle(Task):
    """The task `solve_puzzle` of our library."""

    library_name = "solve_puzzle"
