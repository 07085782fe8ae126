"""The text of a Python file, edited in place."""
