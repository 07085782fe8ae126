"""Two tasks of our own: each is a pair of files with one stem."""
