"""The task `insert_onto_square_peg` under its known name."""

from rlbench.backend.task import Task


class InsertOntoSquarePeg(Task):
    """The task `insert_onto_square_peg` of our library."""

    library_name = "insert_onto_square_peg"
