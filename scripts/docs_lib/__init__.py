"""Parts of `scripts/build_docs.py`: pages of the site that are written from the code, the scenes and the results."""
