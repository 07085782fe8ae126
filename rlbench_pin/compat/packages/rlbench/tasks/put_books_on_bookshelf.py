"""The task `put_books_on_bookshelf` under its known name."""

from rlbench.backend.task import Task


class PutBooksOnBookshelf(Task):
    """The task `put_books_on_bookshelf` of our library."""

    library_name = "put_books_on_bookshelf"
