"""The text of a scene file, edited in place."""
