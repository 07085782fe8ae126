"""What `scripts/write_reference.py` writes, one module per page."""
