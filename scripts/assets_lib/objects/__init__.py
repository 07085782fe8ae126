"""One module per family of objects."""
