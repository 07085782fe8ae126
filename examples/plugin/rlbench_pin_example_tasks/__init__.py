"""Two example tasks; each is a pair of files with the same stem."""
