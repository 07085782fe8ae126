"""The task `put_books_at_shelf_location` under its known name."""

from rlbench.backend.task import Task


class PutBooksAtShelfLocation(Task):
    """The task `put_books_at_shelf_location` of our library."""

    library_name = "put_books_at_shelf_location"
