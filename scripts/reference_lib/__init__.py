"""Contents of the pages of `scripts/write_reference.py`, one module per page."""
